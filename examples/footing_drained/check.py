#!/usr/bin/env python3
"""Compares the bearing factor of a strip footing with the exact one: Nc, Nq or N_gamma, by the loads of the run."""
import sys
from pathlib import Path

import numpy as np

FOLDER = Path(__file__).resolve().parent
sys.path.insert(0, str(FOLDER.parent))
import common  # noqa: E402
from common import Quantity  # noqa: E402

WIDTH = 2.0  # m: B, between the outermost nodes of the footing
FINE = WIDTH / 16  # m
REACH = {"Nc": (0.05, 0.08), "Nq": (0.05, 0.08), "N_gamma": (0.10, 0.15)}  # relative: cells up to FINE, and larger ones
N_GAMMA = {"y": 7.653, "x,y": 14.75}  # phi = 30 degrees: smooth, rough
PLATEAU_REACH = 0.01  # growth of the load over the last tenth of the steps


def cell_size(results):
    lower, upper = (results.numbers(f"mpm_grid_{end}")[0] for end in ("lower", "upper"))
    return (upper - lower) / common.cells(results)[0]


def half_width(results):
    """To the last node of the footing and half a cell on: between that node and the next one the ground leaves the footing."""
    h = cell_size(results)
    return (np.floor(results.numbers("mpm_bc_footing_upper")[0] / h + 1e-9) + 0.5) * h


def parameter(results, name):
    return results.numbers(f"mpm_material_soil_{name}")[0]


def load(results):
    """Name of the factor, and the vertical force of the loads (N)."""
    lower, upper = (results.numbers(f"mpm_body_ground_{end}") for end in ("lower", "upper"))
    names = results.option("mpm_loads", "").split(",")
    if "weight" in names:
        unit_weight = -parameter(results, "density") * results.numbers("mpm_load_weight_value")[1]
        return "N_gamma", unit_weight * (upper[0] - lower[0]) * (upper[1] - lower[1])
    if "surcharge" in names:
        return "Nq", -results.numbers("mpm_load_surcharge_value")[1] * (upper[0] - lower[0])
    return "Nc", 0.0


def exact(results, name):
    """None where it is not known here."""
    phi = np.radians(parameter(results, "friction"))
    through = np.tan(0.25 * np.pi + 0.5 * phi) ** 2 * np.exp(np.pi * np.tan(phi))  # Nq
    if name == "N_gamma":
        return N_GAMMA[results.option("mpm_bc_footing_components")] if parameter(results, "friction") == 30.0 else None
    if name == "Nq":
        return through
    return (through - 1.0) / np.tan(phi) if phi > 0.0 else 2.0 + np.pi


def curve(results):
    """Settlement (m) and bearing factor, after every step of the footing."""
    name, _ = load(results)
    width, force, time = half_width(results), -results.column("reaction_footing_y"), results.column("time")
    rows = force != 0.0
    start = time[~rows][-1] if not rows.all() else 0.0
    ramp = np.array([[float(x) for x in pair.split(":")] for pair in results.option("mpm_bc_footing_ramp").split(",")])
    settlement = -results.numbers("mpm_bc_footing_value")[-1] * np.interp(time[rows] - start, *ramp.T)
    if name == "Nc":
        factor = force / (width * parameter(results, "cohesion"))
    elif name == "Nq":  # the surcharge acts under the footing, too
        factor = 1.0 - force / (width * results.numbers("mpm_load_surcharge_value")[1])
    else:
        weight = -parameter(results, "density") * results.numbers("mpm_load_weight_value")[1]
        factor = force / (weight * width**2)  # 2 q/(gamma B)
    return settlement, factor[rows]


def yield_excess(results):
    """Of the Kirchhoff stress over Mohr-Coulomb's planes, relative to the largest stress, at the worst point."""
    state, phi = results.state("last"), np.radians(parameter(results, "friction"))
    tau = state["stress"] * np.linalg.det(state["F"].reshape(-1, 3, 3))[:, None]
    centre, radius = 0.5 * (tau[:, 0] + tau[:, 1]), np.hypot(0.5 * (tau[:, 0] - tau[:, 1]), tau[:, 3])
    high, low = np.maximum(centre + radius, tau[:, 2]), np.minimum(centre - radius, tau[:, 2])
    excess = high - low + (high + low) * np.sin(phi) - 2.0 * parameter(results, "cohesion") * np.cos(phi)
    return excess.max() / np.abs(low).max()


def check(results):
    name, weight = load(results)
    _, factor = curve(results)
    base = results.column("reaction_base_y")[-1] / (weight - results.column("reaction_footing_y")[-1])
    growth = factor[-1] / factor[-1 - len(factor) // 10] - 1.0
    quantities = [common.completed(results), Quantity.near("base_over_loads", base, 1.0, relative=1e-6),
                  Quantity("yield_excess", yield_excess(results), None, 1e-6)]
    locks = results.option("mpm_stabilization_fbar") in ("plain", "false")
    if exact(results, name) is None or locks:
        return quantities + [Quantity(name, factor[-1]), Quantity("growth", growth)]
    reach = REACH[name][0 if cell_size(results) <= FINE + 1e-9 else 1]
    return quantities + [Quantity.near(name, factor[-1], exact(results, name), relative=reach),
                         Quantity("error", factor[-1] / exact(results, name) - 1.0),
                         Quantity("growth", growth, -PLATEAU_REACH, PLATEAU_REACH)]


def draw(results):
    """Where the soil flows, and the factor against settlement."""
    import matplotlib.pyplot as plt
    from pictures.plane import draw_plane

    figure = plt.figure(figsize=(11.0, 3.9), layout="constrained")
    left, right = figure.subfigures(1, 2, width_ratios=(1.6, 1.0))
    (settlement, factor), (name, _) = curve(results), load(results)
    state = results.state("last")
    slide = np.linalg.norm(state["displacement"], axis=1) / settlement[-1]
    axes, body = draw_plane(left, results, state, slide, ("viridis", 0.0, 2.5), False)
    left.colorbar(body, ax=axes, shrink=0.8, label="displacement over settlement")
    axes.add_patch(plt.Rectangle((0.0, 0.0), 0.5 * WIDTH, 0.3, color="0.4"))
    axes.set(xlim=(-0.1, 10.0), ylim=(-4.0, 0.5))
    axes.set_title(f"h = B/{WIDTH / cell_size(results):g}, friction = dilation = {parameter(results, 'friction'):g} degrees",
                   fontsize="medium")

    axes = right.add_subplot()
    if exact(results, name) is not None:
        axes.axhline(exact(results, name), color="0.3", label=f"exact, {exact(results, name):.4g}")
    axes.plot(1e3 * settlement, factor, ".-", color="tab:blue", label="Talus")
    axes.set(xlabel="settlement (mm)", ylabel={"Nc": "$N_c$", "Nq": "$N_q$", "N_gamma": r"$N_\gamma$"}[name],
             xlim=(0.0, None), ylim=(0.0, None))
    axes.grid(alpha=0.3)
    axes.legend(loc="lower right")
    return figure


if __name__ == "__main__":
    common.main(check, draw)
