#!/usr/bin/env python3
"""Settlement of eight months tells permeability and compressibility of the clay, and the settlement in the end."""
import sys
from pathlib import Path

import numpy as np

FOLDER = Path(__file__).resolve().parent
sys.path.insert(0, str(FOLDER.parent))
import common  # noqa: E402
from common import Quantity  # noqa: E402

CLAY = {"permeability": 1e-15, "lambda": 0.15}  # of the run that made the readings
LAST = -0.9420047  # m, its settlement in the end
YEAR = 3.15576e7  # s


def check(results):
    found = results.summary["inverse"]
    last = found["predictions"]["last"]
    quantities = [common.completed(results), Quantity("iterations", found["iterations"], 1, 10),
                  Quantity("told_apart", len(found["not_told_apart"]), 0, 0),
                  Quantity.near("last", last["value"], LAST, absolute=2e-3),
                  Quantity("bounds", (LAST - last["lower"]) * (last["upper"] - LAST), 0.0)]
    return quantities + [Quantity.near(name, value, CLAY[name], relative=5e-3)
                         for name, value in zip(found["parameters"], found["values"])]


def draw(results):
    """Readings, the run with the parameters found, and the way of the parameters."""
    import matplotlib.pyplot as plt

    figure, (left, right) = plt.subplots(1, 2, figsize=(9.6, 3.8), layout="constrained")
    readings = common.read_table(FOLDER / "readings.csv")
    years = results.column("time") > 1.0
    left.plot(results.column("time")[years] / YEAR, results.column("track_top_uy")[years], label="run with the clay found")
    left.plot(readings["time"] / YEAR, readings["track_top_uy"], "s", color="0.3", fillstyle="none", label="readings")
    left.axhline(LAST, color="0.6", linestyle="--", label="in the end, forecast")
    left.set(xlabel="time (years)", ylabel="settlement (m)")
    left.legend()
    way = common.read_table(f"{results.prefix}_inverse.csv")
    for name, value in CLAY.items():
        right.semilogy(way["iteration"], np.abs(way[name] / value - 1.0), "o-", label=name)
    right.set(xlabel="iteration", ylabel="distance from that of the readings, relative")
    right.legend()
    for axes in (left, right):
        axes.grid(alpha=0.3)
    return figure


if __name__ == "__main__":
    common.main(check, draw)
