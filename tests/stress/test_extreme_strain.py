#!/usr/bin/env python3
"""Compression to a tenth of the height and tension to three times the length, by a dead traction on the end.

The bar is uniform, and the domains of `gimp` tile it, so that its nominal stress is the traction at every step's end:
for Hencky M ln(s)/s (held sideways) and for neo-Hookean mu (s - 1/s) + lambda ln(s)/s. Free sideways, plane strain, the
stretch across follows from no stress there. Hencky's nominal stress has its largest value at s = e, M/e: beyond, there
is no equilibrium, and the run must say so. A free side is unstable to wrinkles in compression beyond a stretch of about
a half (0.544 for an incompressible neo-Hookean solid in plane strain: Biot (1963), Appl. Sci. Res. A 12, 168): a run says
so and follows the uniform state, or stops where the scene asks for it. Cells as coarse as these do not resolve wrinkles,
with finer ones only finite numbers are asked for.

With --full: cells of half the size, 2 ranks, 3D, and all shapes.
"""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent))
from hostile import Hostile  # noqa: E402
from talus_test import FULL  # noqa: E402

LIMIT = 120.0  # s, for one run
E, LENGTH = 1e6, 2.0  # Pa, m

SCENE = """
mpm:
  dim: 2
  grid: {lower: "0,0", upper: "3,8", cells: "6,16"}
  materials: rubber
  material_rubber: {type: hencky, E: 1e6, nu: 0.3, density: 1000}
  bodies: bar
  body_bar: {region: box, lower: "0,0", upper: "1,2", points_per_cell: "2,2", material: rubber}
  bcs: sides,base
  bc_sides: {region: box, lower: "0,0", upper: "3,8", components: "x"}
  bc_base: {region: box, lower: "0,0", upper: "3,0", components: "y"}
  loads: cap
  load_cap: {type: traction, region: box, lower: "0,2", upper: "1,2", value: "0,1"}
  time: {end: 1, step: 0.02}
  tracks: cap
  track_cap: {at: "0,2", nearest: 1}
  quiet: true
  output: {prefix: run, every: 10}
"""
SOLID = """
mpm:
  dim: 3
  grid: {lower: "0,0,0", upper: "1.5,1.5,7", cells: "3,3,14"}
  materials: rubber
  material_rubber: {type: neo_hookean, E: 1e6, nu: 0, density: 1000}
  bodies: bar
  body_bar: {region: box, lower: "0,0,0", upper: "1,1,2", points_per_cell: "2,2,2", material: rubber}
  bcs: sides,base
  bc_sides: {region: box, lower: "0,0,0", upper: "2,2,8", components: "x,y"}
  bc_base: {region: box, lower: "0,0,0", upper: "2,2,0", components: "z"}
  loads: cap
  load_cap: {type: traction, region: box, lower: "0,0,2", upper: "1,1,2", value: "0,0,1"}
  time: {end: 1, step: 0.05}
  tracks: cap
  track_cap: {at: "0,0,2", nearest: 1}
  quiet: true
  output: {prefix: run, every: 10}
"""
HENCKY_STRETCH = 2.4  # its nominal stress, held sideways, has its largest value at e
FREE = {"mpm_bc_sides_upper": "0,8"}  # a plane of symmetry on one side, nothing on the other


def lame(nu):
    return E * nu / ((1.0 + nu) * (1.0 - 2.0 * nu)), 0.5 * E / (1.0 + nu)


def kirchhoff(law, nu, along, across):
    """tau along and across the bar for its stretches, plane strain."""
    lam, mu = lame(nu)
    volume = lam * (np.log(along) + np.log(across))
    if law == "hencky":
        return volume + 2.0 * mu * np.log(along), volume + 2.0 * mu * np.log(across)
    return volume + mu * (along**2 - 1.0), volume + mu * (across**2 - 1.0)


def across(law, nu, along, free):
    """The stretch across: 1 where it is held, else that without stress, by bisection."""
    if not free:
        return 1.0
    low, high = 1e-3, 1e3
    for _ in range(200):
        middle = np.sqrt(low * high)
        if kirchhoff(law, nu, along, middle)[1] < 0.0:
            low = middle
        else:
            high = middle
    return middle


def nominal(law, nu, along, free):
    """The dead traction that holds this stretch: force per initial area."""
    return kirchhoff(law, nu, along, across(law, nu, along, free))[0] / along


def pull(test, label, law, nu, stretch, free, reach=1e-4, scene=SCENE, or_gives_up=False, **options):
    """To a stretch by the traction that closed form gives; stretches and stresses of all points beside it."""
    traction = nominal(law, nu, stretch, free)
    axis = 2 if scene is SOLID else 1
    value = ",".join(["0"] * axis + [repr(float(traction))])
    run = test.ends(label, scene, or_gives_up=or_gives_up, mpm_material_rubber_type=law, mpm_material_rubber_nu=nu,
                    mpm_load_cap_value=value, **(FREE if free else {}), **options)
    if not run.completed:
        return
    test.check(f"{label}.support_error", abs(run.last("reaction_base_y" if axis == 1 else "reaction_base_z") / -traction - 1), None, 1e-6)
    if np.isinf(reach):
        return
    state = run.results.state("last")
    width = across(law, nu, stretch, free)
    F = state["F"].reshape(-1, 3, 3)
    for name, values, exact in (("stretch", F[:, axis, axis], stretch), ("stretch_across", F[:, 0, 0], width)):
        test.check(f"{label}.{name}_error", np.max(np.abs(values / exact - 1.0)), None, reach)
    cauchy = traction / (width if axis == 1 else 1.0)
    test.check(f"{label}.stress_error", np.max(np.abs(state["stress"][:, axis] / cauchy - 1.0)), None, reach)


