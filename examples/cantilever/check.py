#!/usr/bin/env python3
"""Compares a run of the cantilever with the elastica and with the tip displacements of an independent program."""
import sys
from pathlib import Path

import numpy as np

FOLDER = Path(__file__).resolve().parent
sys.path.insert(0, str(FOLDER.parent))
import common  # noqa: E402
from common import Quantity  # noqa: E402

LENGTH = 10.0  # m
FULL_LOAD = 10.0  # alpha = F L^2/(E I) at load factor 1
TABLE_SETTINGS = {"mpm_shape": "gimp", "mpm_body_beam_points_per_cell": "6,6", "mpm_time_step": "0.02",
                  "mpm_time_end": "1", "mpm_material_beam_type": "hencky"}
TABLE_REACH = 1e-3  # of the length
PENALTY_REACH = 4e-3  # the same with the ghost penalty, which the table's program does not have
ELASTICA_REACH = 0.025  # relative, of v at full load
LOOSE_REACH = 0.05  # the same where no table applies
NODES, WEIGHTS = np.polynomial.legendre.leggauss(200)  # Gauss's rule on [-1, 1]


def legendre_integral(function, lower, upper):
    """Gauss's rule with 200 points."""
    return 0.5 * (upper - lower) * np.sum(WEIGHTS * function(0.5 * (upper + lower) + 0.5 * (upper - lower) * NODES))


def elastica(alpha):
    """u/L and v/L of the tip of an inextensible Euler-Bernoulli cantilever (Bisshopp & Drucker 1945).

    With the tip's slope p, k^2 = (1 + sin p)/2 and sin t = 1/(k sqrt 2):
    sqrt(alpha) = K(k) - F(t, k), v/L = 1 - 2 (E(k) - E(t, k))/sqrt(alpha), u/L = 1 - sqrt(2 sin p/alpha).
    """

    def parts(slope):
        k2 = 0.5 * (1.0 + np.sin(slope))
        start = np.arcsin(min(1.0, np.sqrt(0.5 / k2)))
        root = legendre_integral(lambda t: 1.0 / np.sqrt(1.0 - k2 * np.sin(t) ** 2), start, 0.5 * np.pi)
        second = legendre_integral(lambda t: np.sqrt(1.0 - k2 * np.sin(t) ** 2), start, 0.5 * np.pi)
        return root, second

    if alpha == 0.0:
        return 0.0, 0.0
    low, high = 0.0, 0.5 * np.pi
    for _ in range(60):
        slope = 0.5 * (low + high)
        low, high = (slope, high) if parts(slope)[0] < np.sqrt(alpha) else (low, slope)
    return 1.0 - np.sqrt(2.0 * np.sin(slope) / alpha), 1.0 - 2.0 * parts(slope)[1] / np.sqrt(alpha)


def curves(results):
    """alpha, u/L and v/L after every step."""
    alpha = FULL_LOAD * results.column("load")
    return alpha, -results.column("track_tip_ux") / LENGTH, -results.column("track_tip_uy") / LENGTH


def cell_size(results):
    lower, upper = (results.numbers(f"mpm_grid_{end}")[0] for end in ("lower", "upper"))
    return (upper - lower) / common.cells(results)[0]


def check(results):
    quantities = [common.completed(results)]
    alpha, u, v = curves(results)
    table = common.read_table(FOLDER / "reference.csv")
    rows = np.flatnonzero(np.isclose(table["h"], cell_size(results)))
    tabulated = rows.size > 0 and common.same_settings(results, TABLE_SETTINGS)
    table_reach = TABLE_REACH if results.option("mpm_stabilization_ghost") == "off" else PENALTY_REACH
    for row in rows if tabulated else ():
        step = np.flatnonzero(np.isclose(alpha, table["alpha"][row]))
        for name, values in (("u", u), ("v", v)):
            value = values[step[0]] if step.size else np.nan
            quantities.append(Quantity.near(f"{name}_at_{table['alpha'][row]:g}", value, table[name][row],
                                            absolute=table_reach))
    reach = ELASTICA_REACH if tabulated else LOOSE_REACH
    quantities.append(Quantity("v_over_elastica", v[-1] / elastica(alpha[-1])[1], 1.0 - reach, 1.0 + reach))
    return quantities


def draw(results):
    """The bent beam, and load against displacement beside the elastica."""
    import matplotlib.pyplot as plt
    from pictures.plane import draw_plane

    figure = plt.figure(figsize=(11.0, 4.8), layout="constrained")
    left, right = figure.subfigures(1, 2, width_ratios=(1.0, 1.0))
    state = results.state("last")
    values = state["stress"][:, 0] / 1e6
    largest = np.max(np.abs(values))
    axes, body = draw_plane(left, results, state, values, ("coolwarm", -largest, largest), True)
    left.colorbar(body, ax=axes, shrink=0.8, label="$\\sigma_{xx}$ (MPa)")
    shape = results.option("mpm_shape")
    axes.set_title(f"h = {cell_size(results):g} m, {len(values)} points, {shape}", fontsize="medium")

    axes = right.add_subplot()
    alpha, u, v = curves(results)
    loads = np.linspace(0.0, FULL_LOAD, 60)
    exact = np.array([elastica(load) for load in loads])
    lines = ((1, v, "tab:blue", "v/L, downwards"), (0, u, "tab:orange", "u/L, to the wall"))
    for column, values, colour, name in lines:
        axes.plot(exact[:, column], loads, color="0.3", zorder=3, label="elastica" if column else None)
        axes.plot(values, alpha, ".", color=colour, label=name)
    axes.set(xlabel="tip displacement over length", ylabel="$F L^2/(E I)$", xlim=(0.0, None), ylim=(0.0, None))
    axes.grid(alpha=0.3)
    axes.legend(loc="upper left")
    return figure


if __name__ == "__main__":
    common.main(check, draw)
