#!/usr/bin/env python3
"""Axial symmetry, stages of ground and water: level ground at rest, layers that are removed and added, an unlined shaft, a restart,
a water level, steady flow to a well, triaxial samples. Quick.

Shaft: Lame (1852). Well: Thiem (1906), p - p_a = q ln(r/a) / (2 pi k H / eta).
"""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import Test, difference  # noqa: E402

SHAPES = ("linear", "gimp", "bspline2", "gimp_bspline2")
WEIGHT, K0, HEIGHT = 20e3, 0.6, 2.0  # N/m3, -, m
LEVEL = """
mpm:
  dim: 2
  kinematics: axisymmetric
  grid: {lower: "%g,0", upper: "%g,3", cells: "6,12"}
  shape: gimp
  materials: clay
  material_clay: {type: j2, E: 20e6, nu: 0.3, density: 2000, yield_stress: 1e9}
  bodies: low,high
  body_low: {region: box, lower: "%g,0", upper: "%g,1", points_per_cell: "2,2", material: clay}
  body_high: {region: box, lower: "%g,1", upper: "%g,2", points_per_cell: "2,2", material: clay}
  bcs: base,inner,outer
  bc_base: {region: box, lower: "0,0", upper: "9,0", components: "x,y"}
  bc_inner: {region: box, lower: "%g,0", upper: "%g,3", components: "x"}
  bc_outer: {region: box, lower: "%g,0", upper: "%g,3", components: "x"}
  loads: weight
  load_weight: {type: gravity, value: "0,-10"}
  stages: rest
  stage_rest: {type: geostatic, geostatic: {method: k0, k0: %g}}
  time: {end: 1, step: 0.25}
  output: {prefix: level}
"""


def level(inner):
    """Ground of two layers between two radii 1.5 m apart."""
    outer = inner + 1.5
    return LEVEL % (inner, outer, inner, outer, inner, outer, inner, inner, outer, outer, K0)


def written(test, text):
    """The scene as a file."""
    scene = test.folder() / "case.yaml"
    scene.write_text(text)
    return scene


def departure(state, vertical, ratio):
    """Largest difference of the stress from a vertical one and that times a ratio, over the weight of the ground."""
    exact = np.stack([ratio * vertical, vertical, ratio * vertical, 0 * vertical], 1)
    return np.abs(state["stress"][:, :4] - exact).max() / (WEIGHT * HEIGHT)


def rest(test):
    """Level ground stays at rest: on the axis and beyond it, for all shapes; hoop stress is that along the radius."""
    wait = {"mpm_stages": "rest,wait", "mpm_stage_wait_time_end": 1, "mpm_stage_wait_time_step": 1}
    for inner in (0.0, 1.0):
        for shape in SHAPES:
            states = [test.run(written(test, level(inner)), mpm_shape=shape, mpm_kinematics=kind, **wait).results.state("last")
                      for kind in ("axisymmetric", "plane_strain")]
            label = f"rest.{inner:g}.{shape}"
            stress = states[0]["stress"]
            far, plane = (departure(state, -WEIGHT * (HEIGHT - state["position"][:, 1]), K0) for state in states)
            test.check(f"{label}.stress", far, None, max(plane, 0.04 if shape == "bspline2" else 1e-9))  # splines: nor in plane strain
            test.check(f"{label}.ratio", np.abs(stress[:, [0, 2]] - K0 * stress[:, [1]]).max() / (WEIGHT * HEIGHT), None, 1e-9)
            test.check(f"{label}.moved", np.abs(states[0]["displacement"]).max(), None, 1e-9)


def gravity(test):
    """Weight that grows from nothing: ratio nu/(1 - nu) of an elastic layer."""
    state = test.run(written(test, level(0.0)), mpm_stage_rest_geostatic_method="gravity").results.state("last")
    ratio = state["stress"][:, [0, 2]] / state["stress"][:, [1]]
    test.check("gravity.radial", np.abs(ratio[:, 0] / (0.3 / 0.7) - 1).max(), None, 5e-3)
    test.check("gravity.hoop", difference(ratio[:, 0], ratio[:, 1]), None, 1e-6)


