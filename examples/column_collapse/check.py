#!/usr/bin/env python3
"""Runout, height and duration of a granular column's collapse against the laws of Lube et al.'s experiments."""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
import common  # noqa: E402
from common import Quantity, completed  # noqa: E402

SPRAY = 0.001  # of the sand, not counted in the runout
WINDOW = 0.3  # over which thickness is a mean, of the initial width: columns of points are up to a tenth apart at the end


def column(results):
    """Width and aspect ratio."""
    width, height = results.numbers("mpm_body_column_upper")
    return width, height / width


def profile(results, state):
    """Thickness of the deposit by x, both over the initial width."""
    width, _ = column(results)
    place, area = state["position"][:, 0] / width, state["volume"] / width**2
    at = np.arange(0.5 * WINDOW, place.max() + WINDOW, WINDOW / 16.0)
    order = np.argsort(place)
    total = np.concatenate([[0.0], np.cumsum(area[order])])
    until = [total[np.searchsorted(place[order], at + side * WINDOW)] for side in (-0.5, 0.5)]
    return at, (until[1] - until[0]) / WINDOW


def runout(results, state):
    width, _ = column(results)
    order = np.argsort(state["position"][:, 0])
    share = np.cumsum(state["volume"][order]) / state["volume"].sum()
    return state["position"][order[np.searchsorted(share, 1.0 - SPRAY)], 0] / width - 1.0


def laws(ratio):
    """Of the experiments: runout, final height, both over the width."""
    return 1.2 * ratio if ratio < 1.8 else 1.9 * ratio ** (2.0 / 3.0), ratio if ratio < 1.15 else ratio**0.4


def fronts(results):
    states = [results.state(step) for step in results.steps]
    return np.array([state.time for state in states]), np.array([runout(results, state) for state in states])


def check(results):
    width, ratio = column(results)
    far, high = laws(ratio)
    fine = width / (results.numbers("mpm_grid_upper")[0] / common.cells(results)[0]) * min(ratio, 1.0) > 9.0
    last = results.state("last")
    time, front = fronts(results)
    fall = np.sqrt(ratio * width / -results.numbers("mpm_load_weight_value")[1])
    until = np.interp(0.95 * front[-1], front, time) / fall
    kinetic = results.history["energy_kinetic"]
    return [completed(results), Quantity.near("runout", front[-1], far, relative=0.1 if fine else 0.3),
            Quantity.near("height", profile(results, last)[1].max(), high, relative=0.2),
            Quantity("duration", until, 2.0, 3.5), Quantity("at_rest", kinetic[-1] / kinetic.max(), None, 0.01)]


def draw(results):
    """The sand at three times, by the height that it came from, and the front."""
    import matplotlib.pyplot as plt

    width, ratio = column(results)
    far, high = laws(ratio)
    figure, axes = plt.subplots(2, 2, figsize=(10.0, 6.4), layout="constrained")
    time, front = fronts(results)
    steps = results.steps
    for above, part in zip(axes.flat, (0.15, 0.3, 1.0)):
        state = results.state(steps[int(part * (len(steps) - 1))])
        height = results.initial["position0"][:, 1] / width
        dots = above.scatter(*(state["position"] / width).T, c=height, s=2.0, linewidths=0.0)
        above.plot([0.0, 1.0, 1.0], [ratio, ratio, 0.0], color="0.6", linewidth=0.8, label="at the start")
        above.axvline(1.0 + far, color="k", linewidth=0.8, linestyle="--", label="runout and height of the experiments")
        above.axhline(high, color="k", linewidth=0.8, linestyle="--")
        above.set(xlabel="x / width", ylabel="y / width", xlim=(0, 1.1 * (1.0 + far)), ylim=(0, 1.1 * ratio), title=f"{state.time:.2f} s")
    axes[0, 0].legend(fontsize="small")
    figure.colorbar(dots, ax=axes[1, 0], label="height at the start / width")
    below = axes[1, 1]
    below.plot(time, front, color="C0")
    below.axhline(far, color="k", linewidth=0.8, linestyle="--")
    below.set(xlabel="time (s)", ylabel="runout / width")
    return figure


if __name__ == "__main__":
    common.main(check, draw)
