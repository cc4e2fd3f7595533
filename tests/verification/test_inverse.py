#!/usr/bin/env python3
"""Inverse analyses: numbers of a scene are found again from its own results, and how sure they are is told rightly.

Data are made by the scene itself with known numbers, and the analysis starts elsewhere. Statistics are compared with numpy's
from the Jacobian that is written, the Jacobian with differences of runs.

Quick.
"""
import csv
import json
import os
import sys
from pathlib import Path

import numpy as np
import pandas as pd

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import ROOT, Test, example  # noqa: E402

BEAM = {"mpm_grid_cells": "30,30", "mpm_body_beam_points_per_cell": "3,3", "mpm_time_step": 0.25, "mpm_output_every": 0,
        "snes_rtol": 1e-12, "snes_stol": 0, "mpm_quiet": None}
WET = Path(__file__).resolve().parent / "gradient_poro.yaml"
E, NU = 12e6, 0.2
COLUMNS = ("time", "track_tip_ux", "track_tip_uy")


def write(path, table):
    rows = zip(*table.values())
    path.write_text(",".join(table) + "\n" + "".join(",".join(f"{value:.17g}" for value in row) + "\n" for row in rows))


def read(path):
    """Columns of numbers of a table, by name."""
    with open(path, encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    return {name: np.array([float(row[name]) for row in rows]) for name, value in rows[0].items() if not value[0].isalpha()}


def blocks(folder, *objectives, deviation=1e-3):
    """Objectives on the displacements of the tip."""
    asked = {"mpm_task": "inverse", "mpm_objectives": ",".join(objectives)}
    for name in objectives:
        asked |= {f"mpm_objective_{name}_column": f"track_tip_{name}", f"mpm_objective_{name}_data": str(folder / "data.csv")}
        if deviation:
            asked[f"mpm_objective_{name}_deviation"] = deviation
    return asked


def parameters(**given):
    asked = {"mpm_parameters": ",".join(given)}
    for name, block in given.items():
        asked |= {f"mpm_parameter_{name}_{key}": value for key, value in block.items()}
    return asked


YOUNG = {"of": "beam.E", "transform": "log", "bounds": "1e6,1e9", "start": 8e6}
POISSON = {"of": "beam.nu", "transform": "logit", "bounds": "0,0.45", "start": 0.3}


def analyse(test, ranks=1, status=0, scene=None, **options):
    run = test.run(scene or example("cantilever"), ranks=ranks, status=status, **{**({} if scene else BEAM), **options})
    return run, (json.loads(Path(f"{run.prefix}_summary.json").read_text())["inverse"] if run.prefix else None)


def refuse(test, label, words, **options):
    """One line with these words, status 2, no files."""
    run = test.run(example("cantilever"), status=2, **{**BEAM, **options})
    test.check(f"{label}.line", words in run.errors and run.errors.count("\n") == 1, 1, 1)
    test.check(f"{label}.files", len(run.files), 0, 0)
    if words not in run.errors:
        print(run.errors)


with Test() as test:
    place = test.folder()
    truth = test.run(example("cantilever"), **BEAM).results
    table = {name: truth.column(name) for name in COLUMNS}
    write(place / "data.csv", table)
    data = blocks(place, "ux", "uy")
    both = {**data, **parameters(E=YOUNG, nu=POISSON)}

    # two numbers come back, on any ranks, by each method; the results are those of the scene itself
    for ranks in (1, 3):
        run, found = analyse(test, ranks, **both)
        test.near(f"ranks={ranks}.E", found["values"][0], E, relative=1e-6)
        test.near(f"ranks={ranks}.nu", found["values"][1], NU, relative=1e-6)
        test.check(f"ranks={ranks}.iterations", found["iterations"], 1, 8)
        test.near(f"ranks={ranks}.results", run.results.column("track_tip_uy")[-1], table["track_tip_uy"][-1], relative=1e-6)
    trace = read(f"{run.prefix}_inverse.csv")
    test.check("trace.columns", list(trace) == ["iteration", "objective", "E", "nu", "evaluations", "start"], 1, 1)
    test.check("trace.descends", np.diff(trace["objective"]).max(), None, 0.0)
    _, found = analyse(test, **data, **parameters(E=YOUNG), mpm_inverse_method="blmvm")
    test.near("blmvm.E", found["values"][0], E, relative=1e-6)
    rate = 1e-3**2 / (table["track_tip_ux"]**2 + table["track_tip_uy"]**2).sum()
    run, found = analyse(test, **data, **parameters(E={**YOUNG, "start": 12.5e6}), mpm_inverse_method="descent",
                         mpm_inverse_rate=rate, mpm_inverse_iterations=3)
    path = read(f"{run.prefix}_inverse.csv")
    test.check("descent.objective", path["objective"][-1] / path["objective"][0], None, 0.9)

    # a bad start: runs that the law refuses or that give up cost a step each
    wild = {**data, **parameters(E={"of": "beam.E", "start": 60e6})}
    run, found = analyse(test, **wild)
    test.near("wild.E", found["values"][0], E, relative=1e-6)
    test.check("wild.evaluations", found["evaluations"], found["iterations"] + 2)
    wild |= {"mpm_parameter_E_bounds": "1e5,1e9", "mpm_time_step_min": 0.25}
    run, found = analyse(test, **wild)
    test.near("gives_up.E", found["values"][0], E, relative=1e-6)
    test.check("gives_up.evaluations", found["evaluations"], found["iterations"] + 2)

    # stiffness and load are not told apart by displacements, but their ratio is; a prior tells them
    pair = {"E": YOUNG, "load": {"of": "tip.factor", "start": 1.1}}
    run, found = analyse(test, **data, **parameters(**pair))
    test.check("pair.not_told_apart", found["not_told_apart"] == [["E", "load"]], 1, 1)
    test.check("pair.singular", found["singular_values"][1] / found["singular_values"][0], None, 1e-8)
    test.near("pair.ratio", found["values"][0] / found["values"][1], E, relative=1e-6)
    test.check("pair.bounds", found["lower"][0] is None or found["lower"][0] == 0.0, 1, 1)
    pair["load"] |= {"prior": 1.0, "deviation": 0.05}
    run, found = analyse(test, **data, **parameters(**pair))
    test.near("prior.E", found["values"][0], E, relative=1e-6)
    test.near("prior.load", found["values"][1], 1.0, relative=1e-6)

    # settlements tell how fast water flows, but not why: the permeability or its viscosity
    wet = {"scene": WET, "mpm_time_scheme": "second", "mpm_time_step": 40, "snes_rtol": 1e-12, "mpm_output_every": 0}
    settled = test.run(**wet, mpm_quiet=None).results
    write(place / "wet.csv", {"time": settled.column("time"), "track_edge_uy": settled.column("track_edge_uy")})
    asked = {"mpm_task": "inverse", "mpm_objectives": "uy", "mpm_objective_uy_column": "track_edge_uy",
             "mpm_objective_uy_data": str(place / "wet.csv"),
             "mpm_objective_uy_deviation": 1e-5, "mpm_quiet": None}
    water = {name: {"of": of, "transform": "log", "start": start} for name, of, start in
             (("E", "clay.E", 1.3e6), ("k", "clay.permeability", 2e-12), ("viscosity", "water.viscosity", 1.2e-3))}
    run, found = analyse(test, **wet, **asked, **parameters(**water))
    test.check("water.not_told_apart", found["not_told_apart"] == [["k", "viscosity"]], 1, 1)
    test.check("water.singular", found["singular_values"][2] / found["singular_values"][0], None, 1e-8)
    test.near("water.E", found["values"][0], 1e6, relative=1e-6)
    test.near("water.ratio", found["values"][1] / found["values"][2], 1e-9, relative=1e-6)

    # noise: the Jacobian by differences, statistics by numpy from the files
    noise = np.random.default_rng(5)
    noisy = {**table, **{name: table[name] + 0.01 * noise.standard_normal(len(table[name])) for name in COLUMNS[1:]}}
    write(place / "data.csv", noisy)
    last = {"mpm_predictions": "last", "mpm_prediction_last_column": "track_tip_uy"}
    run, found = analyse(test, **{**both, **last})
    jacobian, residuals = (read(f"{run.prefix}_{name}.csv") for name in ("jacobian", "residuals"))
    values = np.array(found["values"])
    slopes = np.stack([jacobian["E"], jacobian["nu"]], axis=1)
    ends = [analyse(test, **{**both, "mpm_parameter_E_start": repr(values[0] * (1 + step)), "mpm_parameter_nu_start": repr(values[1]),
                             "mpm_inverse_iterations": 0})[0] for step in (-1e-6, 1e-6)]
    low, high = (read(f"{end.prefix}_residuals.csv")["computed"] for end in ends)
    test.near("jacobian.E", np.abs((high - low) / (2e-6 * values[0]) / slopes[:, 0] - 1.0).max(), 0.0, absolute=1e-6)
    scaled = slopes / residuals["deviation"][:, None] * (values[0], values[1] * (0.45 - values[1]) / 0.45)
    count, size = scaled.shape
    variance = (residuals["residual"]**2).sum() / (count - size)
    covariance = variance * np.linalg.inv(scaled.T @ scaled)
    test.near("variance", found["variance"], variance, relative=1e-9)
    test.near("covariance", np.abs(np.array(found["covariance"]) / covariance - 1.0).max(), 0.0, absolute=1e-8)
    width = 2.4469118511449692 * np.sqrt(np.diag(covariance))  # Student's t, 6 degrees of freedom, 97.5 %
    test.near("lower.E", found["lower"][0], values[0] * np.exp(-width[0]), relative=1e-8)
    test.near("upper.E", found["upper"][0], values[0] * np.exp(width[0]), relative=1e-8)
    singular = np.linalg.svd(slopes / residuals["deviation"][:, None] * values, compute_uv=False)
    test.near("singular", np.abs(np.array(found["singular_values"]) / singular - 1.0).max(), 0.0, absolute=1e-8)
    test.near("sensitivity", found["sensitivities"][0], np.sqrt(((slopes[:, 0] * values[0] / 1e-3)**2).mean()), relative=1e-9)
    row = scaled[-1] * residuals["deviation"][-1]  # the last reading is that of the prediction
    test.near("prediction", found["predictions"]["last"]["deviation"], np.sqrt(row @ covariance @ row), relative=1e-8)
    test.near("gradient", np.abs(scaled.T @ residuals["residual"]).max(), 0.0, absolute=1e-3)

    # an analysis that was interrupted goes on from its last row
    prefix = {"mpm_output_prefix": str(place / "again")}
    analyse_first, _ = analyse(test, **both, **prefix, mpm_inverse_iterations=2)
    rows = read(place / "again_inverse.csv")
    _ = analyse(test, **both, **prefix, mpm_inverse_restart="true")
    again = read(place / "again_inverse.csv")
    test.check("restart.rows", all(np.array_equal(again[name][:3], rows[name]) for name in rows), 1, 1)
    test.check("restart.iteration", list(again["iteration"]) == list(range(len(again["iteration"]))), 1, 1)
    test.near("restart.E", again["E"][-1], found["values"][0], relative=1e-6)

    # a column over another one, several starts, one number for two laws
    write(place / "data.csv", {"track_tip_uy": table["track_tip_uy"], "track_tip_ux": table["track_tip_ux"]})
    shape = {**blocks(place, "ux"), "mpm_objective_ux_over": "track_tip_uy"}
    inner = {"track_tip_uy": np.array([-2.0, -4.0, -6.0]), "track_tip_ux": np.array([-0.5, -1.5, -2.5])}
    write(place / "data.csv", inner)
    _, at = analyse(test, **shape, **parameters(E=YOUNG), mpm_inverse_iterations=0)
    moved = [analyse(test, **shape, **parameters(E={**YOUNG, "start": repr(8e6 * (1 + step))}), mpm_inverse_iterations=0)[0]
             for step in (0.0, -1e-5, 1e-5)]
    computed = [read(f"{run.prefix}_residuals.csv")["computed"] for run in moved]
    slope = read(f"{moved[0].prefix}_jacobian.csv")["E"]
    test.near("over", np.abs((computed[2] - computed[1]) / (2e-5 * 8e6) / slope - 1.0).max(), 0.0, absolute=1e-5)
    write(place / "data.csv", table)
    _, found = analyse(test, **data, **parameters(E={**YOUNG, "bounds": "6e6,40e6"}), mpm_inverse_starts=2)
    test.near("starts.E", found["values"][0], E, relative=1e-6)

    # scipy's least squares ends at the parameters of the program's own analysis
    os.environ["TALUS"] = str(test.program)
    sys.path.insert(0, str(ROOT / "python" / "src"))
    import talus
    from scipy.optimize import least_squares
    asked = ({"E": YOUNG, "nu": {**POISSON, "prior": NU, "deviation": 0.5}},
             {name: {"column": f"track_tip_{name}", "data": pd.DataFrame(table), "deviation": 1e-2} for name in ("ux", "uy")})
    scene = talus.Scene(example("cantilever")).changed(**{name.removeprefix("mpm_"): value for name, value in BEAM.items()
                                                          if name.startswith("mpm_") and value is not None}, **{"-snes_rtol": 1e-12})
    found = talus.invert(scene, *asked, tolerance=1e-11)
    fit = talus.Residuals(scene, *asked)
    other = least_squares(fit.residual, fit.start, jac=fit.jacobian, x_scale="jac", xtol=1e-12, ftol=1e-15, gtol=1e-15)
    test.near("python", np.abs(fit.values(other.x) / found.table["value"] - 1.0).max(), 0.0, absolute=1e-8)
    test.check("python.intervals", (found.table["lower"] <= found.table["value"]).all(), 1, 1)

    for method in ("gauss_newton", "blmvm"):
        run = test.run(example("inverse_footing"), mpm_inverse_method=method, mpm_quiet=None)
        test.check_example(f"footing.{method}", run, "inverse_footing")

    refuse(test, "start", "outside of its bounds", **data, **parameters(E={**YOUNG, "start": 1e10}))
    refuse(test, "bounds", "bounds is missing", **data, **parameters(nu={"of": "beam.nu", "transform": "logit"}))
    refuse(test, "log", "no logarithm", **data, **parameters(nu={"of": "beam.nu", "transform": "log", "start": 0}))
    refuse(test, "prior", "deviation is missing", **data, **parameters(E={**YOUNG, "prior": 1e7}))
    refuse(test, "rate", "rate is missing", **data, **parameters(E=YOUNG), mpm_inverse_method="descent")
    refuse(test, "starts", "bounds is missing", **data, **parameters(E={"of": "beam.E"}), mpm_inverse_starts=2)
    refuse(test, "groups", "must be 1", **data, **parameters(E=YOUNG), mpm_inverse_groups=2)
    refuse(test, "value", "fits data", **{**data, "mpm_objective_ux_kind": "value"}, **parameters(E=YOUNG))
    refuse(test, "column", "the nearest is track_tip_ux", **data, **parameters(E=YOUNG),
           mpm_predictions="last", mpm_prediction_last_column="track_tip_u")
    for label, words, bad in (("outside", "outside of the run", {**table, "time": 3.0 * table["time"]}),
                              ("order", "must ascend", {**table, "time": table["time"][::-1]}),
                              ("finite", "of row 1 is not a finite number", {**table, "track_tip_ux": np.nan * table["time"]}),
                              ("missing", "has no column track_tip_ux; there are", {name: table[name] for name in COLUMNS[::2]}
                               | {"third": table["time"]})):
        write(place / "data.csv", bad)
        refuse(test, label, words, **data, **parameters(E=YOUNG))
