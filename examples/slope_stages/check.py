#!/usr/bin/env python3
"""A slope in stages: the geostatic state is in equilibrium, forces balance in every stage, the trench's floor rises, the crest settles."""
import sys
from pathlib import Path

import numpy as np

FOLDER = Path(__file__).resolve().parent
sys.path.insert(0, str(FOLDER.parent))
import common  # noqa: E402
from common import Quantity  # noqa: E402

HEIGHT = 10.0  # m
REST, HOLD, DIG, LOAD = 1, 2, 3, 4
REACH = 0.15  # relative, of the table: it was made with cells of a quarter of a metre


def last_row(results, stage):
    return np.flatnonzero(results.column("stage") == stage)[-1]


def weight(results, stage):
    """Of the points that are there at the end of a stage, N."""
    step = int(results.column("step")[last_row(results, stage)])
    return -results.numbers("mpm_load_weight_value")[1] * results.state(step)["mass"].sum()


def crest_load(results):
    lower, upper = (results.numbers(f"mpm_load_crest_{end}")[0] for end in ("lower", "upper"))
    return -results.numbers("mpm_load_crest_value")[1] * (upper - lower)


def yield_excess(results):
    """Of the Kirchhoff stress over the cone, relative to the cohesion's part, at the worst point."""
    state = results.state("last")
    angle = np.tan(np.radians(results.numbers("mpm_material_soil_friction")[0]))
    xi = 3.0 / np.sqrt(9.0 + 12.0 * angle ** 2)
    tau = state["stress"] * np.linalg.det(state["F"].reshape(-1, 3, 3))[:, None]
    mean = tau[:, :3].mean(axis=1)
    j2 = 0.5 * ((tau[:, :3] - mean[:, None]) ** 2).sum(axis=1) + (tau[:, 3:] ** 2).sum(axis=1)
    strength = xi * results.numbers("mpm_material_soil_cohesion")[0]
    return ((np.sqrt(j2) + xi * angle * mean) / strength).max() - 1.0


def check(results):
    base = results.column("reaction_base_y")
    held = results.state(int(results.column("step")[last_row(results, HOLD)]))
    moved = np.linalg.norm(held["displacement"], axis=1).max() / HEIGHT
    quantities = [common.completed(results), Quantity("moves_at_rest_over_height", moved, None, 1e-6),
                  Quantity("yield_excess", yield_excess(results), None, 1e-6)]
    for name, stage, load in (("rest", REST, 0.0), ("dig", DIG, 0.0), ("load", LOAD, crest_load(results))):
        quantities.append(Quantity.near(f"base_over_weight_{name}", base[last_row(results, stage)]
                                        / (weight(results, stage) + load), 1.0, absolute=1e-6))
    table = common.read_table(FOLDER / "reference.csv")
    for name, stage in (("floor_uy", DIG), ("side_ux", DIG), ("crest_uy", LOAD)):
        value = results.column(f"track_{name}")[last_row(results, stage)]
        quantities.append(Quantity.near(name, value, table[name][0], relative=REACH))
    return quantities


def draw(results):
    """Where the ground moves, in the last two stages."""
    import matplotlib.pyplot as plt
    from pictures.plane import draw_body

    figure, panels = plt.subplots(2, 1, figsize=(9.0, 8.4), layout="constrained")
    for axes, stage, title in zip(panels, (DIG, LOAD), ("after the trench", "after the load on the crest")):
        state = results.state(int(results.column("step")[last_row(results, stage)]))
        size = 1e3 * np.linalg.norm(state["displacement"], axis=1)
        dots = draw_body(axes, results, state, size)
        figure.colorbar(dots, ax=axes, label="displacement (mm)")
        axes.set(title=title, aspect="equal", xlabel="x (m)", ylabel="y (m)")
    return figure


if __name__ == "__main__":
    common.main(check, draw)
