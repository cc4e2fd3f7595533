#!/usr/bin/env python3
"""Compares a rigid cylinder on a half-space, or a rigid sphere on a layer, with the theory of elastic contact."""
import sys
from pathlib import Path

import numpy as np

FOLDER = Path(__file__).resolve().parent
sys.path.insert(0, str(FOLDER.parent))
import common  # noqa: E402
from common import Quantity  # noqa: E402

RESOLVED = 3.0  # cells in the half-width from which on a step counts
WIDTH = {2: 0.01, 3: 0.02}  # mean error of the half-width, beside 0.1 (h/a)^2
FORCE = 0.02  # mean error of a sphere's force, beside 0.25 (h/a)^2


class Setting:
    """The numbers of a run; the indenter's lowest point touches the material's surface at the start."""

    def __init__(self, results):
        self.dim = int(results.option("mpm_dim"))
        material = results.option("mpm_materials")
        self.young, self.nu = (results.numbers(f"mpm_material_{material}_{name}")[0] for name in ("E", "nu"))
        self.modulus = self.young / (1.0 - self.nu**2)
        self.radius = results.numbers("mpm_boundary_indenter_radius")[0]
        self.center = results.numbers("mpm_boundary_indenter_center")
        self.thickness = results.numbers("mpm_body_block_upper")[-1]
        lower, upper = (np.array(results.numbers(f"mpm_grid_{end}")) for end in ("lower", "upper"))
        self.cell = np.max((upper - lower) / common.cells(results))
        self.motion = -results.numbers("mpm_boundary_indenter_motion")[-1]


def measured(results, setting):
    """Whole force, and half-width from how far the force on the part of the indenter acts from its axis.

    A smooth force on a sphere goes through its middle: reaction_x/reaction_y is its lever over the radius. That of half a
    Hertzian pressure over a width is 4 a/(3 pi), of a quarter of one over a disc 3 a/8.
    """
    sideways, force = (np.abs(results.column(f"reaction_indenter_{axis}")) for axis in ("x", "xyz"[setting.dim - 1]))
    share = 3.0 * np.pi / 4.0 if setting.dim == 2 else 8.0 / 3.0
    with np.errstate(divide="ignore", invalid="ignore"):
        return 2.0**(setting.dim - 1) * force, share * setting.radius * sideways / force


def width(force, setting):
    """Hertz's half-width of a force."""
    if setting.dim == 2:
        return np.sqrt(4.0 * force * setting.radius / (np.pi * setting.modulus))
    return np.cbrt(0.75 * force * setting.radius / setting.modulus)


def layer(depth, setting):
    """Force of a sphere at a depth, on a layer that slides on a rigid base (Dimitriadis et al. 2002)."""
    nu, chi = setting.nu, np.sqrt(setting.radius * depth) / setting.thickness
    a, b = -0.347 * (3.0 - 2.0 * nu) / (1.0 - nu), 0.056 * (5.0 - 2.0 * nu) / (1.0 - nu)
    factor = (1.0 - 2.0 * a / np.pi * chi + 4.0 * a**2 / np.pi**2 * chi**2
              - 8.0 / np.pi**3 * (a**3 + 4.0 * np.pi**2 / 15.0 * b) * chi**3
              + 16.0 * a / np.pi**4 * (a**3 + 3.0 * np.pi**2 / 5.0 * b) * chi**4)
    return 4.0 / 3.0 * setting.modulus * np.sqrt(setting.radius) * depth**1.5 * factor


def check(results):
    setting = Setting(results)
    force, half = measured(results, setting)
    hertz = width(force, setting)
    resolved = hertz >= RESOLVED * setting.cell
    if not resolved.any():
        resolved[-1] = True
    grid = (setting.cell / hertz[-1])**2
    steps = results.column("step").size
    quantities = [common.completed(results),
                  Quantity("width_error", np.mean(np.abs(half / hertz - 1.0)[resolved]), None,
                           WIDTH[setting.dim] + 0.1 * grid)]
    if setting.dim == 3:
        theory = layer(results.column("time") * setting.motion, setting)
        quantities.append(Quantity("force_error", np.mean(np.abs(force / theory - 1.0)[resolved]), None, FORCE + 0.25 * grid))
    depth = results.column("depth_indenter")[-1]
    return quantities + [Quantity("depth_over_cell", depth / setting.cell, None, 1e-3),
                         Quantity("newton_a_step", np.sum(results.column("newton")) / steps, None, 6.0),
                         Quantity("cuts", np.sum(results.column("cuts")), None, 0.0)]


def draw(results):
    """Half-width against force, and the pressure under the indenter or the force against its way."""
    import matplotlib.pyplot as plt

    setting = Setting(results)
    force, half = measured(results, setting)
    figure, (left, right) = plt.subplots(1, 2, figsize=(11.0, 4.2), layout="constrained")
    line = np.linspace(0.0, 1.05 * force.max(), 200)
    unit = "kN/m" if setting.dim == 2 else "kN"
    left.plot(line / 1e3, width(line, setting), color="0.3", label="Hertz")
    left.plot(force / 1e3, half, "o", color="tab:blue", label="Talus")
    left.set(xlabel=f"force ({unit})", ylabel="half-width (m)", xlim=(0.0, None), ylim=(0.0, None))
    if setting.dim == 3:
        way = np.linspace(0.0, setting.motion, 100)
        right.plot(1e3 * way, 4.0 / 3.0 * setting.modulus * np.sqrt(setting.radius) * way**1.5 / 1e3, "--", color="0.6",
                   label="Hertz, half-space")
        right.plot(1e3 * way, layer(way, setting) / 1e3, color="0.3", label="layer")
        right.plot(1e3 * results.column("time") * setting.motion, force / 1e3, "o", color="tab:blue", label="Talus")
        right.set(xlabel="way of the sphere (mm)", ylabel="force (kN)", xlim=(0.0, None), ylim=(0.0, None))
    else:
        a = width(force[-1], setting)
        state, start = results.state("last"), results.initial["position0"]
        top = start[:, 1] > start[:, 1].max() - 1e-6 * setting.cell
        place, pressure = state["position"][top, 0], -state["stress"][top, 1]
        near = place < 2.0 * a
        x = np.linspace(0.0, 2.0 * a, 400)
        peak = 2.0 * force[-1] / (np.pi * a)
        right.plot(x, peak / 1e3 * np.sqrt(np.maximum(1.0 - (x / a)**2, 0.0)), color="0.3", label="Hertz, at the surface")
        right.plot(place[near], pressure[near] / 1e3, "o", markersize=3, color="tab:blue", label="Talus, topmost points")
        right.set(xlabel="x (m)", ylabel="pressure (kPa)", xlim=(0.0, None))
    for axes in (left, right):
        axes.grid(alpha=0.3)
        axes.legend()
    return figure


if __name__ == "__main__":
    common.main(check, draw)
