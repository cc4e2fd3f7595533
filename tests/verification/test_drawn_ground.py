#!/usr/bin/env python3
"""Ground as it is drawn: bodies that replace others, and layers, against bodies drawn piece by piece, with their mass, on ranks. Points
at edges that cut their domains: mass and centroid of slopes, discs and spheres; Lame's thick sphere (1852) under inner pressure.

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


def write(test, bodies, scene=SCENE):
    path = test.folder() / "scene.yaml"
    path.write_text(scene + bodies, encoding="utf-8")
    return path


def sorted_table(run, name):
    """Rows by places: bodies that are drawn in other ways have their points in another order."""
    place = run.table("position0", "first") if name != "position0" else run.table(name, "first")
    return np.asarray(run.table(name))[np.lexsort(np.round(place, 9).T)]


def weight(run):
    return run.results.column("reaction_base_y")[-1]


DISC = """mpm:
  dim: 2
  grid: {lower: "0,0", upper: "2,2", cells: "8,8"}
  materials: soil
  material_soil: {type: linear_elastic, E: 1e6, nu: 0.3, density: 1}
  bodies: disc
  body_disc: {region: sphere, center: "1.013,0.987", radius: 0.8, material: soil, edge: cut}
  bcs: all
  bc_all: {region: box, lower: "0,0", upper: "2,2", components: "x,y"}
  time: {end: 1, step: 1}
"""
BALL = {"mpm_dim": 3, "mpm_grid_lower": "0,0,0", "mpm_grid_upper": "2,2,2", "mpm_grid_cells": "8,8,8",
        "mpm_body_disc_center": "1.013,0.987,1.007", "mpm_bc_all_lower": "0,0,0", "mpm_bc_all_upper": "2,2,2",
        "mpm_bc_all_components": "x,y,z"}
SPHERE = """mpm:
  dim: 2
  kinematics: axisymmetric
  grid: {lower: "0,0", upper: "2.25,2.25", cells: "%d,%d"}
  shape: gimp_bspline2
  materials: metal
  material_metal: {type: linear_elastic, E: 1e6, nu: 0.3, density: 0}
  bodies: ball
  body_ball: {region: polygon, vertices: "%s", material: metal, points_per_cell: "3,3", edge: %s}
  bcs: axis,plane
  bc_axis: {region: box, lower: "0,0", upper: "0,3", components: "x"}
  bc_plane: {region: box, lower: "0,0", upper: "3,0", components: "y"}
  surfaces: hole
  surface_hole: {body: ball, side: all, region: sphere, center: "0,0", radius: 1.3, normal: -1}
  time: {end: 1, step: 1}
"""


def check_cut(test):
    """Masses and first moments; layers share the boxes that their interface cuts."""
    for name, options, size in (("disc", {}, np.pi * 0.8**2), ("ball", BALL, 4 / 3 * np.pi * 0.8**3)):
        state = test.run(write(test, DISC, ""), **options).results.state("first")
        centre = [1.013, 0.987, 1.007][:state["position"].shape[1]]
        test.near(f"cut.{name}.volume", state["volume"].sum(), size, relative=1e-9)
        test.check(f"cut.{name}.centroid", np.abs(state["volume"] @ state["position"] / size - centre).max(), None, 1e-9)
    cut = {f"mpm_body_{name}_edge": "cut" for name in ("fill", "clay", "bed")}
    run, areas = test.run(write(test, LAYERS), **cut), (12.476190476190476, 18.423809523809524, 15.600000000000001)
    test.near("cut.layers.weight", weight(run), 10 * np.dot(areas, (1800, 1700, 2500)), relative=1e-9)
    ranks = test.run(write(test, LAYERS), ranks=3, **cut)
    test.check("cut.layers.ranks", difference(run.table("stress"), ranks.table("stress")), None, 1e-9)
    wall = test.run(write(test, WALL), mpm_body_ground_edge="cut", mpm_body_wall_edge="cut", mpm_body_wall_upper="5.8,5")
    test.near("cut.wall.weight", weight(wall), 10 * (1800 * (48 - 1.6) + 2500 * 2.4), relative=2e-3)


def thick_sphere(test, edge, cells):
    """Root mean square error of the radial stress between radii 1.2 and 1.8 of a sphere of 1 and 2 under a pressure of 1."""
    angle = np.linspace(0, np.pi / 2, 101)
    scale = np.sqrt(angle[1] / np.sin(angle[1]))  # a polygon of the circle's area
    arc = scale * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    vertices = ",".join(f"{abs(number):.12f}" for number in np.concatenate([2 * arc, arc[::-1]]).ravel())
    size = round(2.25 * cells)
    state = test.run(write(test, SPHERE % (size, size, vertices, edge), "")).results.state("last")
    (x, y), (xx, yy, _, xy) = state["position"].T, state["stress"][:, :4].T
    radius = np.hypot(x, y)
    radial = (x * x * xx + y * y * yy + 2 * x * y * xy) / radius**2
    error = (radial - (1 - (2 / radius) ** 3) / 7)[(radius > 1.2) & (radius < 1.8)]
    return np.sqrt(np.mean(error**2))


def check_sphere(test):
    """Order 2 in the interior, where whole domains give 1.5."""
    whole, coarse, fine = (thick_sphere(test, *case) for case in (("centers", 8), ("cut", 4), ("cut", 8)))
    test.check("sphere.stress", fine, None, 4e-3)
    test.check("sphere.order", np.log2(coarse / fine), 1.6)
    test.check("sphere.better", whole / fine, 1.3)


QUADRANT = """mpm:
  dim: 2
  grid: {lower: "0,0", upper: "4,4", cells: "12,12"}
  materials: soil
  material_soil: {type: hencky, E: 1e7, nu: 0.3, density: 1000}
  bodies: disc
  body_disc: {region: sphere, center: "0,0", radius: 3.05, clip_lower: "0,0", points_per_cell: "2,2", material: soil, edge: cut}
  bcs: west,base
  bc_west: {region: box, lower: "0,0", upper: "0,4", components: "x"}
  bc_base: {region: box, lower: "0,0", upper: "4,0", components: "y"}
  surfaces: rim
  surface_rim: {body: disc, side: all, normal: -1e4}
  time: {end: 1, step: 1}
