#!/usr/bin/env python3
"""Numbers of a material as fields: equal fields by body, region, cell and point make equal runs, as heights and uniform numbers do;
values between pilot points are those of ordinary kriging in numpy; restart, ranks, division and change of material keep them; bad
files end with one line.

Quick.
"""
import sys
from pathlib import Path

import h5py
import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import Test, difference  # noqa: E402

SCENE = Path(__file__).resolve().parent / "fields.yaml"
LOW, HIGH = 4e6, 1e6


def write(folder, name, lines):
    path = folder / name
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


def cells(values=lambda x, y: LOW if y < 2.0 else HIGH):
    """Rows x, y, E of the cells with material."""
    middles = [(x + 0.5, y + 0.5) for y in range(4) for x in range(4) if y < 2 or x < 2]
    return ["x,y,E"] + [f"{x},{y},{values(x, y):.17g}" for x, y in middles]


def krige(pilots, z, length, places):
    """Values at places by the system of ordinary kriging, covariance exp(-distance/length)."""
    count = len(pilots)
    matrix = np.zeros((count + 1, count + 1))
    matrix[count, :count] = matrix[:count, count] = 1.0
    matrix[:count, :count] = np.exp(-np.linalg.norm((pilots[:, None] - pilots[None]) / length, axis=2))
    right = np.ones((count + 1, len(places)))
    right[:count] = np.exp(-np.linalg.norm((pilots[:, None] - places[None]) / length, axis=2))
    return np.linalg.solve(matrix, right)[:count].T @ z


def options(**field):
    return {"mpm_quiet": None, **{"mpm_field_stiff_" + name: value for name, value in field.items()}}


def state(run, name="displacement"):
    return run.table(name)


def equal_fields(test, folder):
    """The layers by body, region, cell, point, and by height."""
    uniform = write(folder, "cells.csv", cells())
    numbers = write(folder, "numbers.csv", ["i,j,value"] + [f"{x},{y},{LOW if y < 2 else HIGH}" for y in range(4) for x in range(4)])
    names = write(folder, "names.csv", ["body,value", f"high,{HIGH}", f"low,{LOW}"])
    points = write(folder, "points.csv", ["E"] + [f"{LOW}"] * 32 + [f"{HIGH}"] * 16)
    with h5py.File(folder / "cells.h5", "w") as file:
        file["value"] = np.repeat([LOW, HIGH], 8).reshape(4, 4)
    ways = {"body_file": dict(by="body", file=names), "body": dict(by="body", bodies="low,high", values=f"{LOW},{HIGH}"),
            "region": {"by": "region", "regions": "foot,rest", "values": f"{LOW},{HIGH}", "foot_region": "box",
                       "foot_lower": "0,0", "foot_upper": "4,2", "rest_region": "all"},
            "cell": dict(by="cell", file=uniform), "numbers": dict(by="cell", file=numbers),
            "hdf5": dict(by="cell", file=folder / "cells.h5"), "point": dict(by="point", file=points)}
    height = test.run(SCENE, mpm_quiet=None, mpm_fields="", mpm_material_soil_E=f"0:{LOW},2:{LOW},2:{HIGH},4:{HIGH}")
    for name, field in ways.items():
        run = test.run(SCENE, **options(**field))
        test.check(f"{name}.E", difference(state(height, "E"), state(run, "E")), None, 0.0)
        test.check(f"{name}.displacement", difference(state(height), state(run)), None, 0.0)
    for ranks in (2, 3):
        for name in ("point", "cell"):
            run = test.run(SCENE, ranks=ranks, **options(**ways[name]))
            test.check(f"{name}.ranks={ranks}", difference(state(height), state(run)), None, 1e-9)
    return uniform


def pilots(test, folder):
    """Kriging, in the logarithm and not, with one length and two; equal values make the uniform number."""
    places = np.array([(0.3, 0.2), (3.7, 0.4), (1.9, 1.8), (0.4, 3.5)])
    values = np.array([4e6, 2e6, 8e5, 3e6])
    file = write(folder, "pilots.csv", ["x,y,E"] + [f"{x},{y},{v}" for (x, y), v in zip(places, values)])
    for label, log, length in (("log", "true", "1.5"), ("plain", "false", "2,0.7")):
        run = test.run(SCENE, **options(by="pilots", file=file, length=length, log=log))
        start = run.table("position", 0)[:, :2]
        scale = np.array([float(word) for word in length.split(",")])
        expected = krige(places / scale, np.log(values) if log == "true" else values, 1.0, start / scale)
        expected = np.exp(expected) if log == "true" else expected
        test.check(f"pilots.{label}", difference(expected, run.table("E", 0).ravel()), None, 1e-12)
    plain = test.run(SCENE, mpm_quiet=None, mpm_fields="", mpm_material_soil_E=2e6)
    same = test.run(SCENE, ranks=3, **options(by="pilots", file=file, length=1.0, values="2e6,2e6,2e6,2e6"))
    test.check("pilots.uniform", difference(state(plain), state(same)), None, 1e-9)
    return file


