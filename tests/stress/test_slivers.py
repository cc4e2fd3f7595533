#!/usr/bin/env python3
"""Small-cut nodes: a block whose edge stands 1e-14 to 1e-3 of a cell beyond a row of nodes.

The nodes under the block carry it there: they move by that part of a cell in the first step and are held from then on,
while the block, without stress until then, takes its load. With `linear` the outermost row of points, not the edge of
their domains, is brought to that place. `beyond` has a hair of the block in the next column of cells, `behind` leaves a
hair of it in the last one, `above` lifts it.

Reactions are the load, and the top moves as that of the block whose edge stands in the row of nodes itself, whatever
the sliver; the reach is what the ghost penalty may change with a cell a quarter of the block.

With --full: all of it on 2 ranks too, more laws, and in 3D with every solver.
"""
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))
from hostile import Hostile  # noqa: E402
from talus_test import FULL  # noqa: E402

LIMIT = 60.0  # s, for one run
CELL, WEIGHT = 0.25, (2000.0, -10000.0)  # m, N in 2D
PLACES = (0.0, 1e-14, 1e-12, 1e-9, 1e-6, 1e-3)
TO_THE_POINTS = 0.25  # of a cell: from the outermost row of points to the edge of the block
REACH = 0.05

PLANE = """
mpm:
  dim: 2
  grid: {lower: "0,0", upper: "4,4", cells: "16,16"}
  materials: soil
  material_soil: {type: hencky, E: 1e6, nu: 0.3, density: 1000}
  bodies: block
  body_block: {region: box, lower: "1,0", upper: "2,1", points_per_cell: "2,2", material: soil}
  bcs: base
  bc_base: {region: box, lower: "0,0", upper: "4,0", components: "x,y", ramp: "0:0,0.25:1"}
  loads: weight
  load_weight: {type: gravity, value: "2,-10", ramp: "0:0,0.25:0,1:1"}
  time: {end: 1, step: 0.25}
  tracks: top
  track_top: {at: "2,1", nearest: 1}
  quiet: true
  output: {prefix: run, every: 1}
"""
SOLID = """
mpm:
  dim: 3
  grid: {lower: "0,0,0", upper: "2,2,2", cells: "8,8,8"}
  materials: soil
  material_soil: {type: hencky, E: 1e6, nu: 0.3, density: 1000}
  bodies: block
  body_block: {region: box, lower: "0.5,0.5,0", upper: "1,1,0.75", points_per_cell: "2,2,2", material: soil}
  bcs: base
  bc_base: {region: box, lower: "0,0,0", upper: "2,2,0", components: "x,y,z", ramp: "0:0,0.5:1"}
  loads: weight
  load_weight: {type: gravity, value: "2,0,-10", ramp: "0:0,0.5:0,1:1"}
  time: {end: 1, step: 0.5}
  tracks: top
  track_top: {at: "1,1,0.75", nearest: 1}
  quiet: true
  output: {prefix: run, every: 1}
"""


def shift(shape, direction, place):
    """By how much (x, y) the nodes carry the block, in m."""
    start = TO_THE_POINTS if shape in ("linear", "bspline3") else 0.0
    if direction == "behind":
        return (CELL * (1.0 - start - place), 0.0)
    return (CELL * (start + place), CELL * place if direction == "above" else 0.0)


def compare(test, label, shape, direction, places, **options):
    """The block at every place beside the block at the first one."""
    still = None
    for place in places:
        carried = shift(shape, direction, place)
        where = f"{label}.{shape}.{direction}_{place:g}"
        run = test.ends(where, PLANE, mpm_shape=shape, mpm_bc_base_value=f"{carried[0]!r},{carried[1]!r}", **options)
        if not run.completed:
            continue
        for axis, force in zip("xy", WEIGHT):
            test.near(f"{where}.reaction_{axis}", run.last(f"reaction_base_{axis}"), -force, relative=1e-5)
        moved = [run.last(f"track_top_u{axis}") - carried[k] for k, axis in enumerate("xy")]
        if still is None:
            still = moved
        for axis, value, reference in zip("xy", moved, still):
            test.near(f"{where}.top_u{axis}", value, reference, relative=REACH)


def soft(test, label, shape, modulus, or_gives_up, **options):
    """A hair of a block that deforms much: only its equilibrium can be asked for."""
    carried = shift(shape, "beyond", 1e-14)
    where = f"{label}.E_{modulus:g}"
    run = test.ends(where, PLANE, or_gives_up=or_gives_up, mpm_shape=shape, mpm_time_step=0.125,
                    mpm_material_soil_E=modulus, mpm_bc_base_value=f"{carried[0]!r},{carried[1]!r}", **options)
    if run.completed:
        test.near(f"{where}.reaction_y", run.last("reaction_base_y"), -WEIGHT[1], relative=1e-5)


def solid(test, label, place, **options):
    """In 3D: a sliver on two sides at once."""
    run = test.ends(label, SOLID, mpm_bc_base_value=f"{CELL * place!r},{CELL * place!r},0", **options)
    if run.completed:
        test.near(f"{label}.reaction", run.last("reaction_base_z"), 10000.0 * 0.5 * 0.5 * 0.75, relative=1e-5)


with Hostile(LIMIT) as test:
    few = PLACES if FULL else (0.0, 1e-14, 1e-9, 1e-3)
    for shape in ("gimp", "linear"):
        for solver in ("direct", "amg", "boomeramg") if shape == "gimp" or FULL else ("direct", "amg"):
            compare(test, solver, shape, "beyond", PLACES if solver == "direct" else few, mpm_solver=solver)
        for solver in ("direct", "amg", "boomeramg") if FULL else ("direct", "amg"):
            # strains of a third, and of the order of one, where a run may give up
            soft(test, f"{solver}.{shape}", shape, 2e4, False, mpm_solver=solver)
            soft(test, f"{solver}.{shape}", shape, 1e4, True, mpm_solver=solver)
        # alone, the direct solver must do without the penalty too
        compare(test, "no_penalty", shape, "behind", few, mpm_stabilization_ghost="off")
    compare(test, "direct", "gimp", "above", few)
    compare(test, "amg", "gimp", "behind", (0.0, 1e-12, 1e-3), mpm_solver="amg")
    compare(test, "2_ranks", "gimp", "beyond", (0.0, 1e-14, 1e-6), ranks=2)
    compare(test, "2_ranks_amg", "linear", "beyond", (0.0, 1e-14), ranks=2, mpm_solver="amg")
    for shape in ("bspline2", "bspline3", "gimp_bspline2"):
        compare(test, "direct", shape, "beyond", few if FULL else (0.0, 1e-14, 1e-6))
    for place in (0.0, 1e-12, 1e-6, 1e-3) if FULL else (1e-12,):
        for solver in ("direct", "amg", "boomeramg"):
            solid(test, f"3d.{solver}.{place:g}", place, mpm_solver=solver)
            if FULL:
                solid(test, f"3d.{solver}.{place:g}.2_ranks", place, mpm_solver=solver, ranks=2)
    if FULL:
        for shape in ("gimp", "linear"):
            for law in ("neo_hookean", "linear_elastic"):
                compare(test, law, shape, "beyond", PLACES, mpm_material_soil_type=law)
            for solver in ("direct", "amg", "boomeramg"):
                for direction in ("beyond", "behind", "above"):
                    compare(test, f"{solver}_2_ranks", shape, direction, PLACES, mpm_solver=solver, ranks=2)