"""


LEVEL = """mpm:
  dim: 2
  grid: {lower: "0,0", upper: "2,3", cells: "4,6"}
  materials: soil
  material_soil: {type: hencky, E: 1e8, nu: 0.3, density: 2000}
  bodies: soil
  body_soil: {region: box, lower: "0,0", upper: "2,2.3", points_per_cell: "2,2", material: soil, edge: cut}
  bcs: sides,base
  bc_sides: {region: all, components: "x"}
  bc_base: {region: box, lower: "0,0", upper: "2,0", components: "y"}
  loads: weight
  load_weight: {type: gravity, value: "0,-10"}
  surfaces: top
  surface_top: {body: soil, side: "+y"}
  time: {end: 1, step: 1}
"""


def check_level(test):
    """The topmost points of level ground between rows of boxes, under a pressure and a traction: stress at their height."""
    for name, load in (("normal", {"normal": -5e4}), ("traction", {"traction": "0,-5e4"})):
        run = test.run(write(test, LEVEL, ""), **{f"mpm_surface_top_{key}": value for key, value in load.items()})
        y, stress = run.table("position", 0)[:, 1], run.table("stress")[:, 1]
        top = y > y.max() - 1e-9
        test.near(f"level.{name}", stress[top].mean(), -5e4 - 2e4 * (2.3 - y.max()), relative=1e-5)


def check_pressure(test):
    """Uniform pressure on a disc with a cut edge: stress, where faces of boxes alone are 5 % off."""
    for shape, bound in (("linear", 0.015), ("gimp", 2e-3)):
        run = test.run(write(test, QUADRANT, ""), mpm_shape=shape)
        volume, away = run.table("volume").ravel(), run.table("stress")[:, :2] / 1e4 + 1
        test.check(f"pressure.{shape}", np.sqrt(np.mean(volume @ away**2) / volume.sum()), None, bound)
        test.check(f"pressure.{shape}.iterations", run.newton.max(), None, 3)


HELD = """mpm:
  dim: 2
  grid: {lower: "0,0", upper: "8,8", cells: "16,16"}
  materials: soil
  material_soil: {type: linear_elastic, E: 1e6, nu: 0.3, density: 1}
  bcs: pin,roller
  bc_pin: {region: box, lower: "3,4", upper: "3,4", components: "x,y"}
  bc_roller: {region: box, lower: "5,4", upper: "5,4", components: "y"}
  bodies: block
  surfaces: part
  time: {end: 1, step: 1}
"""


def corners(middle, along, half, thick):
    """Corners of a rectangle about a place, with its sides along a direction and across it."""
    across = np.array([-along[1], along[0]])
    return ",".join(f"{number:.9f}" for s, t in ((-1, -1), (1, -1), (1, 1), (-1, 1))
                    for number in middle + s * half * along + t * thick * across)


def check_resultants(test):
    """Force and moment on a part of an edge at an angle, in 2D; and on half a sphere, on ranks."""
    for degrees, load, ranks in ((17, "normal: 1", 1), (31, 'traction: "0.5,1"', 3), (45, "normal: 1", 1)):
        along = np.array([np.cos(np.radians(degrees)), np.sin(np.radians(degrees))])
        middle, normal = np.array([4.13, 4.21]), np.array([-along[1], along[0]])
        run = test.run(write(test, f"""  body_block: {{region: polygon, vertices: "{corners(middle, along, 2, 1.2)}", material: soil, edge: cut}}
  surface_part: {{body: block, side: all, region: polygon, vertices: "{corners(middle + 1.2 * normal, along, 1.2, 0.5)}", {load}}}
