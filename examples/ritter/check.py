#!/usr/bin/env python3
"""Depth, speed, front and discharge of a dam break on a dry bed, against Ritter's solution."""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
import common  # noqa: E402
from common import Quantity, completed  # noqa: E402
from maps import read_map  # noqa: E402

G, DEPTH = 9.81, 1.0
WAVE = np.sqrt(G * DEPTH)


def exact(x, time):
    """Depth and speed."""
    inside = np.clip(x / time, -WAVE, 2 * WAVE)
    return (2 * WAVE - inside) ** 2 / (9 * G), np.where(x / time < 2 * WAVE, 2 / 3 * (inside + WAVE), 0.0)


def check(results):
    state, history = results.state("last"), results.history
    width, cells = results.numbers("mpm_grid_upper")[1], common.cells(results)[0]
    x, depth = state["position"][:, 0], state["depth"].ravel()
    near = np.argsort(abs(x))[:16]
    last = read_map(f"{results.prefix}_peak")
    difference = abs(last.bands["deposit"][0] - exact(last.x, state.time)[0])
    error = difference.sum() * (last.x[1] - last.x[0]) / (DEPTH * WAVE * state.time)
    coarse = 62.6 / (WAVE * state.time * cells / 12.0)  # 1 with the grid of case.yaml
    return [completed(results),
            Quantity.near("depth_at_dam", depth[near].mean(), 4 / 9 * DEPTH, relative=0.01 * max(1.0, coarse)),
            Quantity.near("speed_at_dam", state["velocity"][near, 0].mean(), 2 / 3 * WAVE, relative=0.01 * max(1.0, coarse)),
            Quantity("front_over_exact", x.max() / (2 * WAVE * state.time), 0.9, 1.12),
            Quantity.near("discharge_over_exact", history["gauge_dam_volume"][-1] / (width * 8 / 27 * WAVE * DEPTH * state.time), 1.0, relative=0.02),
            Quantity("L1", error, None, 0.02 * coarse**0.75)]


def draw(results):
    import matplotlib.pyplot as plt

    state = results.state("last")
    x = np.linspace(-4.0, 8.0, 600)
    figure, axes = plt.subplots(2, 1, figsize=(7.0, 4.0), sharex=True, layout="constrained")
    for axis, name, values, reference in zip(axes, ("depth (m)", "speed (m/s)"), (state["depth"].ravel(), state["velocity"][:, 0]),
                                             exact(x, state.time)):
        axis.plot(x, reference, color="0.6", linewidth=3, label="Ritter")
        axis.plot(state["position"][:, 0], values, ".", color="C0", markersize=2, label="points")
        axis.set(ylabel=name)
    axes[0].legend()
    axes[1].set(xlabel="x (m)")
    return figure


if __name__ == "__main__":
    common.main(check, draw)
