#!/usr/bin/env python3
"""Bodies side by side: those that overlap while both are there are refused, those that only touch are not.

Every case runs on 1 and 3 ranks. The header of a run says which bodies share nodes, for there they are welded.
"""
import re
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import Run, Test  # noqa: E402

SCENE = {
    "mpm_dim": "2", "mpm_grid_lower": "0,0", "mpm_grid_upper": "4,4", "mpm_grid_cells": "4,4",
    "mpm_materials": "soil", "mpm_material_soil_type": "hencky", "mpm_material_soil_E": "1e6",
    "mpm_material_soil_nu": "0.3", "mpm_material_soil_density": "1000",
    "mpm_bcs": "base,side", "mpm_bc_base_region": "box", "mpm_bc_base_lower": "0,0", "mpm_bc_base_upper": "4,0",
    "mpm_bc_base_components": "x,y", "mpm_bc_side_region": "box", "mpm_bc_side_lower": "0,0",
    "mpm_bc_side_upper": "0,4", "mpm_bc_side_components": "x,y",
    "mpm_loads": "weight", "mpm_load_weight_type": "gravity", "mpm_load_weight_value": "0,-1",
    "mpm_time_step": "0.5", "mpm_output_every": "0",
}
LOWER = (0, 0, 2, 2)
REPLACED = {"mpm_stages": "one,two", "mpm_stage_two_remove": "a", "mpm_stage_two_bodies": "b"}


def body(name, region, points="2,2", **entries):
    entries = {"region": region, "material": "soil", **entries}
    if region != "file":
        entries["points_per_cell"] = points
    return {f"mpm_body_{name}_{key}": value for key, value in entries.items()}


def box(name, corners, points="2,2"):
    return body(name, "box", points, lower="{},{}".format(*corners[:2]), upper="{},{}".format(*corners[2:]))


def polygon(name, vertices, points="2,2"):
    return body(name, "polygon", points, vertices=vertices)


def disc(name, center, radius, points="2,2"):
    return body(name, "sphere", points, center=center, radius=radius)


def lattice(x, y, columns, rows, space):
    """A table of points on a lattice whose lower corner is x, y."""
    places = [(x + space * (i + 0.5), y + space * (j + 0.5)) for i in range(columns) for j in range(rows)]
    return "x,y,volume\n" + "".join(f"{a:.17g},{b:.17g},{space * space:.17g}\n" for a, b in places)


# name, bodies a and b and what else, the tables they come from, and where they overlap; None: they do not; and points then
CASES = [
    ("common_face", {**box("a", LOWER), **box("b", (0, 2, 2, 3))}, {}, None, 24),
    ("common_face_other_lattice", {**box("a", LOWER), **box("b", (0, 2, 2, 3), "3,3")}, {}, None, 34),
    ("face_through_points", {**box("a", (0, 0, 2, 1.75)), **box("b", (0, 1.75, 2, 3))}, {}, None, 24),
    ("face_through_points_of_one", {**box("a", (0, 0, 2, 1.75)), **box("b", (0, 1.75, 2, 3), "3,3")}, {}, None, 40),
    ("face_through_points_aslant", {**polygon("a", "0,0,2,0,2,2"), **polygon("b", "0,0,2,2,0,2")}, {}, None, 16),
    ("disc_in_a_hole", {**disc("a", "2,2", 1), **polygon("b", "0,0,4,0,4,1,0,1", "3,3")}, {}, None, 48),
    ("replaced_by_a_stage", {**box("a", LOWER), **box("b", (0, 1, 2, 3)), **REPLACED}, {}, None, 16),
    ("points_beside", {**box("a", LOWER), **body("b", "file", file="b.csv")}, {"b": lattice(0, 2, 4, 2, 0.5)}, None, 24),
    ("other_points_beside", {**box("a", LOWER), **body("b", "file", file="b.csv")}, {"b": lattice(0, 2, 6, 3, 1 / 3)}, None, 34),
    ("points_beside_points", {**body("a", "file", file="a.csv"), **body("b", "file", file="b.csv")},
     {"a": lattice(0, 0, 4, 4, 0.5), "b": lattice(0, 2, 4, 2, 0.5)}, None, 24),
    ("overlap", {**box("a", LOWER), **box("b", (0, 1, 2, 3))}, {}, "0.25, 1.25", 0),
    ("overlap_of_another_lattice", {**box("a", LOWER), **box("b", (0, 1, 2, 3), "3,3")}, {}, "0.25, 1.25", 0),
    ("overlap_of_one_row", {**box("a", LOWER), **box("b", (0, 1.7, 2, 3))}, {}, "0.25, 1.75", 0),
    ("one_in_the_other", {**box("a", LOWER), **box("b", (0.5, 0.5, 1, 1), "3,3")}, {}, "0.75, 0.75", 0),
    ("disc_over_a_corner", {**box("a", LOWER), **disc("b", "2,2", 1.2)}, {}, "1.25, 1.25", 0),
    ("joins_on_top_of_another", {**box("a", LOWER), **box("b", (0, 1, 2, 3)), "mpm_stages": "one,two", "mpm_stage_two_bodies": "b"},
     {}, "0.25, 1.25", 0),
    ("points_in_a_box", {**box("a", LOWER), **body("b", "file", file="b.csv")}, {"b": lattice(0, 1, 4, 2, 0.5)}, "0.25, 1.25", 0),
    ("one_point_in_a_box", {**box("a", LOWER), **body("b", "file", file="b.csv")}, {"b": lattice(0.75, 0.75, 1, 1, 0.5)}, "1, 1", 0),
    ("points_among_points", {**body("a", "file", file="a.csv"), **body("b", "file", file="b.csv")},
     {"a": lattice(0, 0, 4, 4, 0.5), "b": lattice(0.1, 1.1, 3, 2, 0.5)}, "0.25, 1.25", 0),
]


