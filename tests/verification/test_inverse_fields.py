#!/usr/bin/env python3
"""Inverse analyses by fields: values of each kind of field are found again from displacements that they made; gradients of the
regularizations agree with differences; data with noise are fitted to its level and not below; the file of a field is read as written.

Quick.
"""
import csv
import json
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import Test  # noqa: E402

SCENE = Path(__file__).resolve().parent / "fields.yaml"
BASE = {"mpm_quiet": None, "snes_rtol": 1e-12, "snes_stol": 0, "mpm_stabilization_ghost": "off", "mpm_output_every": 0,
        "mpm_time_step": 0.5}
PLACES = [(x + 0.5, y + 0.5) for y in range(4) for x in range(4) if y < 2 or x < 2]
PILOTS = [(0.3, 0.2), (3.7, 0.4), (1.9, 1.8), (0.4, 3.5)]
TRACKS = dict(zip("abcdefghij", ("0,4", "2,4", "2,2", "4,2", "1,3", "2,3", "3,1", "1,1", "0.5,2", "3,2")))
COLUMNS = [f"track_{name}_u{axis}" for name in TRACKS for axis in "xy"]
DEVIATION = 1e-5


def write(path, names, rows):
    lines = [",".join(names)] + [",".join(value if isinstance(value, str) else f"{value:.17g}" for value in row) for row in rows]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


def field(folder, kind, values):
    """Options of the field, whose values stand in a file."""
    options = {"mpm_field_stiff_by": kind}
    path = folder / f"{kind}.csv"
    if kind in ("cell", "pilots"):
        places = PLACES if kind == "cell" else PILOTS
        write(path, ("x", "y", "value"), [(*place, value) for place, value in zip(places, values)])
    elif kind == "point":
        write(path, ("id", "value"), enumerate(values))
    else:
        write(path, ("name", "value"), zip(("low", "high"), values))
    if kind == "pilots":
        options["mpm_field_stiff_length"] = 3
    if kind == "region":
        options |= {"mpm_field_stiff_regions": "low,high", "mpm_field_stiff_low_region": "box", "mpm_field_stiff_low_lower": "0,0",
                    "mpm_field_stiff_low_upper": "4,1", "mpm_field_stiff_high_region": "all"}
    return options | {"mpm_field_stiff_file": path}


def tracks():
    options = {"mpm_tracks": ",".join(TRACKS)}
    for name, place in TRACKS.items():
        options |= {f"mpm_track_{name}_at": place, f"mpm_track_{name}_nearest": 1}
    return options


def measure(test, folder, options, noise=None):
    """Displacements by the field, as data; the file."""
    results = test.run(SCENE, **BASE, **tracks(), **options).results
    table = np.stack([results.column(name) for name in COLUMNS], axis=1)
    if noise:
        table += DEVIATION * noise.standard_normal(table.shape)
    rows = np.column_stack([results.column("time"), table])
    return write(folder / "data.csv", ["time"] + COLUMNS, rows)


def asked(data, names=COLUMNS, noise=DEVIATION, **parameter):
    """The analysis of the field `stiff` by data."""
    options = {"mpm_task": "inverse", "mpm_parameters": "ground", "mpm_objectives": ",".join(name[6:] for name in names)}
    options |= {f"mpm_parameter_ground_{key}": value for key, value in ({"field": "stiff", "transform": "log"} | parameter).items()}
    for name in names:
        options |= {f"mpm_objective_{name[6:]}_{key}": value
                    for key, value in {"column": name, "data": data, "deviation": noise}.items()}
    return options


def analyse(test, options, ranks=1):
    run = test.run(SCENE, ranks=ranks, **BASE, **tracks(), **options)
    found = json.loads(Path(f"{run.prefix}_summary.json").read_text(encoding="utf-8"))["inverse"]
    return run, found