""", HELD), ranks=ranks)
        x, y, roller = (-run.results.column(f"reaction_{name}")[-1] for name in ("pin_x", "pin_y", "roller_y"))
        force = 2.4 * (normal if "normal" in load else np.array([0.5, 1]))
        arm = middle + 1.2 * normal - (3, 4)
        away = np.array([x, y + roller, 2 * roller]) - (force[0], force[1], arm[0] * force[1] - arm[1] * force[0])
        test.check(f"resultant.{degrees}", np.abs(away).max() / 2.4, None, 1e-4)
    run = test.run(write(test, """  surfaces: top
  surface_top: {body: disc, side: all, region: box, lower: "0,0,1.007", upper: "2,2,2", normal: -1}
""", DISC), **BALL)
    force = np.array([run.results.column(f"reaction_all_{axis}")[-1] for axis in "xyz"])
    test.check("resultant.sphere", np.abs(force - (0, 0, np.pi * 0.8**2)).max() / (np.pi * 0.8**2), None, 2e-3)


def check_interface(test):
    """Slopes cut by a wall with priority, and by an interface of layers: force on what is free."""
    slope = np.array([[0, 4.37], [3.2, 4.37], [7.1, 1.3], [8, 1.3]])

    def drop(left, right):
        """Force of a normal stress of 1 on the surface between two places."""
        heights = np.interp((left, right), *slope.T)
        return np.array([heights[0] - heights[1], right - left])

    line = ",".join(f"{number}" for number in slope.ravel())
    parts = '  surface_part: {body: %s, side: all, region: box, lower: "0.6,0.4", upper: "7.4,8", normal: 1}\n'
    wall = f"""  bodies: block,wall
  body_block: {{region: polygon, vertices: "0,0,8,0,{",".join(f"{number}" for number in slope[::-1].ravel())}", material: soil, edge: cut}}
  body_wall: {{region: box, lower: "4.6,0", upper: "5.37,5.1", priority: true, material: soil, edge: cut}}
"""
    layers = f"""  bodies: block,below
  body_block: {{region: layers, top: "{line}", bottom: "0,2.2,8,2.6", material: soil, edge: cut}}
  body_below: {{region: layers, below: block, material: soil, edge: cut}}
"""
    toe = 3.2 + (4.37 - 2.2 - 0.05 * 3.2) / (3.07 / 3.9 + 0.05)
    base = HELD.replace('  bc_roller: {region: box, lower: "5,4", upper: "5,4", components: "y"}\n', "").replace("  bodies: block\n", "").replace(
        'lower: "3,4", upper: "3,4"', 'lower: "0,0", upper: "8,0"').replace("pin,roller", "pin")
    for name, body, drawn, force in (("wall", "block", wall, drop(0.6, 4.6) + drop(5.37, 7.4)), ("layer", "block", layers, drop(0.6, toe)),
                                     ("below", "below", layers, drop(toe, 7.4))):
        run = test.run(write(test, drawn + parts % body, base))
        away = [run.results.column(f"reaction_pin_{axis}")[-1] + force[k] for k, axis in enumerate("xy")]
        test.check(f"interface.{name}", np.abs(away).max() / np.abs(force).max(), None, 1e-3)


BLOCK = """  bodies: block
  body_block: {region: box, lower: "1,1", upper: "5,2", material: sand}
  motions: push
  motion_push: {body: block, components: "x,y", value: "4.3,0.7"}
  sections: row
  section_row: {point: "1,1.5", end: "5,1.5", count: 9, body: block, follow: true}
"""


def row_of_cuts(run):
    """Columns of the last state's row."""
    names, *rows = [line.split(",") for line in Path(f"{run.prefix}_section_row.csv").read_text(encoding="utf-8").splitlines()]
    return {name: np.array([float(row[k]) for row in rows[-9:]]) for k, name in enumerate(names)}


def check_follow(test):
    """A row of cuts goes along with a block that is moved, its first and last cut a cell wide at the ends; else it meets nothing."""
    moved = {"mpm_bcs": "base", "mpm_bc_base_components": "y"}
    row = row_of_cuts(test.run(write(test, BLOCK), **moved))
    test.near("follow.area", row["area"][1:-1].mean(), 1.0, relative=0.02)
    for name, value, place in (("first", row["x"][0], 5.8), ("last", row["x"][-1], 8.8), ("middle", row["x"][4], 7.3), ("height", row["y"][4], 2.2)):
        test.near(f"follow.{name}", value, place, absolute=0.05)
    test.check("follow.not", row_of_cuts(test.run(write(test, BLOCK), mpm_section_row_follow="false", **moved))["area"].max(), 0, 0)
    single = test.run(write(test, BLOCK.replace('end: "5,1.5", count: 9', 'normal: "1,0"')), status=2)
    test.check("follow.single", int("follow" in single.errors), 1, 1)


with Test() as test:
    check_follow(test)
    check_cut(test)
    check_sphere(test)
    check_pressure(test)
    check_level(test)
    check_resultants(test)
    check_interface(test)
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
