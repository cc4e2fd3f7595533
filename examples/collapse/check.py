#!/usr/bin/env python3
"""Checks a run of the collapse for balance and sense, and prints the displacements of the two corner points.

--rows prints the lines of the README's table instead: one a corner and load factor.
"""
import sys
from pathlib import Path

import numpy as np

FOLDER = Path(__file__).resolve().parent
sys.path.insert(0, str(FOLDER.parent))
import common  # noqa: E402
from common import Quantity  # noqa: E402

WIDTH, HEIGHT = 8.0, 8.0  # m
DENSITY, GRAVITY = 1000.0, 10.0
KAPPA = 20e3  # Pa: sqrt(2 J2) of the Kirchhoff stress at yield
FACTORS = (0.25, 0.5, 0.75, 1.0)
CORNERS = ("top", "toe")
TABLE_SETTINGS = {"mpm_shape": "gimp", "mpm_body_block_points_per_cell": "3,3", "mpm_time_step": "0.025",
                  "mpm_time_end": "1"}
TABLE_REACH = 0.02  # m: the fall is a chain of yield events; a change of solver moves the top by millimetres


def corner(results, name, factor):
    """Displacement (x, y) of a corner point at a load factor."""
    step = np.flatnonzero(np.isclose(results.column("load"), factor))
    if not step.size:
        raise common.ResultsError(f"the run did not pass load factor {factor}")
    return [results.column(f"track_{name}_u{axis}")[step[0]] for axis in "xy"]


def cell_size(results):
    lower, upper = (results.numbers(f"mpm_grid_{end}")[0] for end in ("lower", "upper"))
    return (upper - lower) / common.cells(results)[0]


def kirchhoff_deviator(state):
    """sqrt(2 J2) of the Kirchhoff stress at each point."""
    tau = state["stress"] * np.linalg.det(state["F"].reshape(-1, 3, 3))[:, None]
    tau[:, :3] -= tau[:, :3].mean(axis=1)[:, None]
    return np.sqrt(np.sum(tau[:, :3] ** 2, axis=1) + 2.0 * np.sum(tau[:, 3:] ** 2, axis=1))


def check(results):
    quantities = [common.completed(results)]
    state, initial = results.state("last"), results.initial
    weight = DENSITY * GRAVITY * WIDTH * HEIGHT
    quantities.append(Quantity.near("mass", state["mass"].sum(), DENSITY * WIDTH * HEIGHT, relative=1e-9))
    quantities.append(Quantity.near("base_reaction", results.column("reaction_base_y")[-1], weight, relative=1e-6))
    quantities.append(Quantity("yield_excess", kirchhoff_deviator(state).max() / KAPPA - 1.0, None, 1e-6))
    quantities.append(Quantity("volume_change", state["volume"].sum() / initial["volume"].sum() - 1.0, -0.2, 0.0))
    table = common.read_table(FOLDER / "reference.csv")
    same = np.isclose(table["h"], cell_size(results)) & common.same_settings(results, TABLE_SETTINGS)
    for factor in FACTORS:
        row = np.flatnonzero(same & (table["factor"] == factor))
        for name in CORNERS:
            for axis, value in zip("xy", corner(results, name, factor)):
                column = f"{name}_u{axis}"
                label = f"{column}_at_{factor:g}"
                if row.size:
                    quantities.append(Quantity.near(label, value, table[column][row[0]], absolute=TABLE_REACH))
                else:
                    quantities.append(Quantity(label, value))
    return quantities


def draw(results):
    """The block at full weight, coloured by equivalent plastic strain."""
    import matplotlib.pyplot as plt
    from pictures.plane import draw_plane

    state = results.state("last")
    figure = plt.figure(figsize=(9.0, 4.6), layout="constrained")
    plastic = state["equivalent_plastic_strain"]
    axes, body = draw_plane(figure, results, state, plastic, ("viridis", 0.0, plastic.max()), True)
    figure.colorbar(body, ax=axes, shrink=0.8, label="equivalent plastic strain")
    for name, place in (("top", (WIDTH, HEIGHT)), ("toe", (WIDTH, 0.0))):
        displacement = corner(results, name, 1.0)
        axes.annotate("", xy=np.add(place, displacement), xytext=place, arrowprops={"arrowstyle": "->", "color": "0.3"})
    axes.set_title(f"collapse under self-weight, h = {cell_size(results):g} m", fontsize="medium")
    return figure


def print_rows(prefixes):
    """Rows of the README's table and of reference.csv for some runs."""
    print("h,factor," + ",".join(f"{name}_u{axis}" for name in CORNERS for axis in "xy"))
    for prefix in prefixes:
        results = common.Results(prefix)
        for factor in FACTORS:
            values = [value for name in CORNERS for value in corner(results, name, factor)]
            print(f"{cell_size(results):g},{factor:g}," + ",".join(f"{value:.4f}" for value in values))


if __name__ == "__main__":
    if len(sys.argv) > 2 and sys.argv[1] == "--rows":
        try:
            print_rows(sys.argv[2:])
        except common.ResultsError as error:
            sys.exit(f"check.py: {error}")
    else:
        common.main(check, draw)
