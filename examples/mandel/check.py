#!/usr/bin/env python3
"""Compares pressure and settlement between two plates with Mandel's solution."""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
import common  # noqa: E402
from common import Quantity  # noqa: E402

TERMS = 200
PRESSURE = 0.01  # of the pressure at the start
FORCE = 1e-8


class Theory:
    """Mandel's solution for incompressible grains and water: p, Pa, and the plate's way, m, from the start on."""

    def __init__(self, results):
        number = {name: results.numbers(f"mpm_material_clay_{name}")[0] for name in ("E", "nu", "permeability")}
        self.nu = number["nu"]
        self.mu = number["E"] / (2.0 * (1.0 + self.nu))
        modulus = 2.0 * self.mu * (1.0 - self.nu) / (1.0 - 2.0 * self.nu)
        self.a, self.b = results.numbers("mpm_body_clay_upper")
        self.force = -results.numbers("mpm_boundary_plate_load")[1]
        self.rate = number["permeability"] / results.numbers("mpm_water_viscosity")[0] * modulus / self.a**2
        self.root = self.roots((1.0 - self.nu) / (0.5 - self.nu))

    @staticmethod
    def roots(ratio):
        """The positive roots of tan(alpha) = ratio alpha, one in each period, by bisection."""
        low = np.pi * np.arange(TERMS) + 1e-12
        high = np.pi * (np.arange(TERMS) + 0.5) - 1e-14
        for _ in range(100):
            middle = 0.5 * (low + high)
            above = np.tan(middle) > ratio * middle
            low, high = np.where(above, low, middle), np.where(above, middle, high)
        return middle

    def pressure(self, x, time):
        alpha = self.root
        weight = np.sin(alpha) / (alpha - np.sin(alpha) * np.cos(alpha)) * np.exp(-alpha**2 * self.rate * time)
        shape = np.cos(np.outer(np.atleast_1d(x) / self.a, alpha)) - np.cos(alpha)
        return self.force / self.a * (shape @ weight)

    def settlement(self, time):
        alpha = self.root
        weight = np.sin(alpha) * np.cos(alpha) / (alpha - np.sin(alpha) * np.cos(alpha))
        decay = np.exp(-np.outer(np.atleast_1d(time), alpha**2 * self.rate))
        return self.b * self.force / (self.mu * self.a) * (0.5 * (1.0 - self.nu) - 0.5 * (decay @ weight))


def check(results):
    theory = Theory(results)
    error = 0.0
    for step in results.steps[1:]:
        state = results.state(step)
        exact = theory.pressure(results.initial["position0"][:, 0], state.time)
        error = max(error, np.max(np.abs(state["pressure"] - exact)) / (0.5 * theory.force / theory.a))
    way = results.column("position_plate_y")[0] - results.column("position_plate_y")
    exact = theory.settlement(results.column("time"))
    force = results.column("reaction_plate_y")
    return [common.completed(results), Quantity("pressure_error", error, None, PRESSURE),
            Quantity("settlement_error", np.max(np.abs(way - (exact - exact[0]))) / exact[-1], None, PRESSURE),
            Quantity("force_error", np.max(np.abs(np.abs(force) / theory.force - 1.0)), None, FORCE),
            Quantity("cuts", np.sum(results.column("cuts")), None, 0.0)]


def draw(results):
    import matplotlib.pyplot as plt

    theory = Theory(results)
    figure, (left, right) = plt.subplots(1, 2, figsize=(11.0, 4.2), layout="constrained")
    x = np.linspace(0.0, theory.a, 200)
    for step in results.steps[1:]:
        state = results.state(step)
        line, = left.plot(x / theory.a, theory.pressure(x, state.time) * theory.a / theory.force, linewidth=1.0)
        low = results.initial["position0"][:, 1] < 0.1 * theory.b
        left.plot(results.initial["position0"][low, 0] / theory.a, state["pressure"][low] * theory.a / theory.force, "o",
                  markersize=3, color=line.get_color(), label=f"T = {theory.rate * state.time:.2g}")
    left.set(xlabel="x/a", ylabel="p a/F", ylim=(0.0, None))
    time = np.geomspace(1e-3, theory.rate * results.column("time")[-1], 100) / theory.rate
    right.semilogx(theory.rate * time, 1e3 * theory.settlement(time), color="0.3", label="Mandel")
    way = results.column("position_plate_y")[0] - results.column("position_plate_y") + theory.settlement(results.column("time")[0])
    right.semilogx(theory.rate * results.column("time"), 1e3 * way, ".", color="tab:blue", label="Talus")
    right.set(xlabel="T = c_v t/a$^2$", ylabel="settlement of the plate (mm)")
    for axes in (left, right):
        axes.grid(alpha=0.3)
        axes.legend()
    return figure


if __name__ == "__main__":
    common.main(check, draw)
