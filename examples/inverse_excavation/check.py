#!/usr/bin/env python3
"""Readings of an excavation: the analysis finds the ground from which they were made, and what the next stage brings."""
import sys
from pathlib import Path

import numpy as np

FOLDER = Path(__file__).resolve().parent
sys.path.insert(0, str(FOLDER.parent))
import common  # noqa: E402
from common import Quantity  # noqa: E402

GROUND = {"E": 30e6, "cohesion": 12e3, "friction": 28.0}  # of the run that made the readings
CREST = -0.014374773729067591  # m, its settlement of the crest in the last stage
ITERATIONS = 15
READINGS = ("wall_ux", "toe_ux", "floor_uy", "crest_ux")


def check(results):
    found = results.summary["inverse"]
    quantities = [common.completed(results), Quantity("iterations", found["iterations"], None, ITERATIONS)]
    for name, value in zip(found["parameters"], found["values"]):
        quantities.append(Quantity.near(name, value, GROUND[name], relative=1e-4))
    quantities.append(Quantity("told_apart", len(found["not_told_apart"]), 0, 0))
    quantities.append(Quantity.near("crest", found["predictions"]["crest"]["value"], CREST, relative=1e-4))
    return quantities


def draw(results):
    """Readings and the run with the parameters found; the way of the analysis."""
    import matplotlib.pyplot as plt

    readings = common.read_table(FOLDER / "readings.csv")
    figure, (left, right) = plt.subplots(1, 2, figsize=(9.6, 4.0), layout="constrained")
    begins = int(np.flatnonzero(results.column("stage") == 2)[0])
    for k, name in enumerate(READINGS):
        left.plot(results.column("time")[begins:], 1e3 * results.column(f"track_{name}")[begins:], color=f"C{k}", label=name)
        left.plot(readings["time"], 1e3 * readings[f"track_{name}"], "o", color=f"C{k}", markersize=4)
    left.axvspan(3.0, 4.0, color="0.9", label="forecast")
    left.set(xlabel="time (stages)", ylabel="displacement (mm)")
    left.legend(fontsize=8)
    way = common.read_table(f"{results.prefix}_inverse.csv")
    for name, value in GROUND.items():
        right.plot(way["iteration"], way[name] / value, "o-", label=name, markersize=4)
    right.set(xlabel="iteration", ylabel="parameter over that of the ground")
    right.legend(fontsize=8)
    return figure


if __name__ == "__main__":
    common.main(check, draw)
