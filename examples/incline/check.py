#!/usr/bin/env python3
"""Compares the forces of the plane, and of the stop where there is one, with statics."""
import sys
from pathlib import Path

import numpy as np

FOLDER = Path(__file__).resolve().parent
sys.path.insert(0, str(FOLDER.parent))
import common  # noqa: E402
from common import Quantity  # noqa: E402

GRAVITY, DENSITY = 10.0, 2000.0  # m/s2, kg/m3
LENGTH, HEIGHT = 4.0, 2.0  # m, of the block
BALANCE = 1e-8  # of the weight
DEPTH = 1e-3  # of a cell, behind the boundaries
STRESS = 0.03  # mean error over the stress at the foot, where theory has an answer


def frame(results):
    """Unit vectors out of the plane and down it, and the slope's angle."""
    normal = np.array(results.numbers("mpm_boundary_slope_normal"))
    normal /= np.hypot(*normal)
    return normal, np.array([normal[1], -normal[0]]), np.arctan2(normal[0], normal[1])


def weight(results):
    return GRAVITY * np.sum(results.initial["mass"])


def force(results, name, row=-1):
    return np.array([results.column(f"reaction_{name}_{axis}")[row] for axis in "xy"])


def errors(results):
    """Differences of the stress across and along the slope, and of the shear, from theory, over the largest stresses.

    With nu = 0 and supports without friction: sigma_nn = -rho g cos (H - n), sigma_tt = -rho g sin t, no shear, with n the
    height over the slope and t the way from the upper end.
    """
    normal, down, angle = frame(results)
    state = results.state("last")
    place = results.initial["position0"] - np.array(results.numbers("mpm_boundary_slope_point"))
    stress = state["stress"][:, [[0, 3], [3, 1]]] / (GRAVITY * DENSITY * results.column("load")[-1])
    across, along = np.cos(angle) * HEIGHT, np.sin(angle) * LENGTH
    return ((np.einsum("i,pij,j->p", normal, stress, normal) + np.cos(angle) * (HEIGHT - place @ normal)) / across,
            (np.einsum("i,pij,j->p", down, stress, down) + np.sin(angle) * (place @ down)) / along,
            np.einsum("i,pij,j->p", normal, stress, down) / across)


def check(results):
    normal, down, angle = frame(results)
    total, factor = weight(results), results.column("load")[-1]
    slope = force(results, "slope") / (total * factor)
    stopped = "reaction_stop_x" in results.history
    quantities = [common.completed(results),
                  Quantity.near("weight", total, GRAVITY * DENSITY * LENGTH * HEIGHT, relative=0.01),
                  Quantity.near("slope_normal_over_weight", slope @ normal, np.cos(angle), absolute=BALANCE),
                  Quantity.near("slope_shear_over_weight", -(slope @ down), 0.0 if stopped else np.sin(angle),
                                absolute=BALANCE)]
    if stopped:
        stop = force(results, "stop") / (total * factor)
        quantities += [Quantity.near("stop_over_weight", -(stop @ down), np.sin(angle), absolute=BALANCE),
                       Quantity.near("stop_sideways_over_weight", stop @ normal, 0.0, absolute=BALANCE)]
    for name in ("slope", "stop") if stopped else ("slope",):
        depth = results.column(f"depth_{name}")[-1] / grid_cell(results)
        quantities.append(Quantity(f"{name}_depth_over_cell", depth, 0.0, DEPTH))
    if stopped and results.numbers("mpm_material_block_nu")[0] == 0.0:
        volume = results.state("last")["volume"]
        for name, error in zip(("across", "along", "shear"), errors(results)):
            quantities.append(Quantity(f"stress_{name}", np.average(np.abs(error), weights=volume), 0.0, STRESS))
    return quantities


def grid_cell(results):
    lower, upper = (np.array(results.numbers(f"mpm_grid_{end}")) for end in ("lower", "upper"))
    return np.min((upper - lower) / common.cells(results))


def draw(results):
    """The block on the plane, and the forces while the weight grows."""
    import matplotlib.pyplot as plt
    from pictures.plane import draw_plane

    normal, down, angle = frame(results)
    figure = plt.figure(figsize=(11.0, 4.6), layout="constrained")
    left, right = figure.subfigures(1, 2)
    state = results.state("last")
    across = np.einsum("i,pij,j->p", normal, state["stress"][:, [[0, 3], [3, 1]]], normal) / 1e3
    largest = np.max(np.abs(across))
    axes, body = draw_plane(left, results, state, across, ("coolwarm", -largest, largest), False)
    left.colorbar(body, ax=axes, shrink=0.8, label="stress across the plane (kPa)")
    foot = np.array(results.numbers("mpm_boundary_slope_point"))
    ends = np.array([foot - 1.0 * down, foot + 5.0 * down])
    axes.plot(ends[:, 0], ends[:, 1], color="0.2")

    axes = right.add_subplot()
    total, load = weight(results), results.column("load")
    forces = [("slope, across", "slope", normal, np.cos(angle), "tab:blue")]
    if "reaction_stop_x" in results.history:
        forces.append(("stop", "stop", -down, np.sin(angle), "tab:orange"))
    else:
        forces.append(("slope, along", "slope", -down, np.sin(angle), "tab:orange"))
    for label, name, direction, share, colour in forces:
        values = [force(results, name, row) @ direction / total for row in range(load.size)]
        axes.plot([0.0, 1.0], [0.0, share], color="0.3")
        axes.plot(load, values, "o", color=colour, label=label)
    axes.set(xlabel="load factor", ylabel="force over weight")
    axes.grid(alpha=0.3)
    axes.legend()
    return figure


if __name__ == "__main__":
    common.main(check, draw)
