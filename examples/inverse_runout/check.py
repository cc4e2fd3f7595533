#!/usr/bin/env python3
"""Friction of the bed from the deposit of a slide: that of the run which made the marks."""
import sys
from pathlib import Path

import numpy as np

FOLDER = Path(__file__).resolve().parent
sys.path.insert(0, str(FOLDER.parent))
import common  # noqa: E402
from common import Quantity  # noqa: E402

TRUTH = 0.5
ITERATIONS = 10
MARKS = {"front": 1.341, "middle": 0.449, "back": 0.023}  # m, shifts of the marks


def check(results):
    found = results.summary["inverse"]
    quantities = [common.completed(results), Quantity.near("mu", found["values"][0], TRUTH, relative=2e-3),
                  Quantity("lower", found["lower"][0], None, TRUTH), Quantity("upper", found["upper"][0], TRUTH),
                  Quantity("iterations", found["iterations"], 1, ITERATIONS)]
    return quantities + [Quantity.near(name, results.column(f"track_{name}_ux")[-1], shift, absolute=5e-3)
                         for name, shift in MARKS.items()]


def draw(results):
    """Ways of the marks with the friction found, where they were found, and the way of the friction."""
    import matplotlib.pyplot as plt

    figure, (left, right) = plt.subplots(1, 2, figsize=(9.6, 3.8), layout="constrained")
    for k, (name, shift) in enumerate(MARKS.items()):
        left.plot(results.column("time"), results.column(f"track_{name}_ux"), color=f"C{k}", label=name)
        left.plot(results.column("time")[-1], shift, "s", color=f"C{k}", fillstyle="none")
    left.set(xlabel="time (s)", ylabel="shift of the mark (m)")
    left.legend()
    way = common.read_table(f"{results.prefix}_inverse.csv")
    right.semilogy(way["iteration"], np.abs(way["mu"] / TRUTH - 1.0), "o-")
    right.set(xlabel="iteration", ylabel="distance of mu from 0.5, relative")
    for axes in (left, right):
        axes.grid(alpha=0.3)
    return figure


if __name__ == "__main__":
    common.main(check, draw)
