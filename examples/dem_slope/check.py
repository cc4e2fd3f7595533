#!/usr/bin/env python3
"""Ground between two maps: its volume by layers, the factor of safety, and where the soil moves."""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
import common  # noqa: E402
from common import Quantity  # noqa: E402

sys.path.insert(0, str(Path(__file__).resolve().parent))
import make  # noqa: E402



def integral(results, value):
    """Over the grid, which ends on centres of the pixels of 2 m."""
    upper = results.numbers("mpm_grid_upper")
    part = value(*np.meshgrid(*(np.arange(0.0, end + 1.0, 2.0) for end in upper[:2])))
    return float((part[:-1, :-1] + part[1:, :-1] + part[:-1, 1:] + part[1:, 1:]).sum())  # a quarter of 4 m2 each



def check(results):
    state = results.state(0)
    volume = [float(state["volume"][state["material"] == k].sum()) for k in (0, 1)]
    last = results.state("last")
    moved = np.linalg.norm(last["displacement"], axis=1)
    far = moved > 0.5 * moved.max()
    return [common.completed(results), Quantity.near("soil", volume[0], integral(results, make.soil), relative=1e-10),
            Quantity.near("rock", volume[1], integral(results, lambda x, y: make.ground(x, y) - make.soil(x, y)), relative=1e-10),
            Quantity("factor_of_safety", results.summary["factor_of_safety"] or np.nan, 1.6, 1.75),
            Quantity("slide_in_soil", float(np.mean(last["material"][far] == 0)), 0.95),
            Quantity("slide_y", float(last["position"][far, 1].mean()), 7.0)]


def draw(results):
    """How far points of the surface have moved, on the ground, and a section through the hollow."""
    import matplotlib.pyplot as plt

    state = results.state("last")
    place, moved = state["position"], np.linalg.norm(state["displacement"], axis=1)
    figure, (above, below) = plt.subplots(2, 1, figsize=(9.0, 5.6), layout="constrained", height_ratios=(3, 2))
    top = {}
    for p in np.argsort(place[:, 2]):
        top[tuple(np.round(place[p, :2] / 1.2).astype(int))] = p
    top = np.array(sorted(top.values()))
    for sign in (1.0, -1.0):
        points = above.scatter(place[top, 0], 14.0 + sign * (place[top, 1] - 14.0), c=moved[top], s=30, cmap="viridis")
    above.set(xlabel="x (m)", ylabel="y (m)", aspect="equal")
    cut = place[:, 1] > 12.0
    below.scatter(place[cut, 0], place[cut, 2], c=moved[cut], s=np.where(state["material"][cut] == 0, 22, 6), cmap="viridis")
    below.set(xlabel="x (m)", ylabel="z (m)", aspect="equal")
    figure.colorbar(points, ax=[above, below], label="displacement (m)")
    return figure


if __name__ == "__main__":
    common.main(check, draw)
