#!/usr/bin/env python3
"""Speed of a lake that ought to be at rest, and its volume."""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
import common  # noqa: E402
from common import Quantity, completed  # noqa: E402
from maps import read_map  # noqa: E402

G, LEVEL = 9.81, 1.0


def check(results):
    first, last = results.initial, results.state("last")
    return [completed(results), Quantity("steps", results.summary["steps"], 300),
            Quantity("speed_over_wave", np.abs(last["velocity"]).max() / np.sqrt(G * last["depth"].max()), None, 1e-10),
            Quantity("way_over_cell", np.abs(last["position"] - first["position"]).max() / 0.5, None, 1e-9),
            Quantity("dry_part", np.mean(read_map(f"{results.prefix}_peak").bands["depth"] == 0.0), 0.2, 0.8)]


def draw(results):
    import matplotlib.pyplot as plt

    field = read_map(f"{results.prefix}_peak")
    figure, axes = plt.subplots(2, 1, figsize=(6.0, 6.0), layout="constrained", height_ratios=(3, 2))
    depth = np.ma.masked_less_equal(field.bands["depth"], 0.01)
    axes[0].contour(field.x, field.y, field.bands["bed"], 14, colors="0.5", linewidths=0.5)
    figure.colorbar(axes[0].pcolormesh(field.x, field.y, depth, cmap="Blues", vmin=0.0), ax=axes[0], label="depth (m)")
    axes[0].set(aspect="equal", xlabel="x (m)", ylabel="y (m)")
    row = np.argmin(abs(field.y - 6.0))
    bed, level = field.bands["bed"][row], np.where(field.bands["depth"][row] > 0.01, LEVEL, np.nan)
    axes[1].fill_between(field.x, bed, bed.min() - 0.2, color="0.8")
    axes[1].fill_between(field.x, bed, np.where(level > bed, level, bed), color="C0", alpha=0.4)
    axes[1].set(xlabel="x (m), at y = 6 m", ylabel="height (m)")
    return figure


if __name__ == "__main__":
    common.main(check, draw)
