#!/usr/bin/env python3
"""The column under its own weight: errors against theory by number of cells, convergence, Newton's iterations."""
import re
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import EXAMPLES, Test, example, read_table  # noqa: E402

HEIGHT = 50.0  # m
NEWTON_TOLERANCE = 1e-11


def run_column(test, name, count, **options):
    """A run with square cells, tight Newton tolerance, and states at the two ends only."""
    return test.run(example(name), mpm_grid_cells=f"1,{count}", mpm_grid_upper=f"{HEIGHT / count},{HEIGHT}", mpm_output_every=40,
                    mpm_quiet=None, snes_rtol=NEWTON_TOLERANCE, **options)


def against_table(test, name, reach, most_newton):
    """Every tabulated number of cells: error within `reach` of the table, Newton's iterations in every step."""
    table = read_table(EXAMPLES / name / "reference.csv")
    for count, error in zip(table["cells"].astype(int), table["error"]):
        label = f"{name}_{count}"
        run = run_column(test, name, count, mpm_stabilization_ghost="off")
        quantities = test.check_example(label, run, name)
        test.near(f"{label}.stress_error_over_table", quantities["stress_error"] / error, 1.0, absolute=reach)
        test.check(f"{label}.newton", run.newton.max(), 1, most_newton)
        test.check(f"{label}.steps", run.newton.size, 40, 40)


def aggregated(test, name, reach):
    """Aggregation of small-cut nodes takes up to 28 % of the error away, and adds no more than rounding of the table's digits;
    the solver does not change it."""
    table = read_table(EXAMPLES / name / "reference.csv")
    for count, error in zip(table["cells"].astype(int), table["error"]):
        if count > 64:
            continue
        for solver in ("direct", "amg"):
            label = f"{name}_{count}_{solver}"
            quantities = test.check_example(label, run_column(test, name, count, mpm_solver=solver), name)
            test.check(f"{label}.stress_error_over_table", quantities["stress_error"] / error, 0.7, 1.0 + reach)


def splines(test):
    """The domain-integrated quadratic B-spline: bounds, and second order until the domains' own error shows."""
    bounds = {32: 1.2e-3, 64: 2.3e-4, 128: 5.5e-5, 256: 2.2e-5}
    errors = {}
    for count, bound in bounds.items():
        label = f"bspline_{count}"
        run = run_column(test, "bar_elastic", count, mpm_shape="gimp_bspline2")
        errors[count] = test.check_example(label, run, "bar_elastic")["stress_error"]
        test.check(f"{label}.stress_error_bound", errors[count], None, bound)
        test.check(f"{label}.newton", run.newton.max(), 1, 4)
    test.check("bspline.order_32_to_128", 0.5 * np.log2(errors[32] / errors[128]), 1.8, None)


def open_edges(test):
    """The same with not-a-knot ends: second order from the coarsest grids on, and errors far below
    those of GIMP, whose steps take as many iterations."""
    gimp = read_table(EXAMPLES / "bar_elastic" / "reference.csv")
    gimp = dict(zip(gimp["cells"].astype(int), gimp["error"]))
    bounds = {8: 2.1e-3, 16: 2.6e-4, 32: 5.7e-5, 64: 1.25e-5}
    errors = {}
    for count, bound in bounds.items():
        label = f"open_{count}"
        run = run_column(test, "bar_elastic", count, mpm_shape="gimp_bspline2", mpm_shape_edge="open",
                         mpm_body_column_points_per_cell="3,3")
        errors[count] = test.check_example(label, run, "bar_elastic")["stress_error"]
        test.check(f"{label}.stress_error_bound", errors[count], None, bound)
        test.check(f"{label}.over_gimp", errors[count] / gimp[count], None, 0.2)
        test.check(f"{label}.newton", run.newton.max(), 1, 4)
    test.check("open.order_8_to_64", np.log2(errors[8] / errors[64]) / 3.0, 2.0, None)


def residual_norms(output):
    """The residual's norms that -snes_monitor printed, a list for every step."""
    steps = []
    for iteration, norm in re.findall(r"^ *(\d+) SNES Function norm (\S+)", output, re.MULTILINE):
        if iteration == "0":
            steps.append([])
        steps[-1].append(float(norm))
    return steps


def newton_rate(test, name, count):
    """The printed residuals: their drop in every step, and quadratic convergence where it shows, between 1e-2 and 1e-12.

    From rest and with a new Jacobian each iteration, so that what is seen is Newton's own rate.
    """
    options = {"mpm_time_predict": "false", "mpm_newton_lag": "false", "snes_monitor": None}
    steps = residual_norms(run_column(test, name, count, **options).output)
    drops, orders = [], []
    for norms in steps:
        relative = np.array(norms) / norms[0]
        drops.append(relative[-1])
        for now, after in zip(relative[:-1], relative[1:]):
            if now < 1e-2 and after > 1e-12:
                orders.append(np.log(after) / np.log(now))
    test.check(f"{name}_{count}.monitored_steps", len(steps), 40, 40)
    test.check(f"{name}_{count}.residual_drop", max(drops), None, NEWTON_TOLERANCE)
    test.check(f"{name}_{count}.newton_order", min(orders), 1.7, None)


with Test() as test:
    against_table(test, "bar_elastic", 0.01, 4)
    against_table(test, "bar_j2", 0.02, 5)
    aggregated(test, "bar_elastic", 0.05)
    splines(test)
    open_edges(test)
    for column in ("bar_elastic", "bar_j2"):
        newton_rate(test, column, 64)
