#!/usr/bin/env python3
"""Derivatives of laboratory tests: each law by each of its numbers, on each path, against differences and known values.

Known values are differences of whole runs, extrapolated to a change of zero. The program's own check compares the tangent,
the adjoint and differences; it ends with status 3 where they do not agree. A law or a number of one that has neither a
scene here nor a refusal fails the test.

Quick.
"""
import json
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import ROOT, Test, call, example  # noqa: E402

PRESSED = "-100e3,-100e3,-100e3,0,0,0"
# a law, its parameters, and what its scenes have besides: stress at the start, how far paths go
ELASTIC = {"density": 2000, "E": 20e6, "nu": 0.3}
CLAY = {"density": 2000, "kappa": 0.02, "lambda": 0.1, "M": 1.2, "G": 4e6, "specific_volume": 2.1, "reference_pressure": 90e3,
        "pressure_min": 2e3}
SAND = {"density": 2000, "kappa": 0.003, "G": 30e6, "M": 1.25, "N": 0.3, "beta": 0.9, "lambda": 0.03, "v_c0": 1.9, "h": 80,
        "specific_volume": 1.72, "reference_pressure": 90e3}
FLUID = {"density": 1000, "gamma": 6.5, "viscosity": 2e3, "pressure_min": -1e9}
LAWS = [
    ("linear_elastic", ELASTIC, PRESSED), ("hencky", ELASTIC, PRESSED), ("neo_hookean", ELASTIC, PRESSED),
    ("jaumann_elastic", {**ELASTIC, "cohesion": 20e3, "friction": 30, "dilation": 5, "tension": 10e3}, PRESSED),
    ("jaumann_elastic", {**ELASTIC, "cohesion": 20e3, "friction": 30, "tension": 10e3, "closing": 0.5}, PRESSED),
    ("j2", {**ELASTIC, "yield_stress": 90e3, "hardening": 500e3}, PRESSED),
    ("drucker_prager", {**ELASTIC, "cohesion": 20e3, "friction": 28, "dilation": 6}, PRESSED),
    ("mohr_coulomb", {**ELASTIC, "cohesion": 20e3, "friction": 28, "dilation": 6, "tension": 15e3, "cohesion_residual": 15e3,
                      "friction_residual": 24, "dilation_residual": 2, "softening_strain": 0.2}, PRESSED),
    ("mohr_coulomb", {**ELASTIC, "cohesion": 20e3, "friction": 28, "dilation": 6, "softening_strain": 0.2}, PRESSED),
    ("modified_cam_clay", {**CLAY, "ocr": 1.5}, PRESSED), ("modified_cam_clay", {**CLAY, "pop": 40e3}, PRESSED),
    ("modified_cam_clay", {**CLAY, "preconsolidation": 150e3}, PRESSED),
    ("nor_sand", {**SAND, "image_pressure": 80e3}, PRESSED), ("nor_sand", {**SAND, "preconsolidation": 180e3}, PRESSED),
    ("nor_sand", {**SAND, "ocr": 1.5}, PRESSED), ("nor_sand", {**SAND, "pop": 60e3}, PRESSED),
    ("nacc", {**ELASTIC, "M": 2.0, "beta": 0.5, "xi": 30, "alpha_0": -2e-3}, "0,0,0,0,0,0"),
    ("newtonian", {**FLUID, "sound_speed": 30}, PRESSED), ("newtonian", {**FLUID, "bulk_modulus": 1e6}, PRESSED),
    ("ogden", {"density": 1000, "terms": "1.5:0.5e6,4:0.1e6", "bulk_modulus": 5e6}, PRESSED),
    ("ogden", {"density": 1000, "terms": "1.5:0.5e6,4:0.1e6", "nu": 0.4}, PRESSED),
]
PATHS = {3: ("triaxial_drained", "triaxial_undrained", "simple_shear"), 2: ("biaxial_drained", "oedometer")}
MEASURES = {"triaxial_drained": ("kirchhoff", "log"), "triaxial_undrained": ("cauchy", "engineering"),
            "simple_shear": ("kirchhoff", "engineering"), "biaxial_drained": ("cauchy", "engineering"),
            "oedometer": ("cauchy", "log")}
