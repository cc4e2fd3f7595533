#!/usr/bin/env python3
"""Ground as it is drawn: bodies that replace others, and layers, against bodies drawn piece by piece, with their mass, on ranks.

Quick.
"""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import Test, difference  # noqa: E402

SCENE = """mpm:
  dim: 2
  grid: {lower: "0,0", upper: "12,6", cells: "12,6"}
  materials: sand,clay,rock
  material_sand: {type: hencky, E: 20e6, nu: 0.3, density: 1800}
  material_clay: {type: hencky, E: 10e6, nu: 0.3, density: 1700}
  material_rock: {type: hencky, E: 900e6, nu: 0.2, density: 2500}
  bcs: west,east,base
  bc_west: {region: box, lower: "0,0", upper: "0,6", components: "x"}
  bc_east: {region: box, lower: "12,0", upper: "12,6", components: "x"}
  bc_base: {region: box, lower: "0,0", upper: "12,0", components: "x,y"}
  loads: weight
  load_weight: {type: gravity, value: "0,-10"}
  time: {end: 1, step: 1}
"""
WALL = """  bodies: ground,wall
  body_ground: {region: box, lower: "0,0", upper: "12,4", material: sand}
  body_wall: {region: box, lower: "5,2", upper: "6,5", priority: true, material: rock}
"""
PIECES = """  bodies: ground,wall
  body_ground: {region: polygon, vertices: "0,0,12,0,12,4,6,4,6,2,5,2,5,4,0,4", material: sand}
  body_wall: {region: box, lower: "5,2", upper: "6,5", material: rock}
"""
REPLACED = """  bodies: ground,core,wall
  body_ground: {region: box, lower: "0,0", upper: "12,4", material: sand}
  body_core: {region: box, lower: "5,2", upper: "6,4", priority: true, material: sand}
  body_wall: {region: box, lower: "5,2", upper: "6,4", material: rock}
  stages: rest,build
  stage_rest: {type: geostatic, geostatic: {method: k0, k0: 0.5}, bodies: "ground,core"}
  stage_build: {remove: core, bodies: wall, time: {end: 1, step: 1}}
"""
LATE = "\n".join(line for line in REPLACED.splitlines() if "body_core" not in line).replace("ground,core", "ground").replace(
    "remove: core, ", "").replace("body_wall: {", "body_wall: {priority: true, ") + "\n"
LAYERS = """  bodies: fill,clay,bed
  body_fill: {region: layers, top: "2,5,6,5,9,2", bottom: "0,3,12,3.6", material: sand}
  body_clay: {region: layers, below: fill, bottom: "0,1,12,1.6", material: clay}
  body_bed: {region: layers, below: clay, material: rock}
"""
POLYGONS = """  bodies: fill,clay,bed
  body_fill: {region: polygon, vertices: "0,3,7.619047619047619,3.380952380952381,6,5,0,5", material: sand}
  body_clay: {region: polygon, vertices: "0,1,12,1.6,12,2,9,2,7.619047619047619,3.380952380952381,0,3", material: clay}
  body_bed: {region: polygon, vertices: "0,0,12,0,12,1.6,0,1", material: rock}
"""
SOLID = {"mpm_dim": 3, "mpm_grid_lower": "0,0,0", "mpm_grid_upper": "12,6,2", "mpm_grid_cells": "12,6,2", "mpm_bc_west_lower": "0,0,0",
         "mpm_bc_west_upper": "0,6,2", "mpm_bc_east_lower": "12,0,0", "mpm_bc_east_upper": "12,6,2", "mpm_bc_base_lower": "0,0,0",
         "mpm_bc_base_upper": "12,0,2", "mpm_bc_base_components": "x,y,z", "mpm_load_weight_value": "0,-10,0"}


def write(test, bodies):
    path = test.folder() / "scene.yaml"
    path.write_text(SCENE + bodies, encoding="utf-8")
    return path


def sorted_table(run, name):
    """Rows by places: bodies that are drawn in other ways have their points in another order."""
    place = run.table("position0", "first") if name != "position0" else run.table(name, "first")
    return np.asarray(run.table(name))[np.lexsort(np.round(place, 9).T)]


def weight(run):
    return run.results.column("reaction_base_y")[-1]


with Test() as test:
    wall, pieces = test.run(write(test, WALL)), test.run(write(test, PIECES))
    test.near("wall.weight", weight(wall), 10 * (1800 * (48 - 2) + 2500 * 3), relative=1e-9)
    test.check("wall.stress", difference(sorted_table(wall, "stress"), sorted_table(pieces, "stress")), None, 1e-9)
    test.check("wall.ranks", difference(wall.table("stress"), test.run(write(test, WALL), ranks=3).table("stress")), None, 1e-9)
    first = WALL.replace("ground,wall", "wall,ground")
    test.check("wall.order", difference(sorted_table(test.run(write(test, first)), "stress"), sorted_table(wall, "stress")), None, 1e-9)
    none = test.run(write(test, WALL.replace('"5,2", upper: "6,5"', '"0,0", upper: "12,4"')), status=2)
    test.check("nothing_left", int("bodies with priority took all of it" in none.errors), 1, 1)
    test.check("overlap", int("unless one of them has priority" in test.run(write(test, WALL.replace("true", "false")), status=2).errors), 1, 1)
    late = test.run(write(test, LATE), status=2)
    test.check("late", int("one that joins later finds no place" in late.errors), 1, 1)
    test.near("replaced.weight", weight(test.run(write(test, REPLACED))), 10 * (1800 * 46 + 2500 * 2), relative=1e-9)
    layers, polygons = test.run(write(test, LAYERS)), test.run(write(test, POLYGONS))
    test.check("layers.stress", difference(sorted_table(layers, "stress"), sorted_table(polygons, "stress")), None, 1e-9)
    test.check("layers.ranks", difference(layers.table("stress"), test.run(write(test, LAYERS), ranks=3).table("stress")), None, 1e-9)
    below = test.run(write(test, LAYERS.replace("below: clay", "below: bed")), status=2)
    test.check("layers.below", int("-mpm_body_bed_below bed: must be one of fill, clay" in below.errors), 1, 1)
    solid = test.run(write(test, LAYERS), **SOLID)
    test.near("solid.weight", weight(solid), 2 * weight(layers), relative=1e-9)
