#!/usr/bin/env python3
"""Holds the resistance of a cone penetrometer in clay between published factors, and steady after ten radii."""
import sys
from pathlib import Path

import numpy as np

FOLDER = Path(__file__).resolve().parent
sys.path.insert(0, str(FOLDER.parent))
import common  # noqa: E402
from common import Quantity  # noqa: E402

LOW, HIGH = 10.0, 13.0  # N_kt of G/s_u = 100
WINDOW = 2.0  # radii: means of the resistance are taken over so much travel
DRIFT = 0.02  # of the resistance, from a window to the next
WAVES = 0.02  # of the resistance, standard deviation in the last window
BALANCE = 1e-5  # of the resistance
NEWTON = 6.5  # a step


def scale(results):
    """s_u, R, and the travel at the end, in radii."""
    radius = results.numbers("mpm_boundary_cone_radius")[0]
    return results.numbers("mpm_material_clay_cohesion")[0], radius, -results.numbers("mpm_boundary_cone_motion")[1] / radius


def factor(results):
    """Travel over R, and the resistance over s_u pi R^2."""
    strength, radius, way = scale(results)
    return results.column("time") * way, -results.column("reaction_cone_y") / (strength * np.pi * radius**2)


def published(results):
    """N_kt of a smooth cone, isotropic stress at the start: Teh and Houlsby (1991), Lu et al. (2004)."""
    modulus, nu = (results.numbers(f"mpm_material_clay_{name}")[0] for name in ("E", "nu"))
    rigidity = modulus / (2.0 * (1.0 + nu)) / scale(results)[0]
    return 4.0 / 3.0 * (1.0 + np.log(rigidity)) * (1.25 + rigidity / 2000.0), 3.4 + 1.6 * np.log(rigidity)


def check(results):
    travel, bearing = factor(results)
    last, before = (bearing[(travel > travel[-1] - far) & (travel <= travel[-1] - near)]
                    for near, far in ((0.0, WINDOW), (WINDOW, 2.0 * WINDOW)))
    cone, base = (results.column(f"reaction_{name}_y") for name in ("cone", "base"))
    return [common.completed(results),
            Quantity("balance", np.max(np.abs(cone + base)) / np.max(np.abs(cone)), None, BALANCE),
            Quantity("factor", np.mean(last), LOW, HIGH),
            Quantity("drift", abs(np.mean(last) / np.mean(before) - 1.0), None, DRIFT),
            Quantity("waves", np.std(last) / np.mean(last), None, WAVES),
            Quantity("newton_a_step", np.sum(results.column("newton")) / travel.size, None, NEWTON),
            Quantity("cuts", np.sum(results.column("cuts")), None, 0.0)]


def draw(results):
    """Plastic strain about the cone at the end, and the resistance over the travel."""
    import matplotlib.pyplot as plt
    from pictures.plane import draw_plane

    figure = plt.figure(figsize=(10.0, 5.0), layout="constrained")
    left, right = figure.subfigures(1, 2, width_ratios=(1.0, 1.2))
    state = results.state("last")
    strain = np.log10(np.maximum(state["equivalent_plastic_strain"], 1e-3))
    axes, body = draw_plane(left, results, state, strain, ("viridis", -3.0, 0.5), True)
    left.colorbar(body, ax=axes, shrink=0.8, label="log10 of the equivalent plastic strain")
    _, radius, way = scale(results)
    tip = np.array(results.numbers("mpm_boundary_cone_tip")) - [0.0, way * radius * results.column("time")[-1]]
    shoulder = tip + [radius, radius / np.tan(np.radians(30.0))]
    axes.add_patch(plt.Polygon([tip, shoulder, [radius, tip[1] + 20.0 * radius], [0.0, tip[1] + 20.0 * radius]], color="0.75"))
    axes.set(xlim=(0.0, 6.0 * radius), ylim=(tip[1] - 4.0 * radius, tip[1] + 8.0 * radius))

    axes = right.add_subplot()
    travel, bearing = factor(results)
    axes.plot(travel, bearing, color="tab:blue", label="resistance over $s_u \\pi R^2$")
    for value, style, name in zip(published(results), ("--", ":"), ("Teh and Houlsby, von Mises", "Lu et al., Tresca")):
        axes.axhline(value, color="0.4", linestyle=style, label=name)
    axes.set(xlabel="travel over R", ylim=(0.0, None))
    axes.grid(alpha=0.3)
    axes.legend()
    return figure


if __name__ == "__main__":
    common.main(check, draw)
