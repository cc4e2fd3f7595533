#!/usr/bin/env python3
"""Compares the pressure at the wall of an expanding cavity, and the stress round it, with an integration in r."""
import sys
from pathlib import Path

import numpy as np

FOLDER = Path(__file__).resolve().parent
sys.path.insert(0, str(FOLDER.parent))
import common  # noqa: E402
import reference  # noqa: E402
from common import Quantity  # noqa: E402

REACH = 0.15, 1e-3  # of pressures, relative: times (h/a0)^2, and no less than
STRESS_REACH = 0.02  # of stresses, on average
RADII = (1.05, 1.1, 1.2)
START = 100e3  # Pa, of points.py
SETTINGS = {"mpm_material_sand_E": "13e6", "mpm_material_sand_nu": "0.3", "mpm_material_sand_cohesion": "0",
            "mpm_material_sand_friction": "30", "mpm_material_sand_dilation": "10", "mpm_boundary_cavity_radius": "1",
            "mpm_boundary_rim_radius": "10"}


def cell_size(results):
    lower, upper = (results.numbers(f"mpm_grid_{end}")[0] for end in ("lower", "upper"))
    return (upper - lower) / common.cells(results)[0]


def curves(results):
    """The wall's radius after every step, and the pressures at the wall and the rim over that at the start: reactions along
    an axis are pressure times radius."""
    radius = 1.0 + results.numbers("mpm_boundary_cavity_growth")[0] * results.column("time")
    wall, rim = (sum(abs(results.column(f"reaction_{name}_{axis}")) for axis in "xy") / 2.0 / START
                 for name in ("cavity", "rim"))
    return radius, wall / radius, rim / reference.RIM


def stresses(results):
    """At the end: r, and Cauchy's stresses over the pressure at the start, radial, round and along z."""
    state = results.state("last")
    place, stress = state["position"], state["stress"] / START
    radius = np.hypot(*place.T)
    c, s = (place / radius[:, None]).T
    xx, yy, zz, xy = stress[:, :4].T
    return radius, np.array([c * c * xx + s * s * yy + 2.0 * c * s * xy, s * s * xx + c * c * yy - 2.0 * c * s * xy, zz])


def theory(results):
    """The same of the integration, on places from the wall to the rim."""
    table, radius = common.read_table(FOLDER / "reference.csv"), curves(results)[0][-1]
    rows = reference.profile(reference.rim_stress(radius, -np.interp(radius, table["radius"], table["rim"])))[::-1]
    return rows[:, 0], rows[:, 1:].T


def yield_excess(results):
    """By how much the Kirchhoff stress is outside the yield limit, over the pressure at the start, at the worst point."""
    state = results.state("last")
    xx, yy, zz, xy = (np.linalg.det(state["F"].reshape(-1, 3, 3)) * state["stress"][:, :4].T) / START
    middle, half = (xx + yy) / 2.0, np.hypot((xx - yy) / 2.0, xy)
    values = np.sort([middle - half, middle + half, zz], axis=0)
    return np.max(values[2] - values[0] + (values[2] + values[0]) * np.sin(reference.FRICTION))


def check(results):
    quantities = [common.completed(results), Quantity("yield_excess", yield_excess(results), None, 1e-6)]
    if not common.same_settings(results, SETTINGS):
        return quantities
    radius, wall, rim = curves(results)
    table = common.read_table(FOLDER / "reference.csv")
    reach = max(REACH[0] * cell_size(results)**2, REACH[1])
    for place in RADII:
        if place < radius[-1] + 1e-9:
            quantities += [Quantity.near(f"{name}_at_{place:g}", np.interp(place, radius, values),
                                         np.interp(place, table["radius"], table[name]), relative=reach)
                           for name, values in (("wall", wall), ("rim", rim))]
    difference = results.column("reaction_cavity_x")[-1] / results.column("reaction_cavity_y")[-1]
    quantities.append(Quantity.near("x_over_y", difference, 1.0, absolute=1e-3))
    place, found = stresses(results)
    exact_place, exact = theory(results)
    for name, values, line in zip(("radial", "round", "along"), found, exact):
        error = np.mean(np.abs(values - np.interp(place, exact_place, line))) / np.mean(np.abs(line))
        quantities.append(Quantity(f"stress_{name}", error, None, STRESS_REACH))
    return quantities


def draw(results):
    """Pressure against radius, and the stresses at the end."""
    import matplotlib.pyplot as plt

    figure, (left, right) = plt.subplots(1, 2, figsize=(11.0, 4.4), layout="constrained")
    table = common.read_table(FOLDER / "reference.csv")
    radius, wall, rim = curves(results)
    for name, values, colour in (("wall", wall, "tab:blue"), ("rim", rim, "tab:orange")):
        left.plot(radius, values, ".", color=colour, label=f"{name}, Talus")
        left.plot(np.append(1.0, table["radius"]), np.append(1.0, table[name]), color="0.3", linewidth=1.0)
    left.set(xlabel="$a/a_0$", ylabel="pressure over $p_0$", xlim=(1.0, None), ylim=(0.0, None))
    place, found = stresses(results)
    exact_place, exact = theory(results)
    for name, values, line, colour in zip(("r", "\\theta", "z"), found, exact, ("tab:blue", "tab:green", "tab:red")):
        right.plot(place, -values, ".", markersize=2.0, color=colour, label=f"$-\\sigma_{name}/p_0$")
        right.plot(exact_place, -line, color="0.2", linewidth=1.0)
    right.set(xlabel="$r/a_0$", ylabel="pressure over $p_0$", xlim=(1.0, reference.RIM), ylim=(0.0, 1.5 * wall[-1]),
              title=f"$a/a_0$ = {radius[-1]:.4g}, h = {cell_size(results):.4g} $a_0$")
    left.plot([], [], color="0.3", linewidth=1.0, label="integrated in r")
    for axes in (left, right):
        axes.grid(alpha=0.3)
        axes.legend(markerscale=2.0)
    return figure


if __name__ == "__main__":
    common.main(check, draw)
