#!/usr/bin/env python3
"""Grains in a binder under a press: first stiffness between bounds, balance of the walls, energy, iterations."""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
import common  # noqa: E402
from common import Quantity, completed  # noqa: E402

FOLDER = Path(__file__).resolve().parent
SIDE, SHORTENING = 1e-3, 0.2  # m; of the side at time 1


def modulus(E, nu):
    """Of compression without lateral strain."""
    return E * (1.0 - nu) / ((1.0 + nu) * (1.0 - 2.0 * nu))


def bounds():
    """Voigt and Reuss bounds of that modulus, Pa, by the voxels."""
    label = np.fromfile(FOLDER / "grains.raw", dtype="u1")
    share = [np.mean(label == k) for k in range(3)]
    part = [modulus(5e6, 0.0), modulus(300e6, 0.25), modulus(4000e6, 0.25)]
    return 1.0 / sum(f / M for f, M in zip(share, part)), sum(f * M for f, M in zip(share, part))


def curve(results):
    """Shortening, pressure on the top, MPa, and energy of fracture, mJ."""
    shortening = SHORTENING * results.column("time")
    return shortening, -results.column("reaction_top_z") / SIDE**2 / 1e6, 1e3 * results.column("energy_fracture")


def check(results):
    shortening, pressure, energy = curve(results)
    reuss, voigt = bounds()
    quantities = [completed(results)]
    stiffness = 1e6 * pressure[0] / shortening[0]
    if "air" in results.option("mpm_materials"):
        quantities.append(Quantity("stiffness_over_reuss", stiffness / reuss, 1.0, None))
    quantities.append(Quantity("stiffness_over_voigt", stiffness / voigt, None, 1.0))
    for low, high, axis in (("west", "east", "x"), ("south", "north", "y"), ("base", "top", "z")):
        ends = [results.column(f"reaction_{side}_{axis}") for side in (low, high)]
        quantities.append(Quantity(f"balance_{axis}", max(abs(ends[0] + ends[1]) / abs(ends[1])), None, 1e-6))
    work = np.concatenate([[0.0], np.cumsum(0.5e6 * (pressure[1:] + pressure[:-1]) * np.diff(shortening))]) * SIDE**3
    work += 0.5e6 * pressure[0] * shortening[0] * SIDE**3
    quantities.append(Quantity("fracture_grows", np.diff(energy).min(), 0.0, None))
    quantities.append(Quantity("fracture_over_work", (1e-3 * energy / work).max(), None, 1.0))
    quantities.append(Quantity("iterations", (results.column("linear") / results.column("newton")).max(), None, 30.0))
    return quantities


def draw(results):
    import matplotlib.pyplot as plt

    figure, (left, right) = plt.subplots(1, 2, figsize=(7.0, 2.9), layout="constrained", width_ratios=(1.0, 1.4))
    state = results.state(next(step for step in results.steps if results.state(step).time >= 0.25))
    place, damage, grain = 1e3 * state["position"], state["damage"].ravel(), state["material"].ravel() == 0
    cut = abs(place[:, 1] - 0.47) < 0.03
    side = 72 * 2.02 / 16  # of a point's square in the picture
    drawn = left.scatter(place[cut, 0], place[cut, 2], s=side**2, marker="s", c=damage[cut], cmap="magma_r", vmin=0.0, vmax=1.0)
    left.scatter(place[cut & grain, 0], place[cut & grain, 2], s=9, c="tab:blue", label="grain")
    left.set(aspect="equal", xlabel="x (mm)", ylabel="z (mm)", xlim=(0, 1), ylim=(0, 1), title="shortened by 5 %")
    shortening, pressure, energy = curve(results)
    right.plot(100 * shortening, pressure, ".-", markersize=4, label="pressure (MPa)")
    right.plot(100 * shortening, 10 * energy, ".-", markersize=4, label="energy of fracture (0.1 mJ)")
    right.set(xlabel="shortening (%)", ylim=(0, None))
    right.legend()
    return figure


if __name__ == "__main__":
    common.main(check, draw)
