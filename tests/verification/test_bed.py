#!/usr/bin/env python3
"""The bed of a flow over terrain: dams that are raised on it, the force of the flow on them, and pixels without data under the material.

Quick.
"""
import json
import math
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import Test  # noqa: E402

SCENE = """mpm:
  dim: 2
  physics: depth_averaged
  terrain: {{file: {file}{terrain}}}
{blocks}  grid: {{lower: "0,0", upper: "200,100", cells: "80,40"}}
  materials: water
  material_water: {{type: coulomb, mu: 0.01, density: 1000}}
  bodies: flow
  body_flow: {{region: box, lower: "{lower}", upper: "{upper}", points_per_cell: "2,2", {fill}, material: water}}
  bcs: south,north,west,east
  bc_south: {{region: box, lower: "0,0", upper: "200,0", components: "y"}}
  bc_north: {{region: box, lower: "0,100", upper: "200,100", components: "y"}}
  bc_west: {{region: box, lower: "0,0", upper: "0,100", components: "x"}}
  bc_east: {{region: box, lower: "200,0", upper: "200,100", components: "x"}}
  time: {{integrator: explicit, cfl: 0.4, end: {end}}}
  output: {{every: 0}}
  quiet: true
"""
CELL = 2.0
LINE = [[120.0, 20.0], [120.0, 80.0], [140.0, 90.0]]


def write_map(path, values):
    with open(path, "w", encoding="utf-8") as file:
        file.write(f"ncols {values.shape[1]}\nnrows {values.shape[0]}\nxllcenter -2\nyllcenter -2\ncellsize {CELL}\nNODATA_value -9999\n")
        file.writelines(" ".join(repr(float(v)) for v in row) + "\n" for row in values[::-1])


def places(points):
    """x and y of the pixels that points lie between, and their parts of the way."""
    return [(points[:, a] + 2.0) / CELL for a in (0, 1)]


def bilinear(z, points):
    x, y = places(points)
    i, j = np.floor(x).astype(int), np.floor(y).astype(int)
    u, v = x - i, y - j
    return (1 - u) * (1 - v) * z[j, i] + u * (1 - v) * z[j, i + 1] + (1 - u) * v * z[j + 1, i] + u * v * z[j + 1, i + 1]


def raised(x, y, z, ground, height, crest, batter):
    """The dam's own form over every pixel."""
    result = z.copy()
    for row in range(z.shape[0]):
        for column in range(z.shape[1]):
            best = (math.inf, 0.0, 0.0)
            for (ax, ay), (bx, by) in zip(LINE, LINE[1:]):
                part = ((x[row, column] - ax) * (bx - ax) + (y[row, column] - ay) * (by - ay)) / ((bx - ax) ** 2 + (by - ay) ** 2)
                part = min(max(part, 0.0), 1.0)
                px, py = ax + part * (bx - ax), ay + part * (by - ay)
                best = min(best, (math.hypot(x[row, column] - px, y[row, column] - py), px, py))
            top = ground(best[1], best[2]) + height - max(0.0, best[0] - crest / 2) / batter
            result[row, column] = max(result[row, column], top)
    return result


class Bed:
    def __init__(self, test):
        self.test, self.folder = test, test.folder()

    def run(self, file="slope.asc", terrain="", blocks="", end=1.0, lower="10,10", upper="190,90", fill="depth: 1", status=0, ranks=1, **options):
        path = self.folder / "bed.yaml"
        path.write_text(SCENE.format(file=file, terrain=terrain, blocks=blocks, end=end, lower=lower, upper=upper, fill=fill))
        return self.test.run(path, status=status, ranks=ranks, **options)

    def points(self, **options):
        return self.run(mpm_task="points", mpm_output_every=1, **options).results.state("last")


def ground(x, y):
    return 50.0 - 0.1 * x + 0.02 * y


