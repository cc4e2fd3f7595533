#!/usr/bin/env python3
"""Checks balance, lift-off and force of a smooth rigid footing that is pressed into an elastic block and lifted again."""
import sys
from pathlib import Path

import numpy as np

FOLDER = Path(__file__).resolve().parent
sys.path.insert(0, str(FOLDER.parent))
import common  # noqa: E402
from common import Quantity  # noqa: E402

BALANCE = (1e-8, 1e-8, 1e-8)  # of the largest force
REVERSIBLE = 0.04  # relative to the largest force: elastic ground gives back what it took, but for the points' scatter
SYMMETRY = 0.02  # of the force: along x and y the same happens, but for faces as far from one side as from the other
SIDE = 0.25  # of the force: the ground that stands beside the footing is lower than the footing is wide
FORCE_REACH = 0.01  # of reference.csv
SETTINGS = {"mpm_grid_upper": "5,5,6", "mpm_material_soil_type": "neo_hookean", "mpm_material_soil_E": "10e6",
            "mpm_material_soil_nu": "0.3", "mpm_boundary_footing_motion": "0,0,-0.5", "mpm_shape": "gimp",
            "mpm_boundary_footing_upper": "1,1,6", "mpm_body_ground_points_per_cell": "3,3,3"}


def depths(results):
    """Settlement of the footing (m) after every step; negative off the ground."""
    ramp = [[float(part) for part in pair.split(":")] for pair in results.option("mpm_boundary_footing_ramp").split(",")]
    time, factor = np.array(ramp).T
    return -results.numbers("mpm_boundary_footing_motion")[2] * np.interp(results.column("time"), time, factor)


def layer_stiffness(results):
    """A rigid disc of the footing's area on a layer of depth H on rock: 4 G R/(1 - nu) (1 + 1.28 R/H); a quarter of it, N/m."""
    E, nu = (results.numbers(f"mpm_material_soil_{name}")[0] for name in ("E", "nu"))
    G = E / (2.0 * (1.0 + nu))
    if results.option("mpm_physics") == "poro":
        nu = 0.5  # water does not change its volume
    side, H = results.numbers("mpm_boundary_footing_upper")[0], results.numbers("mpm_body_ground_upper")[2]
    R = np.sqrt(4.0 * side**2 / np.pi)
    return G * R / (1.0 - nu) * (1.0 + 1.28 * R / H)


def reference(results):
    """The force at the end of loading from the table, N, for this cell size and penalty; None where it has none."""
    if results.option("mpm_physics") != "solid" or not common.same_settings(results, SETTINGS):
        return None
    table = common.read_table(FOLDER / "reference.csv")
    h = 5.0 / common.cells(results)[0]
    penalty = float(results.option("mpm_boundary_footing_penalty", "500"))
    rows = np.isclose(table["h"], h) & np.isclose(table["penalty"], penalty)
    return table["force"][rows][0] if rows.any() else None


def check(results):
    depth, force = depths(results), -results.column("reaction_footing_z")
    column, largest = results.column, force.max()
    turn = int(np.argmax(depth))
    rest = [sum(column(name) for name in results.history if name.startswith("reaction_") and name.endswith(f"_{axis}"))
            for axis in "xyz"]
    quantities = [common.completed(results)]
    quantities += [Quantity(f"unbalanced_{axis}", np.abs(part).max() / largest, None, bound)
                   for axis, part, bound in zip("xyz", rest, BALANCE)]
    side = np.array([column("reaction_footing_x"), column("reaction_footing_y")])
    widest = 1.06 * (1.0 + 0.5 * 5.0 / common.cells(results)[0])  # rollers, and less than half a cell beyond the edge, see README.md
    quantities += [Quantity("tension", max(0.0, -force.min(), -side.min()) / largest, None, 1e-12),
                   Quantity("side", side.max() / largest, None, SIDE),
                   Quantity("unlike_sides", np.abs(side[0] - side[1]).max() / largest, None, SYMMETRY),
                   Quantity("stiffness_over_layer", force[0] / depth[0] / layer_stiffness(results), 0.95, widest),
                   Quantity("newton_per_step", column("newton").mean(), None, 6.0),
                   Quantity("cuts", column("cuts").sum(), None, 0.0)]
    value = reference(results)
    if value is not None and np.isclose(depth[turn], 0.5):
        quantities.append(Quantity.near("force_at_0.5_m", force[turn], value, relative=FORCE_REACH))
    else:
        quantities.append(Quantity("largest_force", largest))
    if (depth < 0.0).any():
        up = (np.arange(len(depth)) > turn) & (depth > 0.0)
        back = np.interp(depth[up], np.r_[0.0, depth[: turn + 1]], np.r_[0.0, force[: turn + 1]])
        quantities += [Quantity("off_the_ground", np.abs(force[depth < 0.0]).max() / largest, None, 0.0),
                       Quantity("not_given_back", np.abs(force[up] - back).max() / largest, None, REVERSIBLE)]
    return quantities


def draw(results):
    """A section along the plane of symmetry at the deepest written state, and force against settlement."""
    import matplotlib.pyplot as plt

    depth, force = depths(results), -results.column("reaction_footing_z")
    step = max(results.steps, key=lambda step: depth[step - 1] if step else -1.0)
    state = results.state(step)
    place, sigma = state["position"], state["stress"]
    near = place[:, 1] < place[:, 1].min() * 1.5
    figure, (left, right) = plt.subplots(1, 2, figsize=(11.0, 4.6), layout="constrained")
    points = left.scatter(place[near, 0], place[near, 2], c=-sigma[near, 2] / 1e6, s=24, cmap="viridis")
    left.add_patch(plt.Rectangle((0.0, 5.0 - depth[step - 1]), 1.0, 0.5, color="0.4"))
    figure.colorbar(points, ax=left, label="vertical pressure (MPa)")
    left.set(aspect="equal", xlabel="x (m)", ylabel="z (m)")
    turn = int(np.argmax(depth))
    right.plot(np.r_[0.0, depth[: turn + 1]], np.r_[0.0, force[: turn + 1]] / 1e6, ".-", label="down")
    right.plot(depth[turn:], force[turn:] / 1e6, ".--", label="up")
    right.plot([0.0, 0.2], [0.0, 0.2 * layer_stiffness(results) / 1e6], color="0.3", label="rigid disc on a layer, small strain")
    right.set(xlabel="settlement (m)", ylabel="force on the quarter (MN)")
    right.grid(alpha=0.3)
    right.legend(loc="upper left")
    return figure


if __name__ == "__main__":
    common.main(check, draw)
