#!/usr/bin/env python3
"""Terrain as a rigid surface in three dimensions: the bed of the scene, a plane or a raster.

A block slides on a plane boundary, on a plane bed and on a raster of it alike; on a raster of 20 degrees its
acceleration is g (sin - mu cos). On a twisted bed, z = a x y, a drop rests in the valley. Ranks agree, and input that
is no terrain is refused.

Quick.
"""
import math
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import Test, difference  # noqa: E402

SLOPE = math.tan(math.radians(20))
BLOCK = """mpm:
  dim: 3
  grid: {lower: "0,0,0", upper: "12,4,8", cells: "24,8,16"}
  materials: block
  material_block: {type: hencky, E: 1e6, nu: 0.2, density: 1000}
  bodies: block
  body_block: {region: box, lower: "0.5,1,6", upper: "3.5,3,7.5", points_per_cell: "2,2,2", material: block}
  boundaries: ground
  boundary_ground: {friction: 0.2}
  loads: weight
  load_weight: {type: gravity, value: "0,0,-9.81", ramp: "0:1"}
  tracks: block
  track_block: {at: "2,2,6.75", nearest: 8}
  time: {integrator: explicit, end: 0.9}
  output: {every: 0}
  quiet: true
"""
SLIDER = """mpm:
  dim: 3
  grid: {lower: "0,0,0", upper: "12,2,8", cells: "24,4,16"}
  materials: block
  material_block: {type: hencky, E: 1e6, nu: 0.2, density: 1000}
  bodies: block
  body_block: {region: columns, depth: depth.asc, columns_per_cell: "2,2", spacing: 0.25, stress: none, material: block}
  boundaries: ground
  boundary_ground: {type: terrain, friction: 0.2}
  terrain: {file: bed.asc}
  bcs: sides
  bc_sides: {region: all, components: "y"}
  loads: weight
  load_weight: {type: gravity, value: "0,0,-9.81", ramp: "0:1"}
  time: {integrator: explicit, end: 1}
  output: {every: 100000}
  quiet: true
"""


def write_map(path, function, cell=0.5, lower=-0.5, count=(27, 11)):
    """A map of a function at pixel centres."""
    xs, ys = (lower + cell * np.arange(n) for n in count)
    with open(path, "w", encoding="utf-8") as file:
        file.write(f"ncols {count[0]}\nnrows {count[1]}\nxllcenter {lower}\nyllcenter {lower}\ncellsize {cell}\n")
        for y in ys[::-1]:
            file.write(" ".join(repr(float(function(x, y))) for x in xs) + "\n")


def block(test, folder, ranks=1, **options):
    run = test.run(folder / "block.yaml", ranks=ranks, **{f"mpm_{key}": value for key, value in options.items()})
    columns = ("track_block_ux", "track_block_uy", "track_block_uz", "reaction_ground_x", "reaction_ground_z")
    return np.array([run.results.column(name) for name in columns])


def alike(test):
    """A plane three times over, and a raster that is none on ranks."""
    folder = test.folder()
    (folder / "block.yaml").write_text(BLOCK)
    write_map(folder / "plane.asc", lambda x, y: 6 - 0.5 * x + 0.1 * y)
    write_map(folder / "twisted.asc", lambda x, y: 6 - 0.5 * x + 0.04 * x * y)
    normal = ",".join(map(repr, (0.5, -0.1, 1.0)))
    plane = block(test, folder, boundary_ground_type="plane", boundary_ground_point="0,0,6", boundary_ground_normal=normal)
    bed = block(test, folder, boundary_ground_type="terrain", bed="6,-0.5,0.1")
    raster = block(test, folder, boundary_ground_type="terrain", terrain_file=folder / "plane.asc")
    test.check("block.moves", plane[0][-1], 0.2, 3)
    test.check("block.touches", float(abs(plane[4]).max()), 1e4)
    test.check("block.bed", difference(plane, bed), 0, 1e-9)
    test.check("block.raster", difference(plane, raster), 0, 1e-9)
    one, three = (block(test, folder, ranks, boundary_ground_type="terrain", terrain_file=folder / "twisted.asc")
                  for ranks in (1, 3))
    test.check("twisted.ranks", difference(one, three), 0, 1e-9)
    test.check("twisted.other", difference(plane[:, :20], one[:, :20]), 1e-6)


def slider(test):
    """A layer on a slope of 20 degrees slides with g cos (sin - mu cos) along x; on one below its friction it stays."""
    folder = test.folder()
    (folder / "slider.yaml").write_text(SLIDER)
    write_map(folder / "bed.asc", lambda x, y: 6 - SLOPE * x)
    write_map(folder / "depth.asc", lambda x, y: 1.0 if 0.8 < x < 4.3 else -9.0)
    state = test.run(folder / "slider.yaml").results.state("last")
    mass = state["mass"].ravel()
    speed = float((mass * state["velocity"][:, 0]).sum() / mass.sum())
    c, s = math.cos(math.radians(20)), math.sin(math.radians(20))
    test.near("slider.speed", speed, 9.81 * c * (s - 0.2 * c), relative=0.01)
    test.near("slider.along", float((mass * state["velocity"][:, 2]).sum() / mass.sum()), -SLOPE * speed, relative=0.1)
    state = test.run(folder / "slider.yaml", mpm_boundary_ground_friction=0.6).results.state("last")
    test.check("slider.held", float(abs((mass * state["velocity"][:, 0]).sum() / mass.sum())), 0, 0.05)


def refuse(test, label, words, **options):
    """One line with these words, status 2, no files."""
    folder = test.folder()
    (folder / "block.yaml").write_text(BLOCK)
    run = test.run(folder / "block.yaml", status=2, mpm_boundary_ground_type="terrain", **options)
    test.check(f"{label}.line", words in run.errors and run.errors.count("\n") == 1, 1, 1)
    test.check(f"{label}.files", len(run.files), 0, 0)


with Test() as test:
    alike(test)
    slider(test)
    small = test.folder() / "small.asc"
    write_map(small, lambda x, y: 0.0, count=(5, 5))
    refuse(test, "none", "a boundary of type terrain needs it")
    refuse(test, "small", "covers", mpm_terrain_file=small)
    refuse(test, "behind", "lie behind it", mpm_bed="7,0,0")
