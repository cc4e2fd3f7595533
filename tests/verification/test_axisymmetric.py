#!/usr/bin/env python3
"""Axial symmetry: Lame's cylinder and its plastic limit, uniform pressure up to the axis, consolidation, free fall of a ring, a plate,
forms of the Jacobian, penalties, ranks, refused scenes. Quick.

Lame (1852) and, for the limit of a von Mises cylinder in plane strain, Hill (1950), The mathematical theory of
plasticity: p = (2/sqrt 3) sigma_y ln(b/a).
"""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import Test, difference, example  # noqa: E402

INNER, OUTER, E, NU = 1.0, 2.0, 1e6, 0.3
BASE = """
mpm:
  dim: 2
  kinematics: axisymmetric
  grid: {lower: "%s", upper: "%s", cells: "%s"}
  shape: %s
  materials: m
  material_m: {%s}
  bodies: ring
  body_ring: {region: box, lower: "%s", upper: "%s", points_per_cell: "2,2", material: m}
"""
CYLINDER = """
  bcs: base,top
  bc_base: {region: box, lower: "0,0", upper: "3,0", components: "y"}
  bc_top: {region: box, lower: "0,0.5", upper: "3,0.5", components: "y"}
  surfaces: inner
  surface_inner: {body: ring, side: "-x", normal: %g}
  time: {end: 1, step: %g}
  output: {prefix: ring}
"""
KINDS = ("plane_strain", "axisymmetric")
ELASTIC = f"type: linear_elastic, E: {E}, nu: {NU}, density: 0"


def cylinder(cells, shape="gimp_bspline2", law=ELASTIC, pressure=10.0, step=1.0):
    """The wall from 1 to 2 m, as high as 0.5 m, on a grid of its own width; pressure inside."""
    return BASE % ("1,0", "2,0.5", f"{cells},4", shape, law, "1,0", "2,0.5") + CYLINDER % (-pressure, step)


def written(test, text):
    """The scene as a file."""
    scene = test.folder() / "case.yaml"
    scene.write_text(text)
    return scene


def lame(test):
    """Stress and displacement of second order in h."""
    factor = 10.0 * INNER**2 / (OUTER**2 - INNER**2)
    errors = []
    for cells in (8, 16, 32):
        state = test.run(written(test, cylinder(cells)), mpm_shape_edge="open").results.state("last")
        r = state["position"][:, 0]
        exact = np.stack([factor * (1 - (OUTER / r) ** 2), factor * (1 + (OUTER / r) ** 2)], 1)
        moved = (1 + NU) / E * factor * ((1 - 2 * NU) * r + OUTER**2 / r)
        errors.append([np.sqrt(np.mean((state["stress"][:, [0, 2]] - exact) ** 2)) / 10.0,
                       np.abs(state["displacement"][:, 0] / moved - 1).max()])
    errors = np.array(errors)
    test.check("lame.stress", errors[-1, 0], None, 6e-4)
    test.check("lame.displacement", errors[-1, 1], None, 2e-4)
    for k, name in enumerate(("stress", "displacement")):
        test.check(f"lame.{name}_order", np.log2(errors[0, k] / errors[2, k]) / 2, 1.7)


def limit(test):
    """A von Mises cylinder bears its limit load within 1 %."""
    law = f"type: j2, E: {E}, nu: {NU}, yield_stress: 1e3, density: 0"
    run = test.run(written(test, cylinder(16, "gimp", law, 1000.0, 0.01)), status=3)
    test.near("limit", run.results.column("time")[-1], 2 / np.sqrt(3) * np.log(OUTER / INNER), relative=0.01)


def pressure(test):
    """A solid cylinder under pressure on all sides has one stress up to the axis, whatever the shape."""
    scene = BASE % ("0,0", "1.5,1.5", "6,6", "gimp", f"type: neo_hookean, E: {E}, nu: {NU}, density: 0", "0,0", "1,1")
    scene += """
  bcs: base
  bc_base: {region: box, lower: "0,0", upper: "3,0", components: "y"}
  surfaces: outer,top
  surface_outer: {body: ring, side: "+x", normal: -1e5}
  surface_top: {body: ring, side: "+y", normal: -1e5}
  time: {end: 1, step: 0.2}
  output: {prefix: ring}
"""
    for shape, most in (("gimp", 1e-8), ("gimp_bspline2", 1e-8)):
        stress = test.run(written(test, scene), mpm_shape=shape).results.state("last")["stress"]
        test.check(f"pressure.{shape}", np.abs(stress[:, :3] / -1e5 - 1).max(), None, most)