CARRIED = {"linear_elastic", "hencky", "neo_hookean", "ogden"}  # stress by deformation, which in plane strain decides zz
NO_STRENGTH = {"newtonian"}  # without a shear stress at rest: no path with a prescribed stress
KNOWN = [  # by Richardson's extrapolation of differences of runs; `steps` of the scene
    ("clay_undrained", "q", None, {"clay.kappa": 475946.72578, "clay.M": 57460.369082}, 1e-9),
    ("nor_sand_triaxial", "q", 100, {"loose.M": 912075.0846, "loose.h": -146.80419}, 1e-7),
    ("nor_sand_triaxial", "eps_v", 100, {"loose.M": -0.0217896335146, "loose.h": 1.2968046565e-4}, 3e-9),
]


def scene(law, parameters, stress, dim, path):
    """Options of a test of 12 steps on one material."""
    numbers = stress.split(",") if dim == 3 else ["0"] * 4 if law in CARRIED else stress.split(",")[:4]
    return {"mpm_dim": dim, "mpm_physics": "stress_point", "mpm_materials": "m", "mpm_material_m_type": law,
            **{"mpm_material_m_" + name: value for name, value in parameters.items()}, "mpm_point_material": "m",
            "mpm_point_stress": ",".join(numbers), "mpm_point_path": path, "mpm_point_steps": 12,
            "mpm_point_measure": MEASURES[path][0], "mpm_point_strain": MEASURES[path][1],
            "mpm_point_end": 0.03 if path == "simple_shear" else -0.03, "snes_rtol": 1e-14}


def sought(columns):
    """Half the squares of columns over a deviation each."""
    ask = {"mpm_objectives": ",".join(columns)}
    for name, deviation in columns.items():
        block = f"mpm_objective_{name}_"
        ask |= {block + "column": name, block + "target": 0, block + "deviation": deviation}
    return ask


def differentiate(test, name, column, parameters, method, ranks=1, **options):
    run = test.run(example(name), ranks=ranks, mpm_task="gradient", mpm_gradient_parameters=",".join(parameters),
                   mpm_gradient_method=method, mpm_objectives="u", mpm_objective_u_column=column, mpm_objective_u_kind="value",
                   mpm_quiet=None, **options)
    return np.array(run.results.summary["gradient"])


def refuse(test, label, words, **options):
    """A task that is not possible: one line with these words, status 2, no files."""
    ask = {"mpm_task": "gradient", "mpm_gradient_parameters": "clay.M", "mpm_objectives": "u", "mpm_objective_u_column": "q",
           "mpm_objective_u_kind": "value"}
    run = test.run(example("clay_undrained"), status=2, **{**ask, **options})
    test.check(f"{label}.line", words in run.errors and run.errors.count("\n") == 1, 1, 1)
    test.check(f"{label}.files", len(run.files), 0, 0)


def numbers_of_laws(test):
    """The numbers that each law has, by the manual."""
    found = {}
    for option in json.loads(call([test.program, "-help=json"], test.folder()).stdout):
        if option["section"].startswith("Material of type") and option["type"] == "number":
            law, number = option["section"].split()[3].rstrip(":"), option["option"].removeprefix("mpm_material_NAME_")
            if not (ROOT / "basal" / f"{law}.c").exists():  # laws of a bed have no stress
                found.setdefault(law, set()).add(number)
    return found