def rows(run, name):
    with open(f"{run.prefix}_{name}.csv", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def twins(test, folder):
    """Without noise the values come back: by each kind of field, and as a file that gives the same run."""
    rng = np.random.default_rng(1)
    for kind, count in (("cell", 12), ("pilots", 4), ("region", 2), ("body", 2)):
        truth = 1e6 * np.exp(rng.uniform(-0.4, 0.4, count))
        data = measure(test, folder, field(folder, kind, truth))
        options = field(folder, kind, truth) | asked(data, start=1e6, bounds="1e5,1e7")
        for ranks in (1, 3) if kind == "cell" else (1,):
            run, found = analyse(test, options, ranks)
            test.near(f"{kind}.ranks={ranks}", np.abs(np.array(found["values"]) / truth - 1.0).max(), 0.0, absolute=1e-6)
            test.check(f"{kind}.ranks={ranks}.iterations", found["iterations"], 1, 8)
        test.check(f"{kind}.covariance", np.array(found["covariance"]).shape == (count, count), 1, 1)
        test.check(f"{kind}.names", found["parameters"][0] == "ground_1", 1, 1)
        path = run.folder / found["fields"]["stiff"]["file"]
        again = test.run(SCENE, **BASE, **tracks(), **(field(folder, kind, truth) | {"mpm_field_stiff_file": path})).results
        test.check(f"{kind}.file", np.abs(again.column(COLUMNS[1]) - run.results.column(COLUMNS[1])).max(), None, 1e-14)
    data = measure(test, folder, field(folder, "body", (0.8e6, 1.3e6)))
    points = field(folder, "point", [0.8e6] * 32 + [1.3e6] * 16)
    run, found = analyse(test, points | asked(data, start=1e6, prior=1e6, deviation=1.0))
    values = np.array([float(row["value"]) for row in rows(run, "field_stiff")])
    test.check("point.order", values[32:].mean() / values[:32].mean(), 1.2)
    run, found = analyse(test, field(folder, "body", (1e6, 1e6)) | asked(data) | {"mpm_inverse_method": "blmvm"})
    test.near("blmvm", np.abs(np.array(found["values"]) / (0.8e6, 1.3e6) - 1.0).max(), 0.0, absolute=1e-5)


def regularizations(test, folder):
    """A step of `descent` is the rate times the gradient; differences are those of the objective at the start."""
    rng = np.random.default_rng(2)
    values = 1e6 * np.exp(rng.uniform(-0.5, 0.5, len(PLACES)))
    data = measure(test, folder, field(folder, "cell", [1e6] * len(PLACES)))
    change = rng.choice((-1.0, 1.0), len(values))
    for kind, more in (("tikhonov", {}), ("total_variation", {}), ("total_variation", {"smoothing": 0.5}), ("tikhonov", {"weight": 3.0}),
                       ("prior", {"length": 2}), ("prior", {"length": "3,0.5", "mean": 2e6})):
        label = "_".join([kind] + list(more))
        options = asked(data, names=COLUMNS[:1], noise=1.0) | {"mpm_inverse_method": "descent", "mpm_inverse_discrepancy": 0}
        options |= {"mpm_objectives": options["mpm_objectives"] + ",smooth", "mpm_objective_smooth_kind": kind,
                    "mpm_objective_smooth_field": "stiff"}
        options |= {f"mpm_objective_smooth_{key}": value for key, value in more.items()}
        if "weight" not in more:
            options["mpm_objective_smooth_deviation"] = 0.7
        if kind == "prior":
            options["mpm_parameter_ground_start"] = 1.5e6  # the mean where none is given
        start = values if kind != "prior" else np.full(len(values), 1.5e6)
        rate = 1e-3
        run, _ = analyse(test, field(folder, "cell", values) | options | {"mpm_inverse_rate": rate, "mpm_inverse_iterations": 1})
        trace = rows(run, "inverse")
        names = [f"ground_{k + 1}" for k in range(len(values))]
        first, last = (np.log([float(row[name]) for name in names]) for row in trace)
        test.near(f"{label}.start", np.abs(first - np.log(start)).max(), 0.0, absolute=1e-14)
        gradient = (first - last) / rate
        if kind == "prior" and "mean" not in more:
            test.near(f"{label}.gradient", np.abs(gradient).max(), 0.0, absolute=1e-3)
            continue
        ends = []
        options.pop("mpm_parameter_ground_start", None)
        if kind == "prior":
            options |= {"mpm_objective_smooth_mean": 2e6}
        for step in (-1e-5, 1e-5):
            moved = field(folder, "cell", start * np.exp(step * change))
            run, _ = analyse(test, moved | options | {"mpm_inverse_rate": rate, "mpm_inverse_iterations": 0})
            ends.append(float(rows(run, "inverse")[0]["objective"]))
        test.near(f"{label}.gradient", gradient @ change, (ends[1] - ends[0]) / 2e-5, relative=1e-6)


def correlated(test, folder):
    """The value of a prior by numpy, and its least objective by both methods."""
    data = measure(test, folder, field(folder, "cell", [1.4e6] * 6 + [0.8e6] * 6))
    more = {"mpm_objective_smooth_kind": "prior", "mpm_objective_smooth_field": "stiff", "mpm_objective_smooth_length": 2,
            "mpm_objective_smooth_deviation": 0.3, "mpm_objective_smooth_mean": 1e6, "mpm_inverse_tolerance": 1e-7}
    options = field(folder, "cell", [1e6] * 12) | asked(data, names=COLUMNS[::3], noise=3e-3) | more
    options["mpm_objectives"] += ",smooth"
    ends = {}
    for method in ("gauss_newton", "blmvm"):
        run, ends[method] = analyse(test, options | {"mpm_inverse_method": method, "mpm_inverse_iterations": 60})
    difference = np.abs(np.log(np.array(ends["blmvm"]["values"]) / ends["gauss_newton"]["values"])).max()
    test.near("prior.methods", difference, 0.0, absolute=1e-4)
    _, other = analyse(test, options | {"mpm_inverse_method": "blmvm", "mpm_inverse_iterations": 60}, ranks=3)
    test.near("prior.ranks=3", np.abs(np.log(np.array(other["values"]) / ends["blmvm"]["values"])).max(), 0.0, absolute=1e-5)
    found = ends["blmvm"]
    away = np.log(np.array(found["values"]) / 1e6) / 0.3
    places = np.array(PLACES)
    covariance = np.exp(-np.linalg.norm(places[:, None] - places[None], axis=2) / 2.0)
    by_hand = 0.5 * found["residuals"]["sum_of_squares"] + 0.5 * away @ np.linalg.solve(covariance, away)
    test.near("prior.objective", found["objective"], by_hand, relative=1e-9)


def noisy(test, folder):
    """More values than data, with noise: the end is at the noise's level; without the principle it is below."""
    truth = [0.8e6] * 32 + [1.3e6] * 16
    data = measure(test, folder, field(folder, "point", truth), np.random.default_rng(3))
    options = field(folder, "point", [1e6] * 48) | asked(data) | {"mpm_inverse_method": "blmvm", "mpm_inverse_iterations": 100}
    run, found = analyse(test, options)
    count = found["residuals"]["count"]
    test.check("noise.data", count, 40, 40)
    test.check("noise.level", found["residuals"]["sum_of_squares"] / count, 0.95, 1.0)
    test.check("noise.reason", found["reason"] == "the misfit is at the level of the noise", 1, 1)
    _, on = analyse(test, options | {"mpm_inverse_discrepancy": 0})
    test.check("noise.below", on["residuals"]["sum_of_squares"] / count, None, 0.93)
    squares = sum(float(row["residual"])**2 for row in rows(run, "residuals"))
    test.near("noise.residuals", squares, found["residuals"]["sum_of_squares"], relative=1e-9)


def refuse(test, label, words, **options):
    run = test.run(SCENE, status=2, **BASE, **tracks(), **options)
    good = words in run.errors and run.errors.count("\n") == 1
    test.check(f"{label}.line", good, 1, 1)
    test.check(f"{label}.files", len(run.files), 0, 0)
    if not good:
        print(run.errors)


def refusals(test, folder):
    values = [1e6] * len(PLACES)
    cell = field(folder, "cell", values)
    data = measure(test, folder, cell)
    smooth = {"mpm_objectives": "au,smooth", "mpm_objective_au_column": COLUMNS[0], "mpm_objective_au_data": data,
              "mpm_objective_smooth_kind": "tikhonov", "mpm_objective_smooth_field": "stiff"}
    base = asked(data)
    refuse(test, "starts", "must be 1", **cell, **base, mpm_inverse_starts=2)
    refuse(test, "bounds", "outside of its bounds", **cell, **asked(data, bounds="2e6,3e6"))
    refuse(test, "deviation", "deviation is missing", **cell, **(base | smooth))
    smooth["mpm_objective_smooth_deviation"] = 1
    refuse(test, "field", "is no field among", **cell, **(base | smooth | {"mpm_objective_smooth_field": "soft"}))
    refuse(test, "neighbours", "whose values have neighbours", **field(folder, "pilots", values[:4]), **(base | smooth))
    refuse(test, "places", "whose values have places", **field(folder, "body", values[:2]),
           **(base | smooth | {"mpm_objective_smooth_kind": "prior", "mpm_objective_smooth_length": 1}))
    refuse(test, "length", "length is missing", **cell, **(base | smooth | {"mpm_objective_smooth_kind": "prior"}))
    refuse(test, "task", "has no regularization", **cell, **(base | smooth | {"mpm_task": "gradient"}))
    many = [(0.2 * (k + 1), 0.5) for k in range(17)]
    path = write(folder / "many.csv", ("x", "y", "value"), [(*at, 1e6) for at in many])
    refuse(test, "pilots", "more than cells", **(field(folder, "pilots", values[:4]) | {"mpm_field_stiff_file": path}), **base)
    refuse(test, "all", "must be one, or 16", mpm_field_stiff_by="cell", mpm_field_stiff_values="1e6,2e6", **base)
    refuse(test, "none", "file is missing", mpm_field_stiff_by="point", **base)


with Test() as test:
    place = test.folder()
    twins(test, place)
    regularizations(test, place)
    correlated(test, place)
    noisy(test, place)
    refusals(test, place)
