#!/usr/bin/env python3
"""Compares a run of vortex with the manufactured solution."""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
import common  # noqa: E402
from common import Quantity, cells, completed  # noqa: E402

ANGLE, PERIOD = 0.25, 1.0  # by default, as in vortex.c
# Upper bounds of the relative errors of displacement and velocity at a quarter of the period with gimp_bspline2 and APIC: a
# fifth above what was measured, by cells an axis.
BOUNDS = {24: (0.283, 0.327), 48: (0.090, 0.108), 96: (0.0178, 0.0193)}


def motion(results):
    """Angle and period of the run."""
    return float(results.option("vortex_angle", str(ANGLE))), float(results.option("vortex_period", str(PERIOD)))


def exact(results, place, time):
    """Displacement and velocity of points that were at `place`."""
    most, period = motion(results)
    radius = np.hypot(*place.T)
    shape = np.where(np.abs(radius - 1) < 0.25, (1 - 16 * (radius - 1) ** 2) ** 2, 0)
    omega = 2 * np.pi / period
    angle = most * shape * (1 - np.cos(omega * time)) / 2
    rate = most * shape * omega * np.sin(omega * time) / 2
    cos, sin = np.cos(angle), np.sin(angle)
    now = np.column_stack([cos * place[:, 0] - sin * place[:, 1], sin * place[:, 0] + cos * place[:, 1]])
    return now - place, rate[:, None] * np.column_stack([-now[:, 1], now[:, 0]])


def quarter(results):
    """The written state that is nearest to a quarter of the period."""
    states = [results.state(step) for step in results.steps]
    return min(states, key=lambda state: abs(state.time - motion(results)[1] / 4))


def errors(results, state):
    """Root mean squares over the points, relative to those of the exact fields at a quarter of the period."""
    place, period = results.state("first")["position0"], motion(results)[1]
    scale = [np.sqrt((field**2).mean()) for field in (exact(results, place, period / 2)[0] / 2, exact(results, place, period / 4)[1])]
    return [np.sqrt(((state[name] - field) ** 2).mean()) / size
            for name, field, size in zip(("displacement", "velocity"), exact(results, place, state.time), scale)]


def check(results):
    displacement, velocity = errors(results, quarter(results))
    known = (results.option("mpm_shape", "gimp") == "gimp_bspline2"
             and results.option("mpm_time_transfer", "apic") == "apic" and motion(results) == (ANGLE, PERIOD))
    bounds = BOUNDS.get(cells(results)[0], (1.0, 1.0)) if known else (1.0, 1.0)
    return [completed(results), Quantity("displacement_error", displacement, upper=bounds[0]),
            Quantity("velocity_error", velocity, upper=bounds[1])]


def draw(results):
    import matplotlib.pyplot as plt

    state = quarter(results)
    place = results.state("first")["position0"]
    figure, axes = plt.subplots(1, 2, figsize=(10, 4.2), constrained_layout=True)
    speed = np.hypot(*state["velocity"].T)
    off = speed - np.hypot(*exact(results, place, state.time)[1].T)
    for axis, value, title in ((axes[0], speed, "speed, computed (m/s)"), (axes[1], off, "computed - exact (m/s)")):
        dots = axis.scatter(*state["position"].T, c=value, s=4e4 / len(place), marker="s", cmap="viridis")
        figure.colorbar(dots, ax=axis)
        axis.set(title=title, xlabel="x (m)", ylabel="y (m)", aspect="equal")
    return figure


if __name__ == "__main__":
    common.main(check, draw)
