#!/usr/bin/env python3
"""Compares the parameters that calibrate_triaxial finds with those that made its data; draws curves and data."""
import csv
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
import common  # noqa: E402

FOLDER = Path(__file__).resolve().parent
KNOWN = {"M": 1.25, "N": 0.3, "lambda": 0.025, "v_c0": 1.88, "h": 90.0}  # made the data
TESTS = {"low": 100, "middle": 200, "high": 400}  # and their pressures, kPa
EXACT = 1e-6  # of the parameters, relative
ITERATIONS = 15


def measured(name):
    with open(FOLDER / f"{name}.csv", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    return {column: np.array([float(row[column]) for row in rows]) for column in rows[0]}


def check(results):
    inverse = results.summary["inverse"]
    found = dict(zip((name.split(".")[-1] for name in inverse["parameters"]), inverse["values"]))
    quantities = [common.completed(results), common.Quantity("iterations", inverse["iterations"], upper=ITERATIONS),
                  common.Quantity("converged", inverse["converged"], lower=1, upper=1)]
    quantities += [common.Quantity.near(name, found[name], value, relative=EXACT) for name, value in KNOWN.items()]
    return quantities


def draw(results):
    import matplotlib.pyplot as plt

    history = results.history
    figure, (top, bottom) = plt.subplots(1, 2, figsize=(9.0, 3.8), layout="constrained")
    for k, (name, pressure) in enumerate(TESTS.items()):
        data, style = measured(name), {"linestyle": "", "marker": "o", "markersize": 4, "markerfacecolor": "white"}
        for axes, column, factor in ((top, f"{name}_q", 1e-3), (bottom, f"{name}_eps_v", -100.0)):
            axes.plot(-100 * history[f"strain_{name}_yy"], factor * history[column], color=f"C{k}", label=f"{pressure} kPa")
            axes.plot(-100 * data[f"strain_{name}_yy"], factor * data[column], color=f"C{k}", **style)
    top.set(xlabel="axial strain (%)", ylabel="$q$ (kPa)", ylim=(0.0, None))
    bottom.set(xlabel="axial strain (%)", ylabel="volume lost (%)")
    top.legend(frameon=False, title="fitted; circles: data", title_fontsize="small")
    for axes in (top, bottom):
        axes.grid(alpha=0.3)
        axes.spines[["top", "right"]].set_visible(False)
    return figure


if __name__ == "__main__":
    common.main(check, draw)