def both_ways(test, label, law, nu, free, **options):
    """Compression and tension, with four points a cell: more than any stretch, or nodes would outnumber points."""
    options["mpm_body_bar_points_per_cell"] = "4,4"
    tension = HENCKY_STRETCH if law == "hencky" else 3.0
    pull(test, f"{label}.to_a_tenth", law, nu, 0.1, free, **options)
    pull(test, f"{label}.to_{tension:g}", law, nu, tension, free, **options)


with Hostile(LIMIT) as test:
    for law in ("hencky", "neo_hookean"):
        for nu in (0.0, 0.3):
            for free in (False, True):
                both_ways(test, f"{law}.{'free' if free else 'held'}.nu_{nu:g}", law, nu, free)
    both_ways(test, "neo_hookean.2_ranks", "neo_hookean", 0.3, True, ranks=2)
    # one step in five: cut as often as needed
    both_ways(test, "neo_hookean.large_steps", "neo_hookean", 0.3, True, mpm_time_step=0.1)
    # the tangent of a bar that is pushed so hard is indefinite on the way: iterative solvers may fail, but must say so
    for solver in ("amg", "boomeramg"):
        pull(test, f"{solver}.to_a_tenth", "hencky", 0.3, 0.1, True, or_gives_up=True, mpm_solver=solver)
    for law, nu in (("hencky", 0.0), ("neo_hookean", 0.3)):  # what is followed above is found and named
        value = f"0,{float(nominal(law, nu, 0.1, True))!r}"
        run = test.ends(f"{law}.unstable", SCENE, or_gives_up=True, mpm_material_rubber_type=law, mpm_material_rubber_nu=nu,
                        mpm_load_cap_value=value, mpm_body_bar_points_per_cell="4,4",
                        mpm_stabilization_unstable="stop", **FREE)
        test.check(f"{law}.unstable.named", float("lost definiteness" in (run.reason or "")), 1.0, 1.0)
    # two points a cell on each axis: from a stretch of 2 on, along the bar or across, there are more nodes than points; the block
    # that widens is unstable from the first step on, and which branch it takes is for rounding to say
    pull(test, "two_points.wide", "hencky", 0.3, 0.1, True, or_gives_up=True, reach=np.inf)
    for free in (False, True):
        where = f"two_points.{'free' if free else 'held'}"
        pull(test, where, "neo_hookean", 0.3, 3.0, free, or_gives_up=True, reach=1.0)
    # beyond the largest nominal stress that there is
    traction = 1.05 * nominal("hencky", 0.0, np.e, False)
    run = test.ends("hencky_beyond_its_limit", SCENE, or_gives_up=True, mpm_load_cap_value=f"0,{traction!r}",
                    mpm_material_rubber_nu=0, mpm_body_bar_points_per_cell="4,4")
    test.check("hencky_beyond_its_limit.status", run.status, 3, 3)
    if run.status == 3:
        test.check("hencky_beyond_its_limit.load", run.last("load") * 1.05, 0.95, 1.0)
    pull(test, "3d.to_3", "neo_hookean", 0.0, 3.0, False, scene=SOLID, mpm_body_bar_points_per_cell="2,2,4")
    pull(test, "3d.to_a_tenth", "neo_hookean", 0.0, 0.1, False, scene=SOLID)
    if FULL:
        for refine, ranks in ((2, 1), (2, 2), (4, 2)):
            for law in ("hencky", "neo_hookean"):
                where = f"{law}.h_over_{refine}.{ranks}_ranks"
                options = {"mpm_grid_refine": refine, "ranks": ranks, "mpm_body_bar_points_per_cell": "4,4"}
                tension = HENCKY_STRETCH if law == "hencky" else 3.0
                pull(test, f"{where}.to_{tension:g}", law, 0.3, tension, True, **options)
                pull(test, f"{where}.to_0.7", law, 0.3, 0.7, True, **options)
                # fine cells resolve wrinkles of the free side, to which it is unstable from about a half on
                pull(test, f"{where}.to_a_tenth", law, 0.3, 0.1, True, or_gives_up=True, reach=np.inf, **options)
        for shape in ("linear", "bspline2", "bspline3", "gimp_bspline2"):
            # points without domains do not tile the bar: its end is a part of a cell off
            for free in (False, True):
                where, any_end = f"{shape}.{'free' if free else 'held'}", {"or_gives_up": True, "reach": np.inf}
                pull(test, f"{where}.to_3", "neo_hookean", 0.3, 3.0, free, mpm_shape=shape,
                     mpm_body_bar_points_per_cell="4,4", **any_end)
                pull(test, f"{where}.to_a_tenth", "neo_hookean", 0.3, 0.1, free, mpm_shape=shape, **any_end)
