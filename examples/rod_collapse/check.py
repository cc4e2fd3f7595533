#!/usr/bin/env python3
"""Surface, front and failure line of a pile of rods at rest against those of an experiment."""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
import common  # noqa: E402
from common import Quantity, completed  # noqa: E402

FOLDER = Path(__file__).resolve().parent
WINDOW = 0.01  # m, over which thickness is a mean
THIN = 0.0015  # m, thickness of the front that the experiment shows last
MOVED = 0.002  # m, more than a rod's diameter: moved


def thickness(state, at):
    """Mean thickness of the pile (m) over the part of a window about each place (m) that is right of the wall."""
    place, area = state["position"][:, 0], state["volume"].ravel()
    sums = [area[np.abs(place - x) < 0.5 * WINDOW].sum() for x in at]
    return np.array(sums) / np.minimum(WINDOW, 0.5 * WINDOW + at)


def front(state):
    at = np.arange(0.5 * WINDOW, state["position"][:, 0].max() + WINDOW, WINDOW / 8.0)
    return at[thickness(state, at) >= THIN][-1]


def stays(results, state, at):
    """Height (m) of the highest point at a place of the first state that has moved by less than MOVED."""
    start = results.initial["position0"][:]
    still = np.linalg.norm(state["position"] - start, axis=1) < MOVED
    spacing = np.diff(np.unique(start[:, 0].round(9))).max()
    heights = [start[still & (np.abs(start[:, 0] - x) <= spacing), 1] for x in at]
    return np.array([height.max() if len(height) else 0.0 for height in heights])


def rms(values):
    return np.sqrt(np.mean(values**2))


def check(results):
    surface, failure = (common.read_table(FOLDER / name) for name in ("surface.csv", "failure.csv"))
    state, high = results.state("last"), results.numbers("mpm_body_pile_upper")[1]
    width = results.numbers("mpm_grid_upper")[0] / common.cells(results)[0]
    error = thickness(state, surface["x"]) - surface["y"]
    fine = width < 0.006
    kinetic = results.history["energy_kinetic"]
    return [completed(results), Quantity("surface_rms", rms(error) / high, None, 0.04 if fine else 0.06),
            Quantity("surface_max", np.abs(error).max() / high, None, 0.08 if fine else 0.15),
            Quantity.near("front", front(state), surface["x"][-1], relative=0.12 if fine else 0.15),
            Quantity("failure_rms", rms(stays(results, state, failure["x"]) - failure["y"]) / high, None, 0.1 if fine else 0.2),
            Quantity("at_rest", kinetic[-1] / kinetic.max(), None, 0.01)]


def draw(results):
    """Points at rest, coloured by whether they moved, and the lines of the experiment."""
    import matplotlib.pyplot as plt

    surface, failure = (common.read_table(FOLDER / name) for name in ("surface.csv", "failure.csv"))
    state, start = results.state("last"), results.initial["position0"][:]
    moved = np.linalg.norm(state["position"] - start, axis=1) >= MOVED
    figure, axes = plt.subplots(figsize=(10.0, 3.6), layout="constrained")
    for which, colour, label in ((moved, "C1", "moved by more than 2 mm"), (~moved, "0.6", "did not")):
        axes.plot(*(1e3 * state["position"][which, :2].T), ".", color=colour, markersize=3.0, label=label)
    axes.plot(1e3 * surface["x"], 1e3 * surface["y"], "k.-", label="experiment: surface")
    axes.plot(1e3 * failure["x"], 1e3 * failure["y"], "k.--", label="experiment: failure line")
    axes.plot([0.0, 200.0, 200.0], [100.0, 100.0, 0.0], color="C0", linewidth=0.8, label="pile at the start")
    axes.set(xlabel="x (mm)", ylabel="y (mm)", xlim=(0.0, 470.0), ylim=(0.0, 105.0), aspect="equal")
    axes.legend(fontsize=8)
    return figure


if __name__ == "__main__":
    common.main(check, draw)
