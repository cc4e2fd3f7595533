#!/usr/bin/env python3
"""Depth in the middle and place of the shore of water in a bowl, against Thacker's solution."""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
import common  # noqa: E402
from common import Quantity, completed  # noqa: E402
from maps import read_map  # noqa: E402

G, DEPTH, RADIUS, START = 9.81, 1.0, 10.0, 8.0
A = (RADIUS**4 - START**4) / (RADIUS**4 + START**4)
OMEGA = np.sqrt(8.0 * G * DEPTH) / RADIUS
PERIOD = 2.0 * np.pi / OMEGA


def depth(r, time):
    """Depth, negative beyond the shore."""
    swing = 1.0 - A * np.cos(OMEGA * time)
    return DEPTH * (np.sqrt(1.0 - A * A) / swing - (r / RADIUS) ** 2 * (1.0 - A * A) / swing**2)


def shore(state):
    """Radius of the water by its mean square: of a parabola of depth R^2/3."""
    volume = state["volume"].ravel()
    return np.sqrt(3.0 * (volume * (state["position"] ** 2).sum(axis=1)).sum() / volume.sum())


def shore_exact(time):
    return RADIUS * np.sqrt((1.0 - A * np.cos(OMEGA * time)) / np.sqrt(1.0 - A * A))


def check(results):
    last = read_map(f"{results.prefix}_peak")
    r = np.hypot(*np.meshgrid(last.x, last.y))
    time = results.state("last").time
    exact, found = np.maximum(depth(r, time), 0.0), np.nan_to_num(last.bands["deposit"])
    states = [results.state(step) for step in results.steps]
    reach = max(abs(shore(state) / shore_exact(state.time) - 1.0) for state in states)
    history = results.history
    middle = abs(history["gauge_middle_depth"] - depth(0.0, history["time"] - history["dt"]))
    coarse = 56.0 / common.cells(results)[0]
    return [completed(results),
            Quantity("shore", reach, None, 0.006 * coarse),
            Quantity("middle", middle.max() / DEPTH, None, 0.06 * coarse),
            Quantity("L1", abs(found - exact).sum() / exact.sum(), None, 0.03 * coarse)]


def draw(results):
    import matplotlib.pyplot as plt

    history = results.history
    figure, axes = plt.subplots(2, 1, figsize=(7.0, 4.4), sharex=True, layout="constrained")
    time = np.linspace(0.0, history["time"][-1], 300)
    states = [results.state(step) for step in results.steps]
    axes[0].plot(time, depth(0.0, time), color="0.6", linewidth=3, label="Thacker")
    axes[0].plot(history["time"], history["gauge_middle_depth"], color="C0", label="computed")
    axes[1].plot(time, shore_exact(time), color="0.6", linewidth=3)
    axes[1].plot([state.time for state in states], [shore(state) for state in states], "o", color="C0", markersize=3)
    axes[0].set(ylabel="depth in the middle (m)")
    axes[1].set(xlabel="time (s)", ylabel="shore (m)")
    axes[0].legend()
    return figure


if __name__ == "__main__":
    common.main(check, draw)
