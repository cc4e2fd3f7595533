#!/usr/bin/env python3
"""Mass, momentum and centres of mass of points made from columns, against the columns and the exact volume."""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
import common  # noqa: E402
from common import Quantity, completed  # noqa: E402

VOLUME, DENSITY, SPEED, SIZE, SPACING = 250.88176517, 1000.0, 2.001, 0.125, 0.5


def depth(x, y):
    return 10 - np.sin(2 * x) * np.cos(y)


def check(results):
    state = results.state("first")
    mass, place, speed = state["mass"].ravel(), state["position"], state["velocity"]
    at, column = np.unique(np.round(place[:, :2], 6), axis=0, return_inverse=True)
    column, deep = column.ravel(), depth(at[:, 0], at[:, 1])
    total, count = np.bincount(column, mass), np.bincount(column)
    centre = np.bincount(column, mass * place[:, 2]) / total
    second = np.bincount(column, mass * (place[:, 2] - centre[column]) ** 2) / total / deep**2
    top = place[:, 2] + state["half_length"][:, 2]
    return [completed(results),
            Quantity("columns", len(at), 1600, 1600),
            Quantity.near("mass_of_columns", mass.sum(), DENSITY * SIZE**2 * deep.sum(), relative=1e-13),
            Quantity.near("mass_exact", mass.sum(), DENSITY * VOLUME, relative=2e-5),
            Quantity.near("momentum", (mass * speed[:, 0]).sum(), SPEED * mass.sum(), relative=1e-13),
            Quantity("points_per_column", abs(count - np.round(deep / SPACING)).max(), 0, 0),
            Quantity("centre", abs(centre - deep / 2).max(), 0, 1e-9),
            Quantity("second_moment", abs(second - (1 - 1 / count**2) / 12).max(), 0, 1e-12),
            Quantity("outside", max((top - deep[column]).max(), -(2 * place[:, 2] - top).min()), None, 1e-9)]


def draw(results):
    import matplotlib.pyplot as plt

    state = results.state("first")
    place = state["position"]
    row = abs(place[:, 1] - place[:, 1].min()) < 1e-6
    figure, axis = plt.subplots(figsize=(7.0, 4.0), layout="constrained")
    x = np.linspace(0.0, 5.0, 400)
    axis.fill_between(x, depth(x, place[:, 1].min()), color="0.9", label="columns")
    axis.plot(place[row, 0], place[row, 2], ".", color="C0", markersize=3, label="points")
    axis.set(xlabel="x (m)", ylabel="z (m)", ylim=(0.0, 12.0))
    axis.legend()
    return figure


if __name__ == "__main__":
    common.main(check, draw)
