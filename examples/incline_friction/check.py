#!/usr/bin/env python3
"""Compares the forces on a block on a rough incline with statics and Coulomb's law."""
import sys
from pathlib import Path

import numpy as np

FOLDER = Path(__file__).resolve().parent
sys.path.insert(0, str(FOLDER.parent))
import common  # noqa: E402
from common import Quantity  # noqa: E402

GRAVITY, DENSITY = 10.0, 2000.0  # m/s2, kg/m3
AREA = 8.0  # m2, of the block
FORCE = 1e-6  # of the force across the plane, or of the weight
LAG = 0.02  # of the way: how far the block's mean may stay behind the stop
NEWTON, ONE_STEP = 6.0, 10.0  # iterations a step; in one from nothing to the whole weight, near the limit of friction
STUCK = 1e-3  # m: what a block that sticks moves by its own deformation


def frame(results):
    """Unit vectors out of the plane and up it, and the slope's angle."""
    normal = np.array(results.numbers("mpm_boundary_slope_normal"))
    normal /= np.hypot(*normal)
    return normal, np.array([-normal[1], normal[0]]), np.arctan2(normal[0], normal[1])


def vector(results, name):
    return np.column_stack([results.column(f"{name}{axis}") for axis in "xy"])


def friction(results):
    return results.numbers("mpm_boundary_slope_friction")[0]


def moving(results):
    """Steps from the second on: in the first the block may still be taken along only in part."""
    return results.column("step") > 1.0


def check(results):
    normal, up, angle = frame(results)
    weight = GRAVITY * np.sum(results.initial["mass"]) * results.column("load")
    slope, moved = vector(results, "reaction_slope_"), vector(results, "track_block_u") @ up
    across, along = slope @ normal, slope @ up
    quantities = [common.completed(results),
                  Quantity.near("weight", weight[-1], GRAVITY * DENSITY * AREA, relative=0.01),
                  Quantity("slope_normal_error", np.max(np.abs(across / weight - np.cos(angle))), None, FORCE)]
    if "reaction_stop_x" in results.history:
        stop, way = vector(results, "reaction_stop_") @ up, vector_of(results, "motion") @ up
        pushed = np.cos(angle) * friction(results) + np.sin(angle)
        late = moving(results)
        quantities += [Quantity("friction_error", np.max(np.abs(along / across + friction(results))[late]), None, FORCE),
                       Quantity("stop_error", np.max(np.abs(stop / weight - pushed)[late]), None, FORCE),
                       Quantity.near("moved_over_way", moved[-1] / way, 1.0, absolute=LAG)]
    else:
        quantities += [Quantity("slope_shear_error", np.max(np.abs(along / weight - np.sin(angle))), None, FORCE),
                       Quantity("moved", abs(moved[-1]), None, STUCK)]
    steps = results.column("step").size
    return quantities + [Quantity("newton_a_step", np.sum(results.column("newton")) / steps, None, NEWTON if steps > 1 else ONE_STEP),
                         Quantity("cuts", np.sum(results.column("cuts")), None, 0.0)]


def vector_of(results, name):
    return np.array(results.numbers(f"mpm_boundary_stop_{name}"))


def draw(results):
    """The block at the end, and friction over the force across the plane while it moves."""
    import matplotlib.pyplot as plt
    from pictures.plane import draw_plane

    normal, up, angle = frame(results)
    figure = plt.figure(figsize=(11.0, 4.4), layout="constrained")
    left, right = figure.subfigures(1, 2)
    state = results.state("last")
    stress = state["stress"][:, [[0, 3], [3, 1]]] / 1e3
    shear = np.einsum("i,pij,j->p", normal, stress, up)
    largest = np.max(np.abs(shear))
    axes, body = draw_plane(left, results, state, shear, ("coolwarm", -largest, largest), False)
    left.colorbar(body, ax=axes, shrink=0.8, label="shear stress along the plane (kPa)")
    foot = np.array(results.numbers("mpm_boundary_slope_point"))
    ends = np.array([foot + 1.2 * up, foot - 5.0 * up])
    axes.plot(ends[:, 0], ends[:, 1], color="0.2")

    axes = right.add_subplot()
    slope, moved = vector(results, "reaction_slope_"), vector(results, "track_block_u") @ up
    sign = -1.0 if "reaction_stop_x" in results.history else 1.0
    axes.axhline(friction(results), color="0.3", label="Coulomb's coefficient")
    axes.axhline(np.tan(angle), color="0.6", ls="--", label="tangent of the slope's angle")
    axes.plot(moved, sign * (slope @ up) / (slope @ normal), "o", color="tab:blue", label="along over across the plane")
    axes.set(xlabel="way up the plane (m)", ylabel="force over force", ylim=(0.0, None))
    axes.grid(alpha=0.3)
    axes.legend()
    return figure


if __name__ == "__main__":
    common.main(check, draw)
