#!/usr/bin/env python3
"""Force, energy of fracture and path of a crack from a slot, against finite elements (reference.csv, reference.py)."""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
import common  # noqa: E402
from common import Quantity, completed, read_table  # noqa: E402

FOLDER = Path(__file__).resolve().parent
OPENING = 6e-3  # m, of the ends at time 1
BROKEN = 0.9


def curve(results):
    """Opening, m, force, MN/m, and energy of fracture, MJ/m."""
    return OPENING * results.column("time"), results.column("reaction_high_y") / 1e6, results.column("energy_fracture") / 1e6


def path(results):
    """Places of the largest damage ahead of the slot, in columns of cells where it is broken."""
    state, count = results.state("last"), common.cells(results)[0]
    place, damage = state["position"], state["damage"].ravel()
    column = np.floor(place[:, 0] * count).astype(int)
    most = [np.flatnonzero(column == k)[np.argmax(damage[column == k])] for k in range(count // 2, count)]
    return np.array([place[k] for k in most if damage[k] > BROKEN]).reshape(-1, 2)


def check(results):
    opening, force, energy = curve(results)
    exact = read_table(FOLDER / "reference.csv")
    ahead = path(results)
    quantities = [completed(results),
                  Quantity.near("peak", force.max(), exact["force"].max(), relative=0.03)]
    for at in (3.6e-3, 4.8e-3):
        quantities.append(Quantity.near(f"energy_{at:g}", np.interp(at, opening, energy), np.interp(at, exact["displacement"], exact["fracture"]),
                                        relative=0.03))
    if opening[-1] > 5.6e-3:
        quantities.append(Quantity("broken_columns", len(ahead), 2))
        quantities.append(Quantity("off_the_middle", abs(ahead[:, 1] - 0.5).max() * common.cells(results)[0], None, 1.0))
    return quantities


def draw(results):
    import matplotlib.pyplot as plt

    figure, (left, right) = plt.subplots(1, 2, figsize=(7.0, 2.9), layout="constrained", width_ratios=(1.0, 1.4))
    state, exact = results.state("last"), read_table(FOLDER / "reference.csv")
    drawn = left.scatter(*state["position"].T, s=0.8, c=state["damage"].ravel(), cmap="magma_r", vmin=0.0, vmax=1.0, rasterized=True)
    left.set(aspect="equal", xlabel="x (m)", ylabel="y (m)")
    figure.colorbar(drawn, ax=left, label="damage")
    opening, force, _ = curve(results)
    right.plot(1e3 * exact["displacement"], exact["force"], color="0.6", linewidth=3, label="finite elements")
    right.plot(1e3 * opening, force, ".-", markersize=4, label="computed")
    right.set(xlabel="opening of the ends (mm)", ylabel="force (MN/m)", ylim=(0, None))
    right.legend()
    return figure


if __name__ == "__main__":
    common.main(check, draw)
