#!/usr/bin/env python3
"""Modified Cam-Clay in the laboratory: the undrained path, exact in steps of any length, its strains and a drained test at first
order, over-consolidated clay, the initial state, and parameters that are refused.
"""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import Test, example  # noqa: E402

KAPPA, LAMBDA, M, START = 0.02, 0.1, 1.2, 100e3
# From the closed form, and for the drained test from the rate equations integrated to 1e-9
UNDRAINED = {0.01: 58.51635e3, 0.02: 65.95305e3, 0.05: 68.70557e3}
DRAINED_Q, DRAINED_VOLUME = 85.45272e3, -0.04649323


def follow(test, status=0, material=(), **options):
    """The history of the example with other options of the point and of the material."""
    options = {"mpm_point_" + name: value for name, value in options.items()}
    options.update({"mpm_material_clay_" + name: value for name, value in dict(material).items()})
    run = test.run(example("clay_undrained"), status=status, **options)
    return run if status else run.results.history


def first_order(test, label, errors):
    """Errors in steps halved each time."""
    for k in range(len(errors) - 1):
        test.check(f"{label}.order_{k}", np.log2(errors[k] / errors[k + 1]), 0.9, 1.1)


def check_undrained(test):
    errors = {strain: [] for strain in UNDRAINED}
    for steps in (10, 100, 200, 400, 1000):
        history = follow(test, steps=steps)
        p, q = -history["p"], history["q"]
        path = START * (M**2 / (M**2 + (q / p) ** 2)) ** (1 - KAPPA / LAMBDA)
        test.check(f"undrained.{steps}.path", np.abs(p / path - 1).max(), None, 1e-10)
        test.check(f"undrained.{steps}.volume", np.abs(history["eps_v"]).max(), None, 1e-14)
        for strain in UNDRAINED:
            if steps in (100, 200, 400):
                row = np.argmin(np.abs(history["eps_q"] - strain))
                errors[strain].append(abs(history["q"][row] / UNDRAINED[strain] - 1))
    for strain, error in errors.items():
        test.check(f"undrained.{strain}.q", error[1], 1e-6, 8e-3 if strain < 0.02 else 3e-3)
        if strain < 0.05:  # there the path is at its end already
            first_order(test, f"undrained.{strain}", error)
    test.check_example("clay_undrained", test.run(example("clay_undrained"), mpm_quiet=None), "clay_undrained")


def check_drained(test):
    errors = {"q": [], "eps_v": []}
    for steps in (100, 200, 400, 800):
        history = follow(test, path="triaxial_drained", end=-0.05, steps=steps)
        for name, expected in (("q", DRAINED_Q), ("eps_v", DRAINED_VOLUME)):
            errors[name].append(abs(history[name][-1] / expected - 1))
        test.check(f"drained.{steps}.newton", history["newton"].max(), 1, 5)
    for name, error in errors.items():
        test.check(f"drained.{name}", error[1], 1e-6, 3e-3)
        first_order(test, f"drained.{name}", error)


def check_critical(test):
    """From both sides of critical state: q = M p, p_c = 2 p; over-consolidated clay softens on its way."""
    for ocr in (1, 8):
        history = follow(test, 0, {"ocr": ocr}, path="triaxial_drained", end=-0.8, steps=400)
        test.near(f"critical.{ocr}.ratio", history["q"][-1] / -history["p"][-1], M, 1e-3)
        test.near(f"critical.{ocr}.size", history["preconsolidation"][-1] / -history["p"][-1], 2, 3e-3)
        test.near(f"critical.{ocr}.q", history["q"][-1], 3 * M / (3 - M) * START, 2e-3)
        peak = history["q"].max() / history["q"][-1]
        test.check(f"critical.{ocr}.peak", peak, *((None, 1.001) if ocr == 1 else (1.2, None)))


def check_isotropic(test):
    """Both lines over ln p, in few steps; history from a stress on the yield surface and within it."""
    history = follow(test, path="isotropic", end=400e3, steps=4)
    test.check("isotropic.virgin", np.abs(history["eps_v"] + LAMBDA * np.log(-history["p"] / START)).max(), None, 1e-12)
    test.check("isotropic.size", np.abs(history["preconsolidation"] / -history["p"] - 1).max(), None, 1e-12)
    test.near("isotropic.volume", history["specific_volume"][-1], 2.1 * 4**-LAMBDA, 1e-12)
    history = follow(test, material={"ocr": 2}, path="isotropic", end=400e3, steps=4)
    bends = KAPPA * np.log(2) + LAMBDA * np.log(2)
    test.near("isotropic.over_consolidated", history["eps_v"][-1], -bends, 1e-12)
    given = follow(test, material={"preconsolidation": 200e3}, path="isotropic", end=400e3, steps=4)
    test.near("isotropic.preconsolidation", given["eps_v"][-1], -bends, 1e-12)
    start = "-80e3,-200e3,-90e3,0,0,0"
    p, square = 370e3 / 3, (120e3**2 + 110e3**2 + 10e3**2) / 2
    first = follow(test, stress=start, end=-1e-9, steps=1)
    test.near("start.size", first["preconsolidation"][0], p + square / (M**2 * p), 1e-6)


def check_refused(test):
    bad = (("kappa_is_lambda", {"kappa": 0.1}, {}, "-mpm_material_clay_kappa 0.1: must lie in (0, 0.1)"),
           ("ocr", {"ocr": 0.9}, {}, "-mpm_material_clay_ocr 0.9: must be >= 1"),
           ("both", {"ocr": 1.5, "preconsolidation": 2e5}, {}, "-mpm_material_clay_ocr 1.5: preconsolidation is given, too"),
           ("no_pressure", {"reference_pressure": 0}, {}, "-mpm_material_clay_reference_pressure 0: must be > 0"),
           ("linear_above_reference", {"pressure_min": 2e5}, {}, "-mpm_material_clay_pressure_min 200000: must lie in"),
           ("E", {"E": 1e6}, {}, "-mpm_material_clay_E"),
           ("no_stress", {}, {"stress": "0,0,0,0,0,0"}, "-mpm_point_stress: material clay has no state with this stress"))
    for label, material, options, line in bad:
        run = follow(test, 2, material, **options)
        errors = run.errors.strip().splitlines()
        test.check(f"refused.{label}", int(len(errors) == 1 and line in errors[0]), 1, 1)


def main():
    with Test() as test:
        for check in (check_undrained, check_drained, check_critical, check_isotropic, check_refused):
            check(test)


if __name__ == "__main__":
    main()