with Test() as test:
    bed = Bed(test)
    y, x = np.mgrid[0:53, 0:103] * CELL - 2.0
    slope = ground(x, y)
    write_map(bed.folder / "slope.asc", slope)
    (bed.folder / "dam.geojson").write_text(json.dumps({"type": "LineString", "coordinates": LINE}))

    # a dam by its line, by its level, and as a map
    state = bed.points(terrain=", raise: dam", blocks="  raise_dam: {file: dam.geojson, height: 8, crest: 3, batter: 1.5}\n")
    exact = bilinear(raised(x, y, slope, ground, 8.0, 3.0, 1.5), state["position"])
    test.near("dam.height", float(abs(state["bed"].ravel() - exact).max()), 0, absolute=1e-9)
    state = bed.points(terrain=", raise: dam", blocks="  raise_dam: {file: dam.geojson, level: 45, crest: 3, batter: 1.5}\n")
    exact = bilinear(raised(x, y, slope, lambda a, b: 45.0, 0.0, 3.0, 1.5), state["position"])
    test.near("dam.level", float(abs(state["bed"].ravel() - exact).max()), 0, absolute=1e-9)
    wall = np.full(slope.shape, -9999.0)
    wall[20:30, 60:63] = 5.0
    write_map(bed.folder / "wall.asc", wall)
    state = bed.points(terrain=", raise: wall", blocks="  raise_wall: {file: wall.asc}\n")
    exact = bilinear(slope + np.where(wall > 0, wall, 0.0), state["position"])
    test.near("dam.map", float(abs(state["bed"].ravel() - exact).max()), 0, absolute=1e-9)
    held = bed.run(terrain=", raise: dam", blocks="  raise_dam: {file: dam.geojson, height: 20, crest: 3, batter: 1.5}\n", end=8.0,
                   lower="60,30", upper="80,70").results.state("last")
    free = bed.run(end=8.0, lower="60,30", upper="80,70").results.state("last")
    middle = [state["position"][abs(state["position"][:, 1] - 50) < 20, 0] for state in (held, free)]
    test.check("dam.holds", float(middle[0].max()), 85, 110)
    test.check("dam.free", float(middle[1].max()), 125, 200)

    # force on a dam across a channel: water at rest, its weight on the face; an impulse is what momentum is lost
    write_map(bed.folder / "level.asc", np.zeros(slope.shape))
    (bed.folder / "across.geojson").write_text(json.dumps({"type": "LineString", "coordinates": [[149.5, -2], [149.5, 102]]}))
    across = {"file": "level.asc", "terrain": ", raise: dam", "blocks": "  raise_dam: {file: across.geojson, height: 16, crest: 3, batter: 2}\n",
              "mpm_grid_cells": "100,5", "mpm_material_water_mu": 0.0, "mpm_output_every": 10000}
    for ranks in (1, 3):
        rest = bed.run(lower="0,0", upper="148,100", end=0.3, fill="level: 8", ranks=ranks, **across).results.column
        test.near(f"force.rest.{ranks}", float(rest("force_dam_x")[-1]), 0.5 * 9810 * 8**2 * 100, relative=1e-9)
    test.near("force.weight", float(rest("force_dam_z")[-1]), -0.5 * 9810 * 8 * 16 * 100, relative=0.03)
    test.near("force.across", float(abs(rest("force_dam_y")).max()), 0, absolute=1e-6)
    for curvature in ("none", "path"):
        hit = bed.run(lower="60,0", upper="110,100", end=4.0, mpm_body_flow_velocity="15,0", mpm_curvature=curvature, **across).results.column
        impulse, momentum = float((hit("force_dam_x") * hit("dt"))[1:].sum()), hit("momentum_x")
        test.near(f"force.{curvature}", impulse, float(momentum[0] - momentum[-1]), relative=0.01)
        test.check(f"force.{curvature}.taken", impulse / float(momentum[0]), 0.1, 1)

    # pixels without data: material on them ends the run, or is gone
    hole = slope.copy()
    hole[:, 60:70] = -9999
    write_map(bed.folder / "hole.asc", hole)
    beside = bed.run(file="hole.asc", end=0.5, lower="60,30", upper="80,70").results.state("last")
    test.check("hole.beside", len(beside["volume"]), 512, 512)
    for ranks in (1, 3):
        run = bed.run(file="hole.asc", end=20.0, lower="60,30", upper="80,70", status=3, ranks=ranks)
        test.check(f"hole.ends.{ranks}", "where the terrain has no data" in run.errors, 1, 1)
        if "where the terrain has no data" not in run.errors:
            print(run.status, run.errors)
    ends = [bed.run(file="hole.asc", terrain=", outflow: true", end=8.0, lower="60,30", upper="80,70", ranks=ranks).results.state("last")
            for ranks in (1, 3)]
    test.check("hole.leaves", len(ends[0]["volume"]), 1, 511)
    test.check("hole.inside", float(ends[0]["position"][:, 0].max()), 60, 117)
    test.check("hole.ranks", float(abs(ends[0]["position"] - ends[1]["position"]).max()), 0, 1e-9)

    # friction by a map: an even one as the number, on a halved one each half as its own number; ranks agree
    write_map(bed.folder / "even.asc", np.full(slope.shape, 0.05))
    write_map(bed.folder / "halves.asc", np.where(y < 50, 0.02, 0.3))
    box = {"lower": "60,30", "upper": "80,70", "end": 4.0}
    numbers = {mu: bed.run(mpm_material_water_mu=mu, **box).results.state("last")["position"] for mu in (0.02, 0.05, 0.3)}
    even = bed.run(mpm_material_water_mu=bed.folder / "even.asc", **box).results.state("last")["position"]
    test.check("friction.even", float(abs(even - numbers[0.05]).max()), 0, 1e-11)
    halves = [bed.run(mpm_material_water_mu=bed.folder / "halves.asc", ranks=ranks, **box).results.state("last")["position"] for ranks in (1, 3)]
    test.check("friction.ranks", float(abs(halves[0] - halves[1]).max()), 0, 1e-9)
    for side, mu in ((-1, 0.02), (1, 0.3)):
        far = side * (numbers[mu][:, 1] - 50) > 12
        moved = [float(np.mean(p[far, 0])) - 70 for p in (halves[0], numbers[0.02], numbers[0.3])]
        test.check(f"friction.{mu}", abs(moved[0] - moved[1 if mu == 0.02 else 2]) / abs(moved[1] - moved[2]), 0, 0.1)
    write_map(bed.folder / "wrong.asc", np.full(slope.shape, -0.5))
    run = bed.run(mpm_material_water_mu=bed.folder / "wrong.asc", status=2)
    test.check("friction.line", "has -0.5, must" in run.errors and run.errors.count("\n") == 1, 1, 1)
    if "has -0.5, must" not in run.errors:
        print(run.errors)

    for label, words, terrain, blocks in (
            ("file", "cannot be read", ", raise: dam", "  raise_dam: {file: nowhere.geojson, height: 8}\n"),
            ("both", "the height is given, too", ", raise: dam", "  raise_dam: {file: dam.geojson, height: 8, level: 9}\n"),
            ("neither", "a line needs a height or a level", ", raise: dam", "  raise_dam: {file: dam.geojson}\n"),
            ("smooth", "must be auto or 0", "", "  stabilization: {smooth: 0.1}\n"),
            ("height", "must be > 0", ", raise: dam", "  raise_dam: {file: dam.geojson, height: -1}\n")):
        run = bed.run(terrain=terrain, blocks=blocks, status=2)
        test.check(f"{label}.line", words in run.errors and run.errors.count("\n") == 1, 1, 1)
        if words not in run.errors:
            print(run.errors)