def kept(test, folder, file):
    """Points keep their values over a restart, division, and where they move to; other materials take them by place."""
    field = options(by="cell", file=file, **{})
    whole = test.run(SCENE, mpm_checkpoint_every=2, **field)
    again = test.run(SCENE, mpm_restart=whole.folder / "fields_checkpoint_000002.h5", **field)
    test.check("restart", difference(state(whole), state(again)), None, 1e-12)
    soft = write(folder, "soft.csv", cells(lambda x, y: 1.2e5 if y < 2.0 else 2e5))
    up = {"mpm_grid_upper": "4,8", "mpm_grid_cells": "4,8", "mpm_load_weight_value": "0,10"}
    run = test.run(SCENE, mpm_stabilization_divide=0.6, mpm_stabilization_ghost="off", **up, **options(by="cell", file=soft))
    values, identity = run.table("E").ravel(), run.table("id").ravel()
    test.check("divide.points", len(values), 49)
    first = identity // (identity.max() // 47) < 32  # ids have room between them; the lower body's come first
    test.check("divide.values", float(np.abs(values - np.where(first, 1.2e5, 2e5)).max()), None, 0.0)
    change = {"mpm_materials": "soil,fill", "mpm_material_fill_type": "hencky", "mpm_material_fill_E": 1e6, "mpm_material_fill_nu": 0.3,
              "mpm_material_fill_density": 1800, "mpm_body_high_material": "fill", "mpm_stages": "a,b", "mpm_stage_a_time_end": 0.5,
              "mpm_stage_b_time_end": 0.5, "mpm_stage_b_materials": "high:soil"}
    run = test.run(SCENE, **field, **change)
    test.check("change.values", np.abs(np.sort(run.table("E").ravel())[[0, -1]] - (HIGH, LOW)).max(), None, 0.0)
    test.run(SCENE, **options(by="body", bodies="low", values="1e6"), **change, status=2)


def strength(test, folder):
    """Strengths by cell fall with the reduction, and numbers that default to another vary with it."""
    file = write(folder, "cohesion.csv", ["x,y,cohesion"] + [row.replace("e+06", "e3") for row in cells(lambda x, y: 40e3 + 1e3 * x)[1:]])
    run = test.run(SCENE, mpm_quiet=None, mpm_material_soil_type="mohr_coulomb", mpm_material_soil_E=1e7,
                   mpm_material_soil_friction=20, mpm_material_soil_dilation=0, mpm_field_stiff_of="soil.cohesion",
                   mpm_field_stiff_by="cell", mpm_field_stiff_file=file, mpm_stages="weak", mpm_stage_weak_reduction="0:1,1:2")
    values, start = run.table("cohesion").ravel(), run.table("position", 0)
    part = values / (40e3 + 1e3 * (np.floor(start[:, 0]) + 0.5))
    test.check("reduction", part[0], 0.4, 0.95)
    test.check("reduction.places", float(np.ptp(part) / part[0]), None, 1e-12)


def refusals(test, folder, file, pilot_file):
    def refuse(label, words, E=None, **field):
        run = test.run(SCENE, status=2, **options(**field), **({"mpm_material_soil_E": E} if E else {}))
        test.check(f"{label}.line", words in run.errors and run.errors.count("\n") == 1, 1, 1)
        if words not in run.errors:
            print(run.errors)
        test.check(f"{label}.files", len(run.files), 0, 0)

    refuse("hole", "has no value", by="cell", file=write(folder, "hole.csv", cells()[:-1]))
    refuse("twice", "same cell", by="cell", file=write(folder, "twice.csv", cells() + ["0.6,0.7,1e6"]))
    refuse("body", "has body low twice", by="body", file=write(folder, "body.csv", ["name,value", "low,1e6", "low,2e6", "high,1e6"]))
    refuse("outside", "no cell of the grid", by="cell", file=write(folder, "outside.csv", cells() + ["7,0.5,1e6"]))
    refuse("negative", "the value -1", by="cell", file=write(folder, "negative.csv", cells() + ["3.5,3.5,-1"]))
    refuse("column", "must have a column E or value", by="cell", file=write(folder, "column.csv", ["x,y,F", "1,1,1e6"]))
    layers = dict(by="body", bodies="low,high", values="0.3,0.5")
    refuse("name", "has no number of this name", of="soil.Q", E="1e6", **layers)
    refuse("material", "no material of this name", of="clay.E", E="1e6", **layers)
    refuse("word", "has no number of this name", of="soil.type", E="1e6", **layers)
    refuse("missing_body", "no value of body high", by="body", bodies="low", values="1e6")
    refuse("other_body", "there is no body top", by="body", bodies="low,high,top", values="1e6,1e6,1e6")
    refuse("count", "must be 2", by="body", bodies="low,high", values="1e6")
    refuse("points", "must have 48", by="point", file=write(folder, "few.csv", ["value", "1e6"]))
    refuse("length", "length is missing", by="pilots", file=pilot_file)
    refuse("one_place", "two pilot points", by="pilots", length=1, file=write(folder, "one.csv", ["x,y,value", "1,1,1e6", "1,1,2e6"]))
    many = ["x,y,value"] + [f"{x / 5},{y / 5},1e6" for x in range(5) for y in range(5)]
    refuse("many", "more than cells", by="pilots", length=1, file=write(folder, "many.csv", many))
    refuse("poisson", "the value 0.5", of="soil.nu", E="1e6", **layers)


with Test() as test:
    place = test.folder()
    by_cell = equal_fields(test, place)
    by_pilots = pilots(test, place)
    kept(test, place, by_cell)
    strength(test, place)
    refusals(test, place, by_cell, by_pilots)
