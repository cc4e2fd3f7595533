#!/usr/bin/env python3
"""Compares the stiffness that the analysis found with that of the data, and counts its iterations."""
import sys
from pathlib import Path

import numpy as np

FOLDER = Path(__file__).resolve().parent
sys.path.insert(0, str(FOLDER.parent))
import common  # noqa: E402
from common import Quantity  # noqa: E402

TRUTH = 10e6  # Pa, of the data
NEAR = 1e-6  # relative: found
ITERATIONS = {"gauss_newton": 4, "blmvm": 8}


def iterations(results):
    return common.read_table(f"{results.prefix}_inverse.csv")


def check(results):
    found, table = results.summary["inverse"], iterations(results)
    near = np.abs(table["E"] / TRUTH - 1.0) < NEAR
    quantities = [common.completed(results), Quantity.near("E", found["values"][0], TRUTH, relative=NEAR)]
    if found["method"] in ITERATIONS:
        quantities.append(Quantity("iterations", table["iteration"][np.argmax(near)] if near.any() else np.inf, 1.0,
                                   ITERATIONS[found["method"]]))
    force = results.column("reaction_footing_y")[-1]
    return quantities + [Quantity.near("prediction", found["predictions"]["last"]["value"], force, relative=NEAR)]


def draw(results):
    """The curve of the data and of the run with the stiffness found, and the way to it."""
    import matplotlib.pyplot as plt

    figure, (left, right) = plt.subplots(1, 2, figsize=(10.0, 4.0), layout="constrained")
    data, table = common.read_table(FOLDER / "plate.csv"), iterations(results)
    left.plot(-1e3 * results.column("track_centre_uy"), -1e-3 * results.column("reaction_footing_y"), color="tab:blue",
              label="run with the E found")
    left.plot(-1e3 * data["track_centre_uy"], -1e-3 * data["reaction_footing_y"], "s", color="0.3", fillstyle="none",
              label="data")
    left.set(xlabel="settlement (mm)", ylabel="force on half of the footing (kN/m)", xlim=(0.0, None), ylim=(0.0, None))
    left.legend(loc="lower right")
    right.semilogy(table["iteration"], np.abs(table["E"] / TRUTH - 1.0), "o-", color="tab:blue")
    right.axhline(NEAR, color="0.6", linestyle="--")
    right.set(xlabel="iteration", ylabel="distance of E from that of the data, relative")
    right.xaxis.get_major_locator().set_params(integer=True)
    for axes in (left, right):
        axes.grid(alpha=0.3)
    return figure


if __name__ == "__main__":
    common.main(check, draw)
