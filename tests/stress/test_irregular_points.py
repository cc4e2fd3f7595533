#!/usr/bin/env python3
"""Points that stand irregularly: other numbers a cell in every body, edges at odd fractions of a cell, slopes, discs.

A body keeps the points of its cells' lattices that lie in its region: where its edge cuts cells the points' domains
neither tile it nor end with it. The weight of the points is then the weight of the scene, and the base must carry it;
what stands there is checked for equilibrium only. One point a cell leaves displacements that strain no point; such a
scene may give up. So may B-splines where a body ends in slivers: they have no ghost penalty.

With --full: every case on 2 ranks and with the iterative solvers, cells of half the size.
"""
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))
from hostile import Hostile  # noqa: E402
from talus_test import FULL, example  # noqa: E402

LIMIT = 90.0  # s, for one run
GRAVITY = 10.0  # m/s2
SHAPES = ("linear", "gimp", "bspline2", "bspline3", "gimp_bspline2")

HEAD = """
mpm:
  dim: 2
  grid: {lower: "0,0", upper: "8,6", cells: "16,12"}
  materials: soil
  material_soil: {type: hencky, E: 1e6, nu: 0.3, density: 1000}
  bcs: base
  bc_base: {region: box, lower: "0,0", upper: "8,0", components: "x,y"}
  loads: weight
  load_weight: {type: gravity, value: "0,-10"}
  time: {end: 1, step: 0.1}
  quiet: true
  output: {prefix: run, every: 5}
"""
BODIES = {
    # two bodies with other points a cell, the upper one aside by odd fractions of a cell
    "stack": """
  bodies: low,high
  body_low: {region: box, lower: "1,0", upper: "4,2", points_per_cell: "3,2", material: soil}
  body_high: {region: box, lower: "1.37,2", upper: "3.71,3.59", points_per_cell: "5,7", material: soil}
""",
    # edges at 1/3, 1/7 and 1/pi of a cell
    "odd_fractions": """
  bodies: block
  body_block: {region: box, lower: "1.1667,0", upper: "4.0714,2.1592", points_per_cell: "4,3", material: soil}
""",
    "slope": """
  bodies: slope
  body_slope: {region: polygon, vertices: "0.3,0,6.1,0,3.7,2.9,2.1,3.3", points_per_cell: "3,3", material: soil}
""",
    # a sharp edge: the tip of the wedge is a single row of points
    "wedge": """
  bodies: wedge
  body_wedge: {region: polygon, vertices: "0.1,0,7.9,0,7.9,0.26", points_per_cell: "2,4", material: soil}
""",
    "disc_on_a_slab": """
  bodies: slab,disc
  body_slab: {region: box, lower: "0.5,0", upper: "5.5,1", points_per_cell: "2,3", material: soil}
  body_disc: {region: sphere, center: "3,1.9", radius: "0.95", points_per_cell: "4,4", material: soil}
""",
    # as irregular as it gets: strips with other numbers of points side by side
    "patchwork": """
  bodies: a,b,c,d
  body_a: {region: box, lower: "1,0", upper: "1.77,2.3", points_per_cell: "1,4", material: soil}
  body_b: {region: box, lower: "1.77,0", upper: "2.61,2.1", points_per_cell: "7,2", material: soil}
  body_c: {region: box, lower: "2.61,0", upper: "3.43,1.9", points_per_cell: "3,8", material: soil}
  body_d: {region: box, lower: "3.43,0", upper: "4.9,2.2", points_per_cell: "2,3", material: soil}
""",
}
REGULAR = """
  bodies: block
  body_block: {region: box, lower: "1,0", upper: "3,2", points_per_cell: "2,2", material: soil}
"""


def stands(test, label, bodies, or_gives_up=False, **options):
    """The base carries the weight of all points."""
    run = test.ends(label, HEAD + bodies, or_gives_up=or_gives_up, **options)
    if run.completed:
        weight = GRAVITY * run.results.initial["mass"].sum()
        test.near(f"{label}.base_reaction", run.last("reaction_base_y"), weight, relative=1e-5)
        test.check(f"{label}.sideways", abs(run.last("reaction_base_x")) / weight, None, 1e-5)


FBAR = {"mpm_stabilization_fbar": "true"}

with Hostile(LIMIT) as test:
    fbar = test.takes(example("bar_elastic"), **FBAR)
    refinements = (1, 2) if FULL else (1,)
    for name, bodies in BODIES.items():
        for shape in SHAPES if FULL else ("linear", "gimp"):
            for refine in refinements:
                stands(test, f"{name}.{shape}.h_over_{refine}", bodies, or_gives_up=shape not in ("linear", "gimp"),
                       mpm_shape=shape, mpm_grid_refine=refine)
        # soft: the weight strains it by a tenth and more
        stands(test, f"{name}.soft", bodies, mpm_material_soil_E=1e5)
        if fbar:
            stands(test, f"{name}.fbar", bodies, **FBAR)
            stands(test, f"{name}.soft.fbar", bodies, mpm_material_soil_E=1e5, **FBAR)
        for solver in ("amg", "boomeramg") if FULL else ("amg",):
            stands(test, f"{name}.{solver}", bodies, mpm_solver=solver)
        if FULL or name in ("slope", "patchwork"):
            stands(test, f"{name}.2_ranks", bodies, ranks=2)
            stands(test, f"{name}.soft.2_ranks", bodies, ranks=2, mpm_material_soil_E=1e5)
    stands(test, "slope.gimp_bspline2", BODIES["slope"], mpm_shape="gimp_bspline2")
    for shape in SHAPES:
        stands(test, f"one_point_a_cell.{shape}", REGULAR, or_gives_up=True, mpm_shape=shape,
               mpm_body_block_points_per_cell="1,1")
        stands(test, f"64_points_a_cell.{shape}", REGULAR, mpm_shape=shape, mpm_body_block_points_per_cell="8,8")
    stands(test, "one_point_a_cell.penalty", REGULAR, or_gives_up=True, mpm_stabilization_ghost="0.1",
           mpm_body_block_points_per_cell="1,1")
    for solver in ("direct", "amg", "boomeramg"):
        stands(test, f"one_point_a_cell.{solver}.2_ranks", REGULAR, or_gives_up=True, ranks=2, mpm_solver=solver,
               mpm_body_block_points_per_cell="1,1")
    # a single point
    stands(test, "one_point", REGULAR, or_gives_up=True, mpm_body_block_points_per_cell="1,1",
           mpm_body_block_upper="1.5,0.5")
    stands(test, "one_point.2_ranks", REGULAR, or_gives_up=True, ranks=2, mpm_body_block_points_per_cell="1,1",
           mpm_body_block_upper="1.5,0.5")
    # as many points a cell as there may be on one axis, one on the other
    stands(test, "64_by_1", REGULAR, or_gives_up=True, mpm_body_block_points_per_cell="64,1")
