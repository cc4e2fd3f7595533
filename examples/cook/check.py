#!/usr/bin/env python3
"""Compares a run of Cook's membrane with the displacements of its right edge that reference.py found."""
import sys
from pathlib import Path

import numpy as np

FOLDER = Path(__file__).resolve().parent
sys.path.insert(0, str(FOLDER.parent))
import common  # noqa: E402
from common import Quantity  # noqa: E402
from results import pressure  # noqa: E402

PLACES = {"foot": (48.0, 44.0), "middle": (48.0, 52.0), "corner": (48.0, 60.0)}
FORCE = 1.0  # N per metre, at load factor 1
REACH = 0.02  # relative, of the corner's displacement, for cells up to 1 m
FINE = 1.0  # m
TABLE_SETTINGS = {"mpm_load_shear_value": "0,0.0625", "mpm_material_panel_E": "70"}
SMALL = 0.02  # load factor up to which the strains are small


def cell_size(results):
    lower, upper = (results.numbers(f"mpm_grid_{end}")[0] for end in ("lower", "upper"))
    return (upper - lower) / common.cells(results)[0]


def with_mean(results):
    return results.option("mpm_stabilization_fbar", "false").lower() in ("true", "1", "yes", "on")


def edge_displacement(results, place):
    """Upward displacement of a place, carried there from the points nearest to it by F, over the load factor."""
    state, start = results.state("last"), results.initial["position0"]
    distance = np.linalg.norm(start - place, axis=1)
    nearest = np.flatnonzero(distance < distance.min() * (1.0 + 1e-6))
    gradient = state["F"].reshape(-1, 3, 3)[nearest, :2, :2] - np.eye(2)
    displacement = state["displacement"][nearest] + np.einsum("pij,pj->pi", gradient, place - start[nearest])
    return displacement[:, 1].mean() / results.column("load")[-1]


def reference(results):
    """The row of reference.csv for this run, or None."""
    table = common.read_table(FOLDER / "reference.csv")
    row = np.flatnonzero(np.isclose(table["nu"], results.numbers("mpm_material_panel_nu")[0], atol=1e-9))
    if not row.size or not common.same_settings(results, TABLE_SETTINGS) or results.column("load")[-1] > SMALL:
        return None
    return {name: table[name][row[0]] for name in PLACES}


def pressure_scatter(results):
    """How far points stand from the mean pressure of their cell, as a share of the largest such mean (both rms)."""
    values, start = pressure(results.state("last")["stress"]), results.initial["position0"]
    cell = np.unique(np.floor(start / cell_size(results)), axis=0, return_inverse=True)[1].ravel()
    means = np.bincount(cell, values) / np.bincount(cell)
    return np.sqrt(np.mean((values - means[cell]) ** 2) / np.mean(means[cell] ** 2))


def check(results):
    force = FORCE * results.column("load")[-1]
    quantities = [common.completed(results),
                  Quantity.near("clamp_over_load", -results.column("reaction_clamp_y")[-1] / force, 1.0, relative=1e-6)]
    exact = reference(results)
    judged = with_mean(results) and cell_size(results) <= FINE
    for name, place in PLACES.items():
        value = edge_displacement(results, place)
        if exact is None:
            quantities.append(Quantity(f"{name}_displacement", value))
            continue
        ratio = value / exact[name]
        quantities.append(Quantity.near(f"{name}_over_reference", ratio, 1.0, relative=REACH) if judged
                          else Quantity(f"{name}_over_reference", ratio))
    quantities.append(Quantity("pressure_scatter", pressure_scatter(results)))
    return quantities


def draw(results):
    """The membrane by pressure, and the upward displacement along its right edge beside the reference."""
    import matplotlib.pyplot as plt
    from pictures.plane import draw_plane

    figure = plt.figure(figsize=(11.0, 5.0), layout="constrained")
    left, right = figure.subfigures(1, 2, width_ratios=(1.3, 1.0))
    state, start, factor = results.state("last"), results.initial["position0"], results.column("load")[-1]
    values = pressure(state["stress"]) / factor
    largest = np.percentile(np.abs(values), 99.0)
    axes, body = draw_plane(left, results, state, values, ("coolwarm", -largest, largest), False)
    left.colorbar(body, ax=axes, shrink=0.8, label="pressure (Pa)", extend="both")
    axes.set_title(f"h = {cell_size(results):g} m, {results.option('mpm_shape')}, "
                   f"F-bar {'on' if with_mean(results) else 'off'}", fontsize="medium")

    axes = right.add_subplot()
    edge = np.flatnonzero(start[:, 0] > start[:, 0].max() - 1e-6)
    axes.plot(state["displacement"][edge, 1] / factor, start[edge, 1], ".", color="tab:blue", label="points")
    exact = reference(results)
    if exact is not None:
        values = np.array([exact[name] for name in PLACES])
        axes.errorbar(values, [place[1] for place in PLACES.values()], xerr=REACH * values, fmt="s", color="0.3",
                      markersize=8, fillstyle="none", capsize=4, label=f"finite elements, {100 * REACH:g} % each way")
    axes.set(xlabel="upward displacement of the right edge (m)", ylabel="y (m)")
    axes.grid(alpha=0.3)
    axes.legend(loc="lower right", bbox_to_anchor=(1.0, 0.06))
    return figure


if __name__ == "__main__":
    common.main(check, draw)