def run(test, bodies, tables, ranks, names="a,b"):
    folder = test.folder()
    options = {**SCENE, "mpm_bodies": names, **bodies}
    (folder / "scene.yaml").write_text("".join(f'{name}: "{value}"\n' for name, value in options.items()), encoding="utf-8")
    for name, text in tables.items():
        (folder / f"{name}.csv").write_text(text, encoding="utf-8")
    return Run(test.program, folder / "scene.yaml", ranks, {}, folder)


def welded(ended):
    return re.findall(r"^  bodies that share nodes are welded there: (.*)$", ended.output, re.M)


with Test() as test:
    for label, bodies, tables, place, points in CASES:
        for ranks in (1, 3):
            ended = run(test, bodies, tables, ranks)
            if place is None:
                test.check(f"{label}.{ranks}.points", int(f"\n  {points} points," in ended.output), 1, 1)
                test.check(f"{label}.{ranks}.status", ended.status, 0, 0)
            else:
                line = f"talus: error: -mpm_bodies: a and b overlap, for example at ({place}"
                test.check(f"{label}.{ranks}.refused", int(ended.status == 2 and line in ended.errors.replace(".,", ",").replace(".)", ")")), 1, 1)
    twice = run(test, body("a", "file", file="a.csv"), {"a": lattice(0, 0, 4, 4, 0.5) + "1.25,0.75,0.25\n"}, 3, "a")
    line = "talus: error: -mpm_body_a_file: two of its points stand at (1.25, 0.75); each place must be there once\n"
    test.check("row_twice", int(twice.status == 2 and line in twice.errors), 1, 1)
    head, *rows = lattice(0, 0, 4, 4, 0.5).splitlines(keepends=True)
    equally = {"mpm_tracks": "t,s", "mpm_track_t_at": "1,1", "mpm_track_s_at": "1,0.75", "mpm_track_s_nearest": "3", "mpm_output_every": "1"}
    for ranks, order in ((1, rows), (1, rows[::-1]), (3, rows[::-1])):
        results = run(test, {**body("a", "file", file="a.csv"), **equally}, {"a": "".join([head, *order])}, ranks, "a").results
        start, end = results.state("first"), results.state("last")
        moved = {tuple(map(float, x)): u for x, u in zip(start["position0"], end["displacement"])}
        one, third = (next(place for place in (tuple(map(float, row.split(",")[:2])) for row in order) if place in far)
                      for far in ([(x, y) for x in (0.75, 1.25) for y in rows_of] for rows_of in ((0.75, 1.25), (0.25, 1.25))))
        three = (moved[0.75, 0.75] + moved[1.25, 0.75] + moved[third]) / 3
        for axis, name in enumerate("xy"):
            for track, mean in (("t", moved[one]), ("s", three)):
                test.near(f"equally_near.{ranks}.{track}.{name}", results.history[f"track_{track}_u{name}"][-1], mean[axis], relative=1e-12)
    blocks = {**box("a", (0, 0, 1, 1)), **box("b", (1, 0, 2, 1)), **box("c", (3.5, 0, 4, 1)), **box("d", (0, 1, 1, 2)),
              **box("e", (0, 2, 1, 3)), **box("f", (2, 0, 3, 1))}
    for ranks in (1, 3):
        lines = welded(run(test, blocks, {}, ranks, "a,b,c,d,e,f"))
        test.check(f"welded.{ranks}", int(lines == ["a and b, a and d, b and f, and 2 more"]), 1, 1)
        apart = {**box("a", (0, 0, 1, 1)), **box("b", (3, 0, 4, 1))}
        test.check(f"apart.{ranks}", len(welded(run(test, apart, {}, ranks))), 0, 0)
    test.check("alone", len(welded(run(test, box("a", LOWER), {}, 1, "a"))), 0, 0)
    test.check("not_yet_there", len(welded(run(test, {**box("a", LOWER), **box("b", (0, 1, 2, 3)), **REPLACED}, {}, 1))), 0, 0)