def layers(test):
    """The upper layer is removed and added again: the lower one loses and gains its weight; restart and ranks."""
    options = {"mpm_stages": "rest,cut,fill", "mpm_stage_cut_remove": "high", "mpm_stage_fill_bodies": "lift",
               "mpm_bodies": "low,high,lift", "mpm_body_lift_region": "box", "mpm_body_lift_lower": "0,1",
               "mpm_body_lift_upper": "1.5,2", "mpm_body_lift_material": "clay",
               "mpm_checkpoint_every": 1, "mpm_checkpoint_keep": 99, "mpm_output_every": 1}
    for stage in ("cut", "fill"):
        options |= {f"mpm_stage_{stage}_time_end": 1, f"mpm_stage_{stage}_time_step": 0.25}
    scene = written(test, level(0.0))
    run = test.run(scene, **options)
    force = run.results.column("reaction_base_y") / (np.pi * 1.5**2 * WEIGHT)
    test.check("layers.force", np.abs(force - [2, 1.75, 1.5, 1.25, 1, 2, 2, 2, 2]).max(), None, 1e-6)
    state = run.results.state(5)
    height = state["position"][:, 1]
    change = state["stress"][:, :3] - np.stack([K0, 1.0, K0]) * (-WEIGHT * (HEIGHT - height))[:, None]
    test.check("layers.unloaded", np.abs(change / (WEIGHT * np.array([3 / 7, 1, 3 / 7])) - 1).max(), None, 5e-3)
    again = test.run(scene, mpm_restart=run.folder / "level_checkpoint_000003.h5", **options)
    for name in ("reaction_base_y", "newton"):
        test.check(f"layers.restart.{name}", difference(run.results.column(name)[3:], again.results.column(name)[-6:]), None, 1e-12)
    test.check("layers.restart.stress", difference(run.table("stress"), again.table("stress")), None, 1e-12)
    test.check("layers.ranks", difference(run.table("stress"), test.run(scene, ranks=3, **options).table("stress")), None, 1e-9)


SHAFT = """
mpm:
  dim: 2
  kinematics: axisymmetric
  grid: {lower: "0,0", upper: "3.25,0.5", cells: "52,8"}
  shape: gimp_bspline2
  materials: rock
  material_rock: {type: linear_elastic, E: 1e9, nu: 0.25, density: 2500}
  bodies: core,ring
  body_core: {region: box, lower: "0,0", upper: "1,0.5", points_per_cell: "2,2", material: rock, initial_stress: "-1e5"}
  body_ring: {region: box, lower: "1,0", upper: "3,0.5", points_per_cell: "2,2", material: rock, initial_stress: "-1e5"}
  bcs: base,top
  bc_base: {region: box, lower: "0,0", upper: "4,0", components: "y"}
  bc_top: {region: box, lower: "0,0.5", upper: "4,0.5", components: "y"}
  surfaces: outer
  surface_outer: {body: ring, side: "+x", normal: -1e5, ramp: "0:1"}
  stages: rest,dig
  stage_rest: {time: {end: 1, step: 1}}
  stage_dig: {remove: core, time: {end: 1, step: 0.5}}
  time: {end: 1, step: 1}
  output: {prefix: shaft}
"""


def shaft(test):
    """A core that is removed from ground under uniform stress leaves Lame's stress and displacement."""
    state = test.run(written(test, SHAFT)).results.state("last")
    r = state["position"][:, 0]
    factor = -1e5 * 9 / 8
    exact = np.stack([factor * (1 - 1 / r**2), factor * (1 + 1 / r**2)], 1)
    test.check("shaft.stress", np.sqrt(np.mean((state["stress"][:, [0, 2]] - exact) ** 2)) / 1e5, None, 4e-3)
    change = -1e5 / 8  # of Lame's constant part
    moved = 1.25 / 1e9 * (0.5 * change * r - 1e5 * 9 / 8 / r)
    test.check("shaft.displacement", np.abs(state["displacement"][:, 0] / moved - 1).max(), None, 4e-3)


WET = """
mpm:
  dim: 2
  kinematics: axisymmetric
  physics: poro
  grid: {lower: "%g,0", upper: "%g,3", cells: "%d,12"}
  shape: gimp
  water: {density: 1000, viscosity: 1e-3%s}
  materials: clay
  material_clay: {type: neo_hookean, E: 20e6, nu: 0.3, density: 2000, porosity: 0.4, permeability: 1e-12}
  bodies: low
  body_low: {region: box, lower: "%g,0", upper: "%g,2", points_per_cell: "2,2", material: clay}
  bcs: base,inner,outer
  bc_base: {region: box, lower: "0,0", upper: "9,0", components: "x,y"}
  bc_inner: {region: box, lower: "%g,0", upper: "%g,3", components: "x"}
  bc_outer: {region: box, lower: "%g,0", upper: "%g,3", components: "x"}
  loads: weight
  load_weight: {type: gravity, value: "0,-10"}
  time: {end: 1, step: 0.25}
  output: {prefix: wet}
"""


def wet(inner, outer, cells, water=""):
    """Saturated ground between two radii."""
    return WET % (inner, outer, cells, water, inner, outer, inner, inner, outer, outer)


