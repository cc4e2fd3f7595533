#!/usr/bin/env python3
"""Where the disc comes to rest, and the forces on its supports, against statics."""
import sys
from pathlib import Path

import numpy as np

FOLDER = Path(__file__).resolve().parent
sys.path.insert(0, str(FOLDER.parent))
import common  # noqa: E402
from common import Quantity  # noqa: E402

MIDDLE = 2.0  # m
PLACE = 1e-6  # of the radius
BALANCE = 1e-10  # of the load
THRUST = 0.06  # of the thrust: where in a cell a corner touches is not known better


def reaction(results, name, row=-1):
    return np.array([results.column(f"reaction_{name}_{axis}")[row] for axis in "xy"])


def corner(results, side):
    """Where the point at a block's upper inner corner stands."""
    start = np.array(results.numbers(f"mpm_track_{side}_at"))
    return start + [results.column(f"track_{side}_u{axis}")[-1] for axis in "xy"]


def centre(results, row=-1):
    return np.array([results.column(f"position_disc_{axis}")[row] for axis in "xy"])


def check(results):
    load = np.array(results.numbers("mpm_boundary_disc_load")) * results.column("time")[-1]
    weight, radius = np.hypot(*load), results.numbers("mpm_boundary_disc_radius")[0]
    arm = centre(results) - corner(results, "left")
    left, right = reaction(results, "left"), reaction(results, "right")
    off = np.max(np.abs(reaction(results, "disc") - load)) / weight
    return [common.completed(results),
            Quantity.near("place_off_the_middle_over_radius", (centre(results)[0] - MIDDLE) / radius, 0.0, absolute=PLACE),
            Quantity("imbalance_over_load", off, 0.0, BALANCE),
            Quantity.near("supports_over_load", (left + right)[1] / weight, 1.0, absolute=1e-8),
            Quantity.near("thrust_over_half_load", left[0] / (0.5 * weight), arm[0] / arm[1], relative=THRUST),
            Quantity("newton_mean", np.mean(results.column("newton")), 0.0, 6.0)]


def draw(results):
    """The disc on the blocks, and its way there."""
    import matplotlib.pyplot as plt
    from pictures.plane import draw_plane

    figure = plt.figure(figsize=(10.0, 4.6), layout="constrained")
    left, right = figure.subfigures(1, 2)
    state = results.state("last")
    stress = state["stress"][:, 1] / 1e3
    largest = np.max(np.abs(stress))
    axes, body = draw_plane(left, results, state, stress, ("coolwarm", -largest, largest), False)
    left.colorbar(body, ax=axes, shrink=0.8, label="vertical stress (kPa)")
    radius = results.numbers("mpm_boundary_disc_radius")[0]
    angle = np.linspace(0.0, 2.0 * np.pi, 200)
    for place, style in ((np.array(results.numbers("mpm_boundary_disc_center")), "--"), (centre(results), "-")):
        axes.plot(place[0] + radius * np.cos(angle), place[1] + radius * np.sin(angle), style, color="0.2")
    lower, upper = (results.numbers(f"mpm_grid_{end}") for end in ("lower", "upper"))
    axes.set(xlim=(lower[0], upper[0]), ylim=(lower[1], upper[1]), aspect="equal")

    axes = right.add_subplot()
    load = results.column("time")
    axes.plot(load, [-reaction(results, "disc", k)[1] / 1e3 for k in range(load.size)], "o-", label="disc, vertical")
    axes.plot(load, [reaction(results, "left", k)[0] / 1e3 for k in range(load.size)], "s-", label="left block, thrust")
    axes.set(xlabel="load factor", ylabel="force (kN/m)")
    axes.grid(alpha=0.3)
    axes.legend()
    return figure


if __name__ == "__main__":
    common.main(check, draw)
