#!/usr/bin/env python3
"""The front of a dam break against the experiment of Martin and Moyce, its energy and its compression."""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
import common  # noqa: E402
from common import Quantity, cells, completed  # noqa: E402

# t sqrt(2 g/a) and x/a of the front, from their figure 3: columns 1.125 and 2.25 inches wide, twice as high
SMALL = np.array([[0.849, 1.245], [1.212, 1.443], [1.602, 1.884], [2.283, 2.689], [2.950, 3.728], [3.598, 4.528]])
LARGE = np.array([[0.832, 1.217], [1.219, 1.474], [1.997, 2.292], [2.547, 2.995], [3.345, 4.134], [4.034, 4.944]])
WIDTH = 1.0  # a, m
COUNT = 4  # the front is this point's, counted from the first: spray is not the front


def front(results):
    """Times and places, in the units of the experiment, until the water reaches the end of the tank."""
    gravity = -results.numbers("mpm_load_weight_value")[1]
    end = results.numbers("mpm_grid_upper")[0]
    rows = []
    for step in results.steps:
        state = results.state(step)
        place = np.sort(state["position"][:, 0])[-COUNT]
        rows.append((state.time * np.sqrt(2.0 * gravity / WIDTH), place / WIDTH))
        if place > 0.97 * end:
            break
    return np.array(rows).T


def lead(results, measured):
    """By how much the computed front is earlier where both are on their way."""
    time, place = front(results)
    return np.array([when - np.interp(where, place, time) for when, where in measured if 2.0 < where < 4.5])


def check(results):
    history = results.history
    fine = cells(results)[0] >= 100
    early = lead(results, LARGE)
    computed, places = front(results)
    span = [np.interp(where, places, computed) for where in (LARGE[2, 1], LARGE[4, 1])]
    measured = (LARGE[4, 1] - LARGE[2, 1]) / (LARGE[4, 0] - LARGE[2, 0])
    speed = (LARGE[4, 1] - LARGE[2, 1]) / (span[1] - span[0])
    balance = np.abs(history["energy_balance"]).max() / np.abs(history["energy_external"]).max()
    ratios = [results.state(step)["volume_ratio"].min() for step in results.steps]
    return [completed(results), Quantity.near("speed_of_front", speed, measured, relative=0.04 if fine else 0.08),
            Quantity("earlier_than_large_column", early.mean(), 0.0, 0.35), Quantity("spread", np.ptp(early), None, 0.1),
            Quantity("energy_missing", balance, None, 0.01 if fine else 0.03), Quantity("least_volume_ratio", min(ratios), 0.93, 1.0)]


def draw(results):
    """Four states, and the front."""
    import matplotlib.pyplot as plt
    from pictures.plane import draw_body

    figure, axes = plt.subplots(3, 2, figsize=(9.0, 8.0), layout="constrained")
    for axis, part in zip(axes.flat, (0.0, 0.25, 0.5, 0.7, 1.0)):
        state = results.state(results.steps[int(part * (len(results.steps) - 1))])
        speed = np.linalg.norm(state["velocity"], axis=1)
        dots = draw_body(axis, results, state, speed, ("viridis", 0.0, 7.0))
        axis.set(title=f"{state.time:.2f} s", aspect="equal", xlim=(0, 5), ylim=(0, 2.1))
    figure.colorbar(dots, ax=axes[:2], label="speed (m/s)")
    time, place = front(results)
    axis = axes[2, 1]
    axis.plot(time, place, color="C0", label="computed")
    axis.plot(*SMALL.T, "s", color="0.5", markerfacecolor="none", label="Martin and Moyce, 1.125 inches")
    axis.plot(*LARGE.T, "o", color="k", markerfacecolor="none", label="the same, 2.25 inches")
    axis.set(xlabel="t sqrt(2 g/a)", ylabel="front x/a", ylim=(1, 5))
    axis.legend(fontsize=7)
    return figure


if __name__ == "__main__":
    common.main(check, draw)
