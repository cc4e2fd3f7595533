#!/usr/bin/env python3
"""A stiff inclusion from displacements of the surface: its place and size, and a fit as close as the noise allows."""
import sys
from pathlib import Path

import numpy as np

FOLDER = Path(__file__).resolve().parent
sys.path.insert(0, str(FOLDER.parent))
import common  # noqa: E402
from common import Quantity  # noqa: E402

CORRELATION = 0.9
COST = 60.0  # in forward runs
ADJOINT = 0.9  # of a forward run, as measured
BAND = (0.95, 1.0)  # of the squared residuals over the number of data
CELLS = (40, 25)


def found_and_true(results):
    tables = [common.read_table(path) for path in (f"{results.prefix}_field_stiff.csv", FOLDER / "ground.csv")]
    same = all(np.allclose(tables[0][axis], tables[1][axis]) for axis in "xy")
    return [np.log(table["value"]) for table in tables] if same else None


def check(results):
    found, fields = results.summary["inverse"], found_and_true(results)
    residuals = found["residuals"]
    return [common.completed(results),
            Quantity("correlation", np.corrcoef(*fields)[0, 1] if fields else -1.0, CORRELATION),
            Quantity("misfit", residuals["sum_of_squares"] / residuals["count"], *BAND),
            Quantity("cost", found["evaluations"] * (1.0 + ADJOINT), None, COST)]


def draw(results):
    """The ground that made the readings, the ground found, and the way of the misfit."""
    import matplotlib.pyplot as plt

    figure, panels = plt.subplots(1, 3, figsize=(13.0, 3.4), layout="constrained", width_ratios=(1.0, 1.0, 0.7))
    stiffness = [1e-6 * np.exp(field).reshape(CELLS[::-1]) for field in found_and_true(results)]
    for axes, title, values in zip(panels, ("ground of the readings", "ground found"), stiffness[::-1]):
        image = axes.imshow(values, origin="lower", extent=(0.0, 20.0, 0.0, 12.5), vmin=40.0, vmax=200.0, cmap="viridis")
        axes.contour(stiffness[1], [100.0], origin="lower", extent=(0.0, 20.0, 0.0, 12.5), colors="white", linewidths=0.8)
        axes.set(title=title, xlabel="x (m)", ylabel="y (m)")
    figure.colorbar(image, ax=panels[:2], label="E (MPa)", shrink=0.8)
    way = common.read_table(f"{results.prefix}_inverse.csv")
    panels[2].semilogy(way["evaluations"], way["objective"], "o-", markersize=3)
    panels[2].set(xlabel="runs", ylabel="objective")
    panels[2].grid(alpha=0.3)
    return figure


if __name__ == "__main__":
    common.main(check, draw)
