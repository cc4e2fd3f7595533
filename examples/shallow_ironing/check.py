#!/usr/bin/env python3
"""Holds the forces on a die that slides over an elastic slab against equilibrium and Coulomb's law."""
import sys
from pathlib import Path

import numpy as np

FOLDER = Path(__file__).resolve().parent
sys.path.insert(0, str(FOLDER.parent))
import common  # noqa: E402
from common import Quantity  # noqa: E402

SLIDES = 1.4  # s: the whole contact slides from here on
BALANCE = 1e-6  # of the die's force
RATIO = 0.02  # mean of force along over force down, from Coulomb's coefficient
SPREAD = 0.035  # mean cosine of the contact's slope: how far below one
NOISE = 0.1  # standard deviation of the force along while it slides, over its mean, times h/0.25 m


def vector(results, name):
    return np.column_stack([results.column(f"reaction_{name}_{axis}") for axis in "xy"])


def cell(results):
    lower, upper = (np.array(results.numbers(f"mpm_grid_{end}")) for end in ("lower", "upper"))
    return np.max((upper - lower) / common.cells(results))


def friction(results):
    return results.numbers("mpm_boundary_die_friction")[0]


def check(results):
    die, base, mu = vector(results, "die"), vector(results, "base"), friction(results)
    radius = results.numbers("mpm_boundary_die_radius")[0]
    size = np.hypot(*die.T)
    unbalanced = np.hypot(*(die + base).T) / np.max(size)
    slides = results.column("time") >= SLIDES
    ratio = np.abs(die[:, 0] / np.where(die[:, 1] == 0.0, np.inf, die[:, 1]))
    # Every pressure has its friction beside it, mu times as large and at a right angle: the moment about the die's middle is
    # mu R int p, and the whole force sqrt(1 + mu^2) |int p n|.
    turn = np.abs(results.column("moment_die_z"))[slides] / (radius * size[slides]) * np.sqrt(1.0 + mu**2) / mu
    along = np.abs(die[slides, 0])
    steps = results.column("step").size
    return [common.completed(results),
            Quantity("balance", np.max(unbalanced), None, BALANCE),
            Quantity.near("force_ratio", np.mean(ratio[slides]), mu, absolute=RATIO),
            Quantity("moment_smallest", np.min(turn), 1.0, 1.0 + SPREAD),
            Quantity("moment_largest", np.max(turn), 1.0, 1.0 + SPREAD),
            Quantity("noise", np.std(along) / np.mean(along), None, NOISE * cell(results) / 0.25),
            Quantity("newton_a_step", np.sum(results.column("newton")) / steps, None, 6.0),
            Quantity("cuts", np.sum(results.column("cuts")), None, 0.0)]


def draw(results):
    """The slab under the die at the end, and the forces over time."""
    import matplotlib.pyplot as plt
    from pictures.plane import draw_plane

    figure = plt.figure(figsize=(12.0, 3.9), layout="constrained")
    left, right = figure.subfigures(1, 2, width_ratios=(1.5, 1.0))
    state = results.state("last")
    pressure = -state["stress"][:, 1] / 1e3
    axes, body = draw_plane(left, results, state, pressure, ("viridis", 0.0, np.percentile(pressure, 99.8)), True)
    left.colorbar(body, ax=axes, shrink=0.8, label="vertical pressure (kPa)")
    table = common.read_table(FOLDER / "motion.csv")
    center = np.array(results.numbers("mpm_boundary_die_center"))
    center += [np.interp(results.column("time")[-1], table["time"], table[name]) for name in ("ux", "uy")]
    axes.add_patch(plt.Circle(center, results.numbers("mpm_boundary_die_radius")[0], fill=False, color="0.2"))
    axes.set(ylim=(-0.1, center[1] + 1.2))

    axes = right.add_subplot()
    die, time = vector(results, "die") / 1e3, results.column("time")
    axes.plot(time, np.abs(die[:, 1]), color="tab:blue", label="down")
    axes.plot(time, np.abs(die[:, 0]), color="tab:orange", label="along")
    axes.plot(time, friction(results) * np.abs(die[:, 1]), "--", color="0.4", label="0.3 of the force down")
    axes.set(xlabel="time (s)", ylabel="force on the die (kN/m)", ylim=(0.0, None))
    axes.grid(alpha=0.3)
    axes.legend()
    return figure


if __name__ == "__main__":
    common.main(check, draw)
