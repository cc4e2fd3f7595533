#!/usr/bin/env python3
"""Compares the pressure at the wall of an expanding cavity, a sphere or a slice of a cylinder, and the stress round it, with an
integration in r."""
import sys
from pathlib import Path

import numpy as np

FOLDER = Path(__file__).resolve().parent
RING = FOLDER.parent / "cavity_expansion"
sys.path[:0] = [str(FOLDER.parent), str(RING), str(FOLDER)]
import common  # noqa: E402
import reference as cylindrical  # noqa: E402  (of cavity_expansion)
import spherical  # noqa: E402
from common import Quantity  # noqa: E402

REACH = {"sphere": 0.1, "slice": 0.05}, 1e-3  # of pressures, relative: times (h/a0)^2, and no less than
STRESS_REACH = 0.02  # of stresses, mean over the volume
RADII = (1.05, 1.1, 1.2)
START = 100e3  # Pa
NAMES = ("radial", "round")


def shape(results):
    return "sphere" if results.option("mpm_boundary_cavity_type") == "sphere" else "slice"


def cell_size(results):
    lower, upper = (results.numbers(f"mpm_grid_{end}")[0] for end in ("lower", "upper"))
    return (upper - lower) / common.cells(results)[0]


def curves(results):
    """The wall's radius after every step, and pressures at the wall and the rim over that at the start. A sphere: force along the
    axis over pi r^2; a slice: along the radius over its circumference and height."""
    growth = "growth" if shape(results) == "sphere" else "motion"
    radius = 1.0 + results.numbers(f"mpm_boundary_cavity_{growth}")[0] * results.column("time")
    if shape(results) == "sphere":
        areas, axis = (np.pi * radius**2, np.pi * spherical.RIM**2), "y"
    else:
        height = results.numbers("mpm_grid_upper")[1]
        areas, axis = (2.0 * np.pi * height * radius, 2.0 * np.pi * height * cylindrical.RIM), "x"
    wall, rim = (abs(results.column(f"reaction_{name}_{axis}")) / area / START for name, area in zip(("cavity", "rim"), areas))
    return radius, wall, rim


def stresses(results):
    """At the end: r, and Cauchy's stresses over the pressure at the start, along the radius and round the axis."""
    state = results.state("last")
    place, stress = state["position"], state["stress"] / START
    if shape(results) == "slice":
        return place[:, 0], stress[:, [0, 2]].T
    radius = np.hypot(*place.T)
    s, c = (place / radius[:, None]).T
    xx, yy, zz, xy = stress[:, :4].T
    return radius, np.array([s * s * xx + c * c * yy + 2.0 * s * c * xy, zz])


def table(results):
    return common.read_table((FOLDER if shape(results) == "sphere" else RING) / "reference.csv")


def theory(results):
    """The stresses of the integration, on places from the wall to the rim."""
    formula = spherical if shape(results) == "sphere" else cylindrical
    values, radius = table(results), curves(results)[0][-1]
    rows = formula.profile(formula.rim_stress(radius, -np.interp(radius, values["radius"], values["rim"])))[::-1]
    return rows[:, 0], rows[:, 1:3].T


def check(results):
    quantities = [common.completed(results)]
    radius, wall, rim = curves(results)
    values = table(results)
    reach = max(REACH[0][shape(results)] * cell_size(results)**2, REACH[1])
    for place in RADII:
        if place < radius[-1] + 1e-9:
            quantities += [Quantity.near(f"{name}_at_{place:g}", np.interp(place, radius, found),
                                         np.interp(place, values["radius"], values[name]), relative=reach)
                           for name, found in (("wall", wall), ("rim", rim))]
    place, found = stresses(results)
    exact_place, exact = theory(results)
    volume = results.state("last")["volume"]
    for name, ours, line in zip(NAMES, found, exact):
        line = np.interp(place, exact_place, line)
        error = np.sum(volume * np.abs(ours - line)) / np.sum(volume * np.abs(line))
        quantities.append(Quantity(f"stress_{name}", error, None, STRESS_REACH))
    return quantities


def draw(results):
    """Pressure against radius, and the stresses at the end."""
    import matplotlib.pyplot as plt

    figure, (left, right) = plt.subplots(1, 2, figsize=(11.0, 4.4), layout="constrained")
    radius, wall, rim = curves(results)
    for name, found, colour in (("wall", wall, "tab:blue"), ("rim", rim, "tab:orange")):
        left.plot(radius, found, ".", color=colour, label=f"{name}, Talus")
    for folder, colour, label in ((FOLDER, "0.2", "sphere, integrated in r"), (RING, "0.6", "cylinder, integrated in r")):
        lines = common.read_table(folder / "reference.csv")
        for name in ("wall", "rim"):
            left.plot(np.append(1.0, lines["radius"]), np.append(1.0, lines[name]), color=colour, linewidth=1.0,
                      label=label if name == "wall" else None)
    left.set(xlabel="$a/a_0$", ylabel="pressure over $p_0$", xlim=(1.0, None), ylim=(0.0, None))
    place, found = stresses(results)
    exact_place, exact = theory(results)
    for name, ours, line, colour in zip(("r", "\\theta"), found, exact, ("tab:blue", "tab:green")):
        right.plot(place, -ours, ".", markersize=2.0, color=colour, label=f"$-\\sigma_{name}/p_0$")
        right.plot(exact_place, -line, color="0.2", linewidth=1.0)
    right.set(xlabel="$r/a_0$", ylabel="pressure over $p_0$", xlim=(1.0, 5.0), ylim=(0.0, 1.2 * wall[-1]),
              title=f"{shape(results)}, $a/a_0$ = {radius[-1]:.4g}, h = {cell_size(results):.4g} $a_0$")
    for axes in (left, right):
        axes.grid(alpha=0.3)
        axes.legend(markerscale=2.0)
    return figure


if __name__ == "__main__":
    common.main(check, draw)
