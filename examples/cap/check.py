#!/usr/bin/env python3
"""Centre, width and depth of a cap that slides down a slope, against Savage and Hutter's parabolic cap."""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
import common  # noqa: E402
from common import Quantity, completed  # noqa: E402
from maps import read_map  # noqa: E402

G, SLOPE, FRICTION = 9.81, np.radians(30.0), np.radians(24.0)
HEIGHT, HALF = 2.0, 60.0  # m, along the slope and normal to it


def exact(time, steps=4000):
    """Place of the centre, half width and largest depth: L'' = 2 g cos(slope) H0 L0/L^2, from rest."""
    def change(y):
        return np.array([y[1], 2.0 * G * np.cos(SLOPE) * HEIGHT * HALF / y[0] ** 2])

    y, dt = np.array([HALF, 0.0]), time / steps
    for _ in range(steps):
        a = change(y)
        b = change(y + 0.5 * dt * a)
        c = change(y + 0.5 * dt * b)
        y = y + dt / 6.0 * (a + 2 * b + 2 * c + change(y + dt * c))
    return 0.5 * G * (np.sin(SLOPE) - np.cos(SLOPE) * np.tan(FRICTION)) * time**2, y[0], HEIGHT * HALF / y[0]


def along(results):
    """Places of the points along the slope, and their shares of the volume."""
    state = results.state("last")
    volume = state["volume"].ravel()
    return state["position"][:, 0] / np.cos(SLOPE), volume / volume.sum()


def check(results):
    s, share = along(results)
    centre, half, depth = exact(results.state("last").time)
    middle = (share * s).sum()
    width = np.sqrt(5.0 * (share * (s - middle) ** 2).sum())
    last = read_map(f"{results.prefix}_peak").bands["deposit_normal"]
    return [completed(results),
            Quantity.near("centre", middle, centre, relative=0.005),
            Quantity.near("half_width", width, half, relative=0.005),
            Quantity.near("depth", last.max(), depth, relative=0.005)]


def draw(results):
    import matplotlib.pyplot as plt

    last = read_map(f"{results.prefix}_peak")
    centre, half, depth = exact(results.state("last").time)
    figure, axis = plt.subplots(figsize=(7.0, 2.6), layout="constrained")
    for place, reach, height, colour, label in ((0.0, HALF, HEIGHT, "0.8", "at first"), (centre, half, depth, "0.5", "exact")):
        y = np.linspace(-1.0, 1.0, 201)
        axis.fill_between(place + reach * y, height * (1 - y**2), color=colour, alpha=0.5, label=label)
    axis.plot(last.x / np.cos(SLOPE), last.bands["deposit_normal"][0], ".-", color="C0", markersize=3, linewidth=0.8, label="computed")
    axis.set(xlabel="along the slope (m)", ylabel="normal depth (m)", ylim=(0, 2.2))
    axis.legend()
    return figure


if __name__ == "__main__":
    common.main(check, draw)