def water(test):
    """Ground with its water level stays at rest: pressure hydrostatic, effective stress that of the weight less buoyancy; a ratio
    without a method is one for k0."""
    options = {"mpm_stages": "rest,wait", "mpm_stage_rest_type": "geostatic", "mpm_stage_rest_geostatic_k0": K0,
               "mpm_stage_wait_time_end": 1e6, "mpm_stage_wait_time_step": 5e5}
    for inner in (0.0, 1.0):
        scene = written(test, wet(inner, inner + 1.5, 6, ", level: 1.5, above: suction"))
        state = test.run(scene, **options).results.state("last")
        height = state["position"][:, 1]
        pressure = 10e3 * (1.5 - height)
        test.check(f"water.{inner:g}.pressure", np.abs(state["pressure"] - pressure).max() / 15e3, None, 1e-9)
        test.check(f"water.{inner:g}.stress", departure(state, pressure - WEIGHT * (HEIGHT - height), K0), None, 1e-9)
        test.check(f"water.{inner:g}.moved", np.abs(state["displacement"]).max(), None, 1e-9)


def well(test):
    """Steady flow to a well: pressure by the logarithm of the radius, and the discharge."""
    options = {"mpm_bcs": "base,inner,outer,wall", "mpm_bc_outer_components": "x,p", "mpm_bc_wall_region": "box",
               "mpm_bc_wall_lower": "1,0", "mpm_bc_wall_upper": "1,3", "mpm_bc_wall_components": "p",
               "mpm_bc_wall_value": -1e4, "mpm_shape": "gimp_bspline2",
               "mpm_shape_edge": "open", "mpm_time_end": 1e9, "mpm_time_step": 2.5e8, "mpm_material_clay_E": 1e9}
    run = test.run(written(test, wet(1.0, 3.0, 16)), mpm_load_weight_value="0,0", **options)
    state = run.results.state("last")
    r = state["position"][:, 0]
    test.check("well.pressure", np.abs(state["pressure"] + 1e4 * (1 - np.log(r) / np.log(3))).max() / 1e4, None, 2e-3)
    discharge = 2 * np.pi * 1e-12 / 1e-3 * HEIGHT * 1e4 / np.log(3) * 2.5e8
    test.near("well.discharge", -run.results.column("reaction_wall_p")[-1], discharge, relative=2e-3)


SAMPLE = """
mpm:
  dim: 2
  kinematics: axisymmetric
  physics: %s
  grid: {lower: "0,0", upper: "0.05,0.1", cells: "4,8"}
  shape: gimp
  materials: sand
  material_sand: {type: mohr_coulomb, E: 20e6, nu: 0.3, density: 0, cohesion: 5e3, friction: 30, dilation: 5%s}
  bodies: sample
  body_sample: {region: box, lower: "0,0", upper: "0.0375,0.0875", points_per_cell: "2,2", material: sand, initial_stress: "-1e5"}
  bcs: base
  bc_base: {region: box, lower: "0,0", upper: "1,0", components: "y"}
  boundaries: platen
  boundary_platen: {type: plane, point: "0,0.0875", normal: "0,-1", contact: bilateral, penalty: 1e4, motion: "0,-1.75e-3"}
  surfaces: cell
  surface_cell: {body: sample, side: "+x", normal: -1e5, ramp: "0:1"}
  stabilization: {fbar: true}
  time: {end: 1, step: 0.05}
  output: {prefix: sample, every: 50}
snes: {rtol: 1e-12}
"""
POINT = """
mpm:
  dim: 3
  physics: stress_point
  materials: sand
  material_sand: {type: mohr_coulomb, E: 20e6, nu: 0.3, density: 0, cohesion: 5e3, friction: 30, dilation: 5}
  point: {material: sand, path: %s, end: -0.02, steps: 20, strain: engineering, stress: "-1e5,-1e5,-1e5,0,0,0"}
  output: {prefix: point}
"""


def samples(test):
    """Triaxial samples with F-bar are those of the laboratory, drained and with their water."""
    for name, physics, more in (("drained", "solid", ""), ("undrained", "poro", ", porosity: 0.4, permeability: 1e-20")):
        run = test.run(written(test, SAMPLE % (physics, more)))
        point = test.run(written(test, POINT % f"triaxial_{name}")).results
        stress = run.table("stress")[:, :3]
        exact = [point.column(f"stress_{c}")[-1] for c in ("xx", "yy", "zz")]
        test.check(f"samples.{name}.fbar", int("but for dilation" in run.output), 0, 0)
        test.check(f"samples.{name}.uniform", np.ptp(stress, axis=0).max() / 1e5, None, 1e-8)
        test.check(f"samples.{name}.stress", np.abs(stress.mean(axis=0) / exact - 1).max(), None, 1e-5)
        other = test.run(written(test, SAMPLE % (physics, more)), ranks=3).table("stress")[:, :3]
        test.check(f"samples.{name}.ranks", difference(stress, other), None, 1e-9)


PARTS = (rest, gravity, layers, shaft, water, well, samples)
if __name__ == "__main__":
    with Test() as test:
        for part in PARTS:
            part(test)
