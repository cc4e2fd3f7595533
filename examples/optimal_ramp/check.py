#!/usr/bin/env python3
"""A ramp that leaves a bar at rest: two halves of the load, half a period apart."""
import sys
from pathlib import Path

import numpy as np

FOLDER = Path(__file__).resolve().parent
sys.path.insert(0, str(FOLDER.parent))
import common  # noqa: E402
from common import Quantity  # noqa: E402

STATIC = 0.5 * 100.0 * 1e-3 * 10.0**2 / 1e4  # m, displacement of the tip at rest, rho g L^2/(2 E)
TIMES = np.linspace(0.0, 2.5, 6)  # s, points of the ramp
LINEAR = np.linspace(0.0, 1.0, 6)
PERIOD = 4.0  # s


def ramp(values):
    return np.concatenate([[0.0], values, [1.0]])


def swing(values, period):
    """Amplitude that a mode of this period keeps, over that of a sudden load: |integral of df/dt exp(i w t)|."""
    w = 2.0 * np.pi / period
    slopes = np.diff(values) / np.diff(TIMES)
    return abs((slopes * (np.exp(1j * w * TIMES[1:]) - np.exp(1j * w * TIMES[:-1])) / (1j * w)).sum())


def check(results):
    found = results.summary["inverse"]
    rest = results.column("track_tip_ux")[results.column("time") > 2.55] / STATIC - 1.0
    quantities = [common.completed(results), Quantity("swing", np.abs(rest).max(), None, 2e-3),
                  Quantity("first_mode", swing(ramp(found["values"]), PERIOD), None, 0.01),
                  Quantity("linear_ramp", swing(LINEAR, PERIOD), 0.4)]
    return quantities + [Quantity.near(name, value, 0.5, absolute=0.01)
                         for name, value in zip(found["parameters"], found["values"])]


def draw(results):
    """The ramp found, and the tip."""
    import matplotlib.pyplot as plt

    figure, (left, right) = plt.subplots(1, 2, figsize=(9.6, 3.6), layout="constrained")
    left.plot(TIMES, LINEAR, "--", color="0.6", label="start")
    left.plot(TIMES, ramp(results.summary["inverse"]["values"]), "o-", label="found")
    left.set(xlabel="time (s)", ylabel="part of the load")
    left.legend()
    right.plot(results.column("time"), results.column("track_tip_ux") / STATIC)
    right.axhline(1.0, color="0.6", linestyle="--")
    right.set(xlabel="time (s)", ylabel="displacement of the tip over that at rest")
    for axes in (left, right):
        axes.grid(alpha=0.3)
    return figure


if __name__ == "__main__":
    common.main(check, draw)
