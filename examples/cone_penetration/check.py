#!/usr/bin/env python3
"""Holds the resistance of a penetrometer in clay, in plane strain, between the bounds that theory gives it."""
import sys
from pathlib import Path

import numpy as np

FOLDER = Path(__file__).resolve().parent
sys.path.insert(0, str(FOLDER.parent))
import common  # noqa: E402
from common import Quantity  # noqa: E402

STEADY = 0.5  # diameters of travel: from here on
DEEP_STRIP = 7.5  # a strip footing at depth: Skempton (1951)
BALANCE = 1e-5  # of the resistance
NOISE = 0.4  # standard deviation over the mean, times h/D
DRIFT = 0.4  # from the first half of the steady part to the second, times h/D
NEWTON = 6.0  # a step


def scale(results):
    """s_u D, D, the grid's cell and the travel a time."""
    diameter = 2.0 * results.numbers("mpm_boundary_cone_radius")[0]
    strength = results.numbers("mpm_material_clay_yield_stress")[0] / np.sqrt(3.0)
    lower, upper = (np.array(results.numbers(f"mpm_grid_{end}")) for end in ("lower", "upper"))
    cell = np.max((upper - lower) / common.cells(results))
    return strength * diameter, diameter, cell, -results.numbers("mpm_boundary_cone_motion")[1]


def cavity(results):
    """Limit pressure of a cylindrical cavity over s_u."""
    modulus, nu = (results.numbers(f"mpm_material_clay_{name}")[0] for name in ("E", "nu"))
    strength = results.numbers("mpm_material_clay_yield_stress")[0] / np.sqrt(3.0)
    return 1.0 + np.log(modulus / (2.0 * (1.0 + nu)) / strength)


def factor(results):
    """Travel over D, and the resistance of both halves over s_u D."""
    unit, diameter, _, way = scale(results)
    return results.column("time") * way / diameter, -2.0 * results.column("reaction_cone_y") / unit


def check(results):
    _, diameter, cell, _ = scale(results)
    travel, bearing = factor(results)
    cone, base = (results.column(f"reaction_{name}_y") for name in ("cone", "base"))
    steady = bearing[travel >= STEADY]
    half = steady.size // 2
    mean = np.mean(steady)
    widened = mean / (1.0 + cell / diameter)
    steps = results.column("step").size
    return [common.completed(results),
            Quantity("balance", np.max(np.abs(cone + base)) / np.max(np.abs(cone)), None, BALANCE),
            Quantity("bearing_factor", mean, cavity(results), DEEP_STRIP),
            Quantity("factor_of_D_plus_h", widened, cavity(results), DEEP_STRIP),
            Quantity("noise", np.std(steady) / mean, None, NOISE * cell / diameter),
            Quantity("drift", abs(np.mean(steady[half:]) / np.mean(steady[:half]) - 1.0), None, DRIFT * cell / diameter),
            Quantity("newton_a_step", np.sum(results.column("newton")) / steps, None, NEWTON),
            Quantity("cuts", np.sum(results.column("cuts")), None, 0.0)]


def draw(results):
    """Plastic strain about the tip at the end, and the resistance over the travel."""
    import matplotlib.pyplot as plt
    from pictures.plane import draw_plane

    figure = plt.figure(figsize=(10.0, 5.0), layout="constrained")
    left, right = figure.subfigures(1, 2, width_ratios=(1.0, 1.2))
    state = results.state("last")
    strain = np.log10(np.maximum(state["equivalent_plastic_strain"], 1e-3))
    axes, body = draw_plane(left, results, state, strain, ("viridis", -3.0, 0.5), True)
    left.colorbar(body, ax=axes, shrink=0.8, label="log10 of the equivalent plastic strain")
    _, diameter, _, way = scale(results)
    tip = np.array(results.numbers("mpm_boundary_cone_tip")) - [0.0, way * results.column("time")[-1]]
    shoulder = tip + [0.5 * diameter, 0.5 * diameter / np.tan(np.radians(30.0))]
    axes.add_patch(plt.Polygon([tip, shoulder, [shoulder[0], tip[1] + 6.0], [0.0, tip[1] + 6.0]], color="0.75"))
    axes.set(xlim=(0.0, 3.0), ylim=(tip[1] - 2.0, tip[1] + 4.0))

    axes = right.add_subplot()
    travel, bearing = factor(results)
    axes.plot(travel, bearing, color="tab:blue", label="resistance over $s_u D$")
    axes.axhline(cavity(results), color="0.4", linestyle="--", label="cylindrical cavity, $1 + \\ln G/s_u$")
    axes.axhline(DEEP_STRIP, color="0.4", linestyle=":", label="deep strip (Skempton)")
    axes.set(xlabel="travel over D", ylim=(0.0, None))
    axes.grid(alpha=0.3)
    axes.legend()
    return figure


if __name__ == "__main__":
    common.main(check, draw)
