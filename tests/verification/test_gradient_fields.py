#!/usr/bin/env python3
"""Derivatives by fields: of a uniform field they add up to that by the uniform number, whatever the field is by; adjoint, tangent and
differences of changed runs agree value by value and along a random direction, on one rank and three; parts without derivatives are
refused by name.

Quick.
"""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import Test  # noqa: E402

SCENE = Path(__file__).resolve().parent / "fields.yaml"
LOW, HIGH = 4e6, 1e6
EXACT = {"mpm_quiet": None, "snes_rtol": 1e-13, "snes_stol": 0, "mpm_stabilization_ghost": "off", "mpm_output_every": 0}
PLACES = [(x + 0.5, y + 0.5) for y in range(4) for x in range(4) if y < 2 or x < 2]
PILOTS = [(0.3, 0.2), (3.7, 0.4), (1.9, 1.8), (0.4, 3.5)]


def write(folder, name, places, values):
    path = folder / name
    rows = [f"{x},{y},{value:.17g}" for (x, y), value in zip(places, values)]
    path.write_text("\n".join(["x,y,value"] + rows) + "\n", encoding="utf-8")
    return path


def differentiate(test, parameters, method="adjoint", ranks=1, status=0, **options):
    """The run, its objective, and its derivatives by numbers."""
    run = test.run(SCENE, ranks=ranks, status=status, mpm_task="gradient", mpm_gradient_parameters=parameters,
                   mpm_gradient_method=method, mpm_objectives="u", mpm_objective_u_column="track_top_uy",
                   mpm_objective_u_kind="value", **EXACT, **options)
    if status:
        return run, None, None
    return run, run.results.summary["objective"], np.array(run.results.summary["gradient"])


def by_field(run, name="stiff"):
    """Values and derivatives of a field's file, which the summary names."""
    entry = run.results.summary["gradient_fields"][name]
    path = run.folder / entry["file"]
    rows = [line.split(",") for line in path.read_text(encoding="utf-8").splitlines()[1:]]
    values, derivatives = (np.array([float(row[k]) for row in rows]) for k in (-2, -1))
    assert entry["values"] == len(values) and abs(entry["norm"] / np.linalg.norm(derivatives) - 1.0) < 1e-12
    return values, derivatives


def field(**options):
    return {"mpm_field_stiff_" + name: value for name, value in options.items()}


def uniform(test, folder):
    """Derivatives by a uniform field of any kind add up to that by the number."""
    count = {"cell": 12, "point": 48, "pilots": 4}
    for number, value, law in (("E", 1e6, {}), ("density", 1800.0, {"mpm_material_soil_E": 1e6}),
                               ("yield_stress", 20e3, {"mpm_material_soil_E": 1e6, "mpm_material_soil_type": "j2"})):
        scalar = {**law, "mpm_material_soil_" + number: repr(value)}
        _, objective, gradient = differentiate(test, "soil." + number, mpm_fields="", **scalar)
        for kind in ("body", "region", "cell", "point", "pilots"):
            options = {"of": "soil." + number, "by": kind}
            if kind == "body":
                options |= {"bodies": "low,high", "values": f"{value},{value}"}
            elif kind == "region":
                options |= {"regions": "foot,rest", "values": f"{value},{value}", "foot_region": "box", "foot_lower": "0,0",
                            "foot_upper": "4,2", "rest_region": "all"}
            else:
                places = PILOTS if kind == "pilots" else PLACES
                options |= {"file": write(folder, f"{number}_{kind}.csv", (places * 4)[:count[kind]], [value] * count[kind])}
                options |= {"length": "1.5,0.8"} if kind == "pilots" else {}
            run, same, _ = differentiate(test, "field_stiff", **law, **field(**options))
            test.near(f"uniform.{number}.{kind}.objective", same, objective, relative=1e-10)
            test.near(f"uniform.{number}.{kind}", by_field(run)[1].sum(), gradient[0], relative=1e-8)


def varying(test, folder):
    """Methods, ranks and differences agree where the field and other numbers of its material are parameters at once."""
    rng = np.random.default_rng(3)
    penalty = {"mpm_stabilization_interior": 0.05}  # of the largest value
    for label, kind, places, log, more in (("cell", "cell", PLACES, {}, {}), ("penalty", "cell", PLACES, {}, penalty),
                                           ("pilots", "pilots", PILOTS, {"length": 2}, {}),
                                           ("pilots.plain", "pilots", PILOTS, {"length": 2, "log": "false"}, {})):
        values = 1e6 * np.exp(rng.uniform(0.0, 1.0, len(places)))
        options = {**field(by=kind, file=write(folder, label + ".csv", places, values), **log), **more}
        run, _, gradient = differentiate(test, "soil.nu,field_stiff,weight.factor", **options)
        test.check(f"{label}.names", run.results.summary["parameters"] == ["soil.nu", "weight.factor"], 1, 1)
        stored, derivatives = by_field(run)
        test.check(f"{label}.values", np.abs(stored - values).max(), None, 0.0)
        test.near(f"{label}.scaling", stored @ derivatives, -gradient[1], relative=1e-8)
        for method, ranks in (("tangent", 1), ("adjoint", 3)):
            other, _, scalars = differentiate(test, "soil.nu,field_stiff,weight.factor", method, ranks, **options)
            away = np.abs(by_field(other)[1] - derivatives).max() / np.abs(derivatives).max()
            test.check(f"{label}.{method}.ranks={ranks}", away, None, 1e-8)
            test.near(f"{label}.{method}.ranks={ranks}.nu", scalars[0], gradient[0], relative=1e-8)
        if label == "penalty":  # the program's own check: both methods, and differences along random directions
            check = {**EXACT, **options, "mpm_quiet": "false", "mpm_task": "check_gradient", "mpm_gradient_parameters": "field_stiff",
                     "mpm_objectives": "u", "mpm_objective_u_column": "track_top_uy", "mpm_objective_u_kind": "value"}
            lines = [line for line in test.run(SCENE, **check).output.splitlines() if "along random signs" in line]
            test.check("check.directions", len(lines), 3, 3)
            value, apart = (float(lines[0].split(word)[1].split()[0].strip(",")) for word in ("adjoint", "differences"))
            test.near("check.differences", apart, value, relative=1e-6)
        change = values * rng.choice((-1.0, 1.0), len(values))
        ends = []
        for step in (-1e-5, 1e-5):
            text = ",".join(f"{value:.17g}" for value in values + step * change)
            ends.append(differentiate(test, "soil.nu", **options, mpm_field_stiff_values=text)[1])
        test.near(f"{label}.differences", derivatives @ change, (ends[1] - ends[0]) / 2e-5, relative=1e-6)


def refusals(test, folder):
    options = field(by="cell", file=write(folder, "refused.csv", PLACES, [1e6] * len(PLACES)))
    for label, words, parameters, more in (
            ("name", "no field soft", "field_soft", {}),
            ("stages", "more than one stage", "field_stiff", {"mpm_stages": "a,b"}),
            ("divide", "division of points", "field_stiff", {"mpm_stabilization_divide": 1.5})):
        run, _, _ = differentiate(test, parameters, status=2, **options, **more)
        test.check(f"{label}.line", words in run.errors and run.errors.count("\n") == 1, 1, 1)
        if words not in run.errors:
            print(run.errors)
        test.check(f"{label}.files", len(run.files), 0, 0)


with Test() as test:
    place = test.folder()
    uniform(test, place)
    varying(test, place)
    refusals(test, place)
