#!/usr/bin/env python3
"""A bar that comes apart: its halves driven away from each other, or pulled by more than it can carry.

A gap that opens between points is fracture of the discretisation, not of the material: at what stretch it comes, and
whether Newton gets there, depends on shape functions and cells. So a run may give up, with a line. Where it completes,
the driven ends must have gone their way, no mass may be missing, and pieces that nothing holds any more must stay in
one place.

With --full: cells of half the size, all shapes with every law, 2 ranks for each.
"""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent))
from hostile import Hostile  # noqa: E402
from talus_test import FULL  # noqa: E402

LIMIT = 90.0  # s, for one run
WAY = 3.0  # m, of each driven end
SHAPES = ("linear", "gimp", "bspline2", "bspline3", "gimp_bspline2")
LAWS = {
    "hencky": {},
    "neo_hookean": {},
    "j2": {"mpm_material_soil_yield_stress": "2e4"},
    "drucker_prager": {"mpm_material_soil_cohesion": "1e4", "mpm_material_soil_friction": "30",
                       "mpm_material_soil_dilation": "0"},
}

# the nodes of the outer third on each side are held to the motion of that side
DRIVEN = """
mpm:
  dim: 2
  grid: {lower: "0,0", upper: "12,3", cells: "24,6"}
  materials: soil
  material_soil: {type: hencky, E: 1e6, nu: 0.3, density: 1000}
  bodies: bar
  body_bar: {region: box, lower: "4,1", upper: "8,2", points_per_cell: "2,2", material: soil}
  bcs: left,right
  bc_left: {region: box, lower: "0,0", upper: "5,3", components: "x,y", value: "-3,0", ramp: "0:0,1:1"}
  bc_right: {region: box, lower: "7,0", upper: "12,3", components: "x,y", value: "3,0", ramp: "0:0,1:1"}
  time: {end: 1, step: 0.025}
  tracks: left,right
  track_left: {at: "4,1.5", nearest: 2}
  track_right: {at: "8,1.5", nearest: 2}
  quiet: true
  output: {prefix: run, every: 5}
"""
# opposite forces on the ends, far above what the law can carry; nothing holds the bar but its middle
PULLED = """
mpm:
  dim: 2
  grid: {lower: "0,0", upper: "12,3", cells: "24,6"}
  materials: soil
  material_soil: {type: hencky, E: 1e6, nu: 0.3, density: 1000}
  bodies: bar
  body_bar: {region: box, lower: "4,1", upper: "8,2", points_per_cell: "2,2", material: soil}
  bcs: middle,line
  bc_middle: {region: box, lower: "6,0", upper: "6,3", components: "x"}
  bc_line: {region: box, lower: "0,1.5", upper: "12,1.5", components: "y"}
  loads: left,right
  load_left: {type: traction, region: box, lower: "4,1", upper: "4,2", value: "-1e6,0"}
  load_right: {type: traction, region: box, lower: "8,1", upper: "8,2", value: "1e6,0"}
  time: {end: 1, step: 0.05}
  tracks: left,right
  track_left: {at: "4,1.5", nearest: 2}
  track_right: {at: "8,1.5", nearest: 2}
  quiet: true
  output: {prefix: run, every: 5}
"""
# a block that hangs from its top, of which the lower part is drawn away; beside it a piece that lies on a shelf
TWO_BODIES = """
mpm:
  dim: 2
  grid: {lower: "0,0", upper: "4,8", cells: "8,16"}
  materials: soil
  material_soil: {type: hencky, E: 1e6, nu: 0.3, density: 1000}
  bodies: upper,lower
  body_upper: {region: box, lower: "1,5", upper: "3,7", points_per_cell: "2,2", material: soil}
  body_lower: {region: box, lower: "1,3", upper: "3,5", points_per_cell: "3,3", material: soil}
  bcs: roof,lift
  bc_roof: {region: box, lower: "0,6", upper: "4,8", components: "x,y"}
  bc_lift: {region: box, lower: "0,0", upper: "4,4", components: "x,y", value: "0,-2", ramp: "0:0,1:1"}
  loads: weight
  load_weight: {type: gravity, value: "0,-1"}
  time: {end: 1, step: 0.05}
  tracks: left,right
  track_left: {at: "2,7", nearest: 2}
  track_right: {at: "2,3", nearest: 2}
  quiet: true
  output: {prefix: run, every: 5}
"""


def driven(test, label, law, **options):
    """The ends' way, and symmetry about the middle."""
    run = test.ends(label, DRIVEN, or_gives_up=True, mpm_material_soil_type=law, **LAWS[law], **options)
    if not run.completed:
        return
    for end, sign in (("left", -1.0), ("right", 1.0)):
        test.near(f"{label}.{end}", run.last(f"track_{end}_ux"), sign * WAY, absolute=1e-6)
    x = run.results.state("last")["position"][:, 0]
    gap = np.max(np.diff(np.sort(x)))
    # the outer thirds move as a whole, so that the rest is left in 6 m of way: there is a gap, or a thread of points
    test.check(f"{label}.largest_gap", gap, 0.25, 8.0)
    test.near(f"{label}.balance", run.last("reaction_left_x") + run.last("reaction_right_x"), 0.0, absolute=1.0)


def pulled(test, label, law, **options):
    run = test.ends(label, PULLED, or_gives_up=True, mpm_material_soil_type=law, **LAWS[law], **options)
    if law == "hencky":  # the largest nominal stress that it has, M/e, is below the traction
        test.check(f"{label}.status", run.status, 3, 3)


with Hostile(LIMIT) as test:
    for law in LAWS:
        for shape in SHAPES if law == "hencky" or FULL else ("linear", "gimp"):
            driven(test, f"driven.{law}.{shape}", law, mpm_shape=shape)
    driven(test, "driven.2_ranks", "hencky", ranks=2)
    driven(test, "driven.j2.2_ranks", "j2", ranks=2, mpm_shape="linear")
    driven(test, "driven.penalty", "hencky", mpm_stabilization_ghost="1e-3")
    for solver in ("amg", "boomeramg"):
        driven(test, f"driven.{solver}", "hencky", mpm_solver=solver)
    for law in LAWS:
        pulled(test, f"pulled.{law}", law)
    pulled(test, "pulled.2_ranks", "hencky", ranks=2)
    pulled(test, "pulled.amg", "neo_hookean", mpm_solver="amg")
    for ranks in (1, 2):
        test.ends(f"two_bodies.{ranks}_ranks", TWO_BODIES, or_gives_up=True, ranks=ranks)
    if FULL:
        for law in LAWS:
            for shape in SHAPES:
                driven(test, f"fine.{law}.{shape}.2_ranks", law, ranks=2, mpm_shape=shape, mpm_grid_refine=2)
            pulled(test, f"fine.pulled.{law}.2_ranks", law, ranks=2, mpm_grid_refine=2)
