#!/usr/bin/env python3
"""Compares the pressure under the footing with Prandtl's limit, and with finite elements on the way there."""
import sys
from pathlib import Path

import numpy as np

FOLDER = Path(__file__).resolve().parent
sys.path.insert(0, str(FOLDER.parent))
import common  # noqa: E402
from common import Quantity  # noqa: E402
from results import von_mises  # noqa: E402

LIMIT = 2.0 + np.pi
REACH = {"fine": 0.05, "coarse": 0.08}  # relative, of the limit and the table: cells up to FINE, and larger ones
FINE = 0.125  # m
PLATEAU_REACH = 0.03  # growth of the pressure over the last quarter of the settlement: 2.1 % with linear, whose points cross cells
TABLE_STIFFNESS = 10e6  # Pa: E of the table; settlements scale with 1/E while they are small


def cell_size(results):
    lower, upper = (results.numbers(f"mpm_grid_{end}")[0] for end in ("lower", "upper"))
    return (upper - lower) / common.cells(results)[0]


def with_mean(results):
    """F-bar acts unless it is switched off: the clay flows."""
    return results.option("mpm_stabilization_fbar", "auto").lower() not in ("false", "0", "no", "off")


def half_width(results):
    """To the last held node and half a cell on: between that node and the next one the ground leaves the footing."""
    h = cell_size(results)
    return (np.floor(results.numbers("mpm_bc_footing_upper")[0] / h + 1e-9) + 0.5) * h


def curve(results):
    """Settlement (m) and mean pressure over the shear strength, after every step."""
    strength = results.numbers("mpm_material_clay_yield_stress")[0] / np.sqrt(3.0)
    settlement = -results.numbers("mpm_bc_footing_value")[-1] * results.column("time")
    return settlement, -results.column("reaction_footing_y") / (half_width(results) * strength)


def table_curve(results):
    """The same of reference.csv: settlements for this run's E, and pressures, or two empty arrays."""
    table = common.read_table(FOLDER / "reference.csv")
    rows = np.isclose(table["h"], cell_size(results))
    if not common.same_settings(results, {"mpm_material_clay_nu": "0.49", "mpm_bc_footing_upper": "1,1"}):
        rows[:] = False
    scale = TABLE_STIFFNESS / results.numbers("mpm_material_clay_E")[0]
    return table["settlement"][rows] * scale, table["factor"][rows]


def yield_excess(results):
    """By how much the Kirchhoff stress is outside the yield limit, relatively, at the worst point."""
    state = results.state("last")
    tau = von_mises(state["stress"]) * np.linalg.det(state["F"].reshape(-1, 3, 3))
    return tau.max() / results.numbers("mpm_material_clay_yield_stress")[0] - 1.0


def check(results):
    settlement, factor = curve(results)
    balance = results.column("reaction_base_y")[-1] / -results.column("reaction_footing_y")[-1]
    quantities = [common.completed(results), Quantity.near("base_over_footing", balance, 1.0, relative=1e-6),
                  Quantity("yield_excess", yield_excess(results), None, 1e-6)]
    limit, growth = factor[-1], factor[-1] / np.interp(0.75 * settlement[-1], settlement, factor) - 1.0
    if not with_mean(results):  # it locks, by more the finer the material keeps its volume
        return quantities + [Quantity("bearing_factor", limit), Quantity("growth", growth)]
    reach = REACH["fine" if cell_size(results) <= FINE + 1e-9 else "coarse"]
    quantities += [Quantity.near("bearing_factor", limit, LIMIT, relative=reach),
                   Quantity("growth", growth, -PLATEAU_REACH, PLATEAU_REACH)]
    for place, value in zip(*table_curve(results)):
        if place <= settlement[-1] * (1.0 + 1e-9):
            quantities.append(Quantity.near(f"factor_at_{place:g}", np.interp(place, settlement, factor), value,
                                            relative=reach))
    return quantities


def draw(results):
    """Where the clay flows, and pressure against settlement."""
    import matplotlib.pyplot as plt
    from pictures.plane import draw_plane

    figure = plt.figure(figsize=(11.0, 4.6), layout="constrained")
    left, right = figure.subfigures(1, 2, width_ratios=(1.25, 1.0))
    state, settlement = results.state("last"), curve(results)[0][-1]
    slide = np.linalg.norm(state["displacement"], axis=1) / settlement
    axes, body = draw_plane(left, results, state, slide, ("viridis", 0.0, 1.2), False)
    left.colorbar(body, ax=axes, shrink=0.8, label="displacement over settlement")
    axes.add_patch(plt.Rectangle((0.0, 0.0), 1.0, 0.3, color="0.4"))
    axes.set(xlim=(-0.1, 4.0), ylim=(-2.5, 0.5))
    axes.set_title(f"h = {cell_size(results):g} m, {results.option('mpm_shape')}, "
                   f"F-bar {'on' if with_mean(results) else 'off'}", fontsize="medium")

    axes = right.add_subplot()
    axes.axhline(LIMIT, color="0.3", label="$2 + \\pi$")
    place, value = table_curve(results)
    axes.plot(place, value, "s", color="0.3", fillstyle="none", label="finite elements")
    axes.plot(*curve(results), ".-", color="tab:blue", label="Talus")
    axes.set(xlabel="settlement (m)", ylabel="$q/s_u$", xlim=(0.0, None), ylim=(0.0, None))
    axes.grid(alpha=0.3)
    axes.legend(loc="lower right")
    return figure


if __name__ == "__main__":
    common.main(check, draw)