def water(test):
    """A column that drains along the axis is that of plane strain."""
    options = {"mpm_time_end": 4e6, "mpm_output_every": 10}
    case = example("terzaghi")
    states = [test.run(case, mpm_kinematics=kind, **options).results.state("last") for kind in KINDS]
    for field in ("displacement", "stress", "pressure"):
        test.check(f"water.{field}", difference(states[0][field], states[1][field]), None, 1e-9)


def fall(test):
    """A ring in free fall keeps its shape, explicit and implicit."""
    scene = BASE % ("0,0", "2,4", "8,16", "gimp", f"type: neo_hookean, E: {E}, nu: {NU}, density: 1000", "0.5,3", "1,3.5") + """
  loads: weight
  load_weight: {type: gravity, value: "0,-10", ramp: "0:1"}
  time: {integrator: explicit, end: 0.2, step: 1e-3}
  output: {prefix: ring, every: 1000}
"""
    for integrator, step in (("explicit", 1e-3), ("generalized_alpha", 1e-2)):
        state = test.run(written(test, scene), mpm_time_integrator=integrator, mpm_time_step=step).results.state("last")
        test.check(f"fall.{integrator}.velocity", np.abs(state["velocity"] - [0, -2]).max(), None, 1e-6)
        test.check(f"fall.{integrator}.stress", np.abs(state["stress"]).max() / E, None, 1e-8)


def plate(test):
    """A plate presses on a full turn: E pi R^2 times the strain of a bar without Poisson's effect."""
    scene = BASE % ("0,0", "1.5,1.5", "12,12", "gimp", f"type: hencky, E: {E}, nu: 0, density: 0", "0,0", "1,1") + """
  bcs: base
  bc_base: {region: box, lower: "0,0", upper: "3,0", components: "y"}
  boundaries: plate
  boundary_plate: {type: plane, point: "0,1", normal: "0,-1", motion: "0,-0.01", penalty: 1e3}
  time: {end: 1, step: 0.5}
  output: {prefix: ring}
"""
    force = test.run(written(test, scene)).results.column("reaction_plate_y")[-1]
    test.near("plate.force", abs(force), -E * np.log(0.99) / 0.99 * np.pi, relative=2e-3)


def forms(test):
    """Forms of the Jacobian and ranks lead to the same answer."""
    law = f"type: neo_hookean, E: {E}, nu: {NU}, density: 0"
    scene = cylinder(8, "gimp", law, 1e5, 0.5).replace('"2,0.5"', '"2.5,0.5"', 1).replace('"8,4"', '"12,4"', 1)
    run = test.run(written(test, scene))
    reference = run.results.state("last")["displacement"]
    for form in ("coloring", "matfree"):
        other = test.run(written(test, scene), mpm_jacobian=form)
        test.check(f"forms.{form}", difference(reference, other.results.state("last")["displacement"]), None, 1e-8)
    for ranks in (3,):
        other = test.run(written(test, scene), ranks=ranks).results.state("last")
        test.check("forms.ranks", difference(reference, other["displacement"]), None, 1e-9)


def penalties(test):
    """Ghost and interior penalties: linear scenes take one Newton iteration a step, with a Jacobian of the same weights."""
    for name in ("ghost", "interior"):
        run = test.run(written(test, cylinder(8, "gimp")), **{f"mpm_stabilization_{name}": 0.1})
        test.check(f"penalties.{name}.iterations", run.newton.max(), None, 1)


def refused(test):
    """What no ring has is refused, with the name of the option."""
    scene = written(test, cylinder(8))
    gravity = {"mpm_loads": "w", "mpm_load_w_type": "gravity", "mpm_load_w_value": "1,0", "mpm_material_m_density": 1}
    free = {"mpm_boundaries": "b", "mpm_boundary_b_type": "plane", "mpm_boundary_b_point": "0,0.6",
            "mpm_boundary_b_normal": "0,-1", "mpm_boundary_b_free": "x"}
    for name, options in (("-mpm_kinematics", {"mpm_dim": 3}), ("-mpm_grid_lower", {"mpm_grid_lower": "-1,0"}),
                          ("-mpm_load_w_value", gravity), ("-mpm_boundary_b_free", free),
                          ("-mpm_kinematics", {"mpm_physics": "stress_point"})):
        run = test.run(scene, status=2, **options)
        test.check(f"refused.{name}", int(f"error: {name}" in run.errors + run.output), 1)


if __name__ == "__main__":
    with Test() as test:
        for part in (lame, limit, pressure, water, fall, plate, forms, penalties, refused):
            part(test)