with Test() as test:
    for name, column, steps, values, reach in KNOWN:
        options = {"mpm_point_steps": steps} if steps else {}
        adjoint = differentiate(test, name, column, values, "adjoint", **options)
        tangent = differentiate(test, name, column, values, "tangent", ranks=3, **options)
        test.near(f"{name}.{column}.methods", np.abs(tangent / adjoint - 1.0).max(), 0.0, absolute=1e-12)
        for parameter, value, known in zip(values, adjoint, values.values()):
            test.near(f"{name}.{column}.{parameter}", value, known, relative=reach)

    # every number of every law on every path, by the program's own check
    missing = numbers_of_laws(test)
    empty = test.folder() / "empty.yaml"
    empty.write_text("mpm: {}\n", encoding="utf-8")
    for law, parameters, stress in LAWS:
        numbers = [name for name, value in parameters.items() if not isinstance(value, str)]
        for dim, paths in PATHS.items():
            for path in paths:
                if law in NO_STRENGTH and path.endswith("_drained"):
                    continue
                ask = {"mpm_task": "check_gradient", "mpm_gradient_parameters": ",".join("m." + name for name in numbers),
                       **sought({"q": 1e4, "p": 1e4, "eps_v": 1e-3})}
                run = test.run(empty, status=None, **scene(law, parameters, stress, dim, path), **ask)
                lines = sum("apart; differences" in line for line in run.output.splitlines())
                label = f"{law}.{numbers[-1]}.{dim}D.{path}"
                test.check(label, run.status, 0, 0)
                test.check(label + ".lines", lines, len(numbers), len(numbers))
                if run.status:
                    print(run.errors)
        missing[law] -= set(numbers)
    for law, names in missing.items():
        test.check(f"{law}.numbers", len(names), 0, 0)

    # two tests of one material at one time have the sum of their derivatives, and one of another material adds none
    both = {"mpm_task": "gradient", "mpm_gradient_parameters": "clay.M,clay.kappa", "mpm_objectives": "u", "mpm_quiet": None,
            "mpm_objective_u_kind": "value", "mpm_dim": 3, "mpm_physics": "stress_point", "mpm_materials": "clay,sand",
            **{"mpm_material_clay_" + name: value for name, value in {"type": "modified_cam_clay", **CLAY, "ocr": 1.5}.items()},
            **{"mpm_material_sand_" + name: value for name, value in {"type": "nor_sand", **SAND, "ocr": 1.5}.items()}}
    kinds = {"low": ("clay", "triaxial_drained", "-50e3,-50e3,-50e3,0,0,0"), "high": ("clay", "triaxial_undrained", PRESSED),
             "third": ("sand", "triaxial_drained", PRESSED)}
    words = ("material", "path", "stress")
    side = {f"mpm_test_{name}_{word}": value for name, kind in kinds.items() for word, value in zip(words, kind)}
    side |= {f"mpm_test_{name}_{word}": value for name in kinds for word, value in (("end", -0.05), ("steps", 20))}
    for name in ("low", "high"):
        one = {"mpm_point_" + word: value for word, value in zip(words, kinds[name])}
        alone = test.run(empty, **both, **one, mpm_point_end=-0.05, mpm_point_steps=20, mpm_objective_u_column="q").results.summary
        for method, ranks in (("adjoint", 1), ("tangent", 3)):
            run = test.run(empty, ranks=ranks, **both, **side, mpm_tests=",".join(kinds), mpm_gradient_method=method,
                           mpm_objective_u_column=name + "_q").results.summary
            test.near(f"tests.{name}.{method}.objective", run["objective"], alone["objective"], relative=1e-12)
            apart = np.abs(np.array(run["gradient"]) / alone["gradient"] - 1.0).max()
            test.near(f"tests.{name}.{method}.gradient", apart, 0.0, absolute=1e-10)
    run = test.run(empty, status=2, **both, **side, mpm_tests="low,high", mpm_point_path="oedometer", mpm_objective_u_column="q")
    test.check("tests.point", "the scene has the block point, too" in run.errors, 1, 1)

    # parameters of three tests at one time, found from their curves
    folder = example("calibrate_triaxial").parent
    data = {f"mpm_objective_{name}_{of}_data": folder / f"{name}.csv" for name in ("low", "middle", "high") for of in "qv"}
    run = test.run(example("calibrate_triaxial"), mpm_quiet=None, **data)
    test.check_example("calibrate", run, "calibrate_triaxial")

    refuse(test, "key", "clay has no number Q", mpm_gradient_parameters="clay.Q")
    refuse(test, "option", "no derivative of a laboratory test by it yet", mpm_gradient_parameters="point.end")
    refuse(test, "twins", "must be adjoint or tangent", mpm_gradient_method="twins")
    refuse(test, "absent", "the scene does not give it", mpm_gradient_parameters="clay.pop")
    refuse(test, "block", "no block has this name", mpm_gradient_parameters="sand.M")
    refuse(test, "column", "no derivative of this column", mpm_objective_u_column="newton")
    refuse(test, "memory", "is too little", mpm_gradient_memory=100)
