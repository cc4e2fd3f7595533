#!/usr/bin/env python3
"""Force on a pressed cell with a hole, empty, filled with air or under a background, against references."""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
import common  # noqa: E402
from common import Quantity, completed  # noqa: E402

# MN per metre at 5 and 10 %; a background adds its own stiffness in the material's cells, too
EXACT = {"empty": (11.1688, 23.2325), "air": (11.3764, 23.6837)}


def kind(results):
    return "air" if "air" in results.option("mpm_materials") else "background" if results.is_given("mpm_backgrounds") else "empty"


def curve(results):
    return 10.0 * results.column("time"), -results.column("reaction_top_y") / 1e6


def check(results):
    shortening, force = curve(results)
    quantities = [completed(results)]
    for percent, exact in zip((5.0, 10.0), EXACT["air" if kind(results) == "air" else "empty"]):
        found = np.interp(percent, shortening, force)
        quantities.append(Quantity.near(f"force_{percent:g}", found, exact, relative=0.01))
    return quantities


def draw(results):
    import matplotlib.pyplot as plt

    figure, (left, right) = plt.subplots(1, 2, figsize=(7.0, 2.9), layout="constrained", width_ratios=(1.0, 1.4))
    state = results.state("last")
    place, stress = state["position"], state["stress"]
    drawn = left.scatter(place[:, 0], place[:, 1], s=0.6, c=-stress[:, 1] / 1e6, cmap="viridis", rasterized=True)
    left.set(aspect="equal", xlabel="x (m)", ylabel="y (m)")
    figure.colorbar(drawn, ax=left, label="vertical pressure (MPa)")
    right.plot(*curve(results), label=kind(results))
    for name, style in (("empty", "o"), ("air", "s")):
        right.plot((5, 10), EXACT[name], style, color="0.3", fillstyle="none", label=f"{name}, reference")
    right.set(xlabel="shortening (%)", ylabel="force (MN/m)")
    right.legend()
    return figure


if __name__ == "__main__":
    common.main(check, draw)
