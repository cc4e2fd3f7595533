#!/usr/bin/env python3
"""Compares pressure and settlement of a column that drains at its top with Terzaghi's solution."""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
import common  # noqa: E402
from common import Quantity  # noqa: E402

TERMS = 400
PRESSURE = {"second": 2e-4, "euler": 0.02}  # of the load, in steps up to T = 0.0072
SETTLEMENT = {"second": 5e-4, "euler": 0.02}  # of the last one, from T = 0.05 on


class Theory:
    """Terzaghi's solution: pressure, Pa, at places above the base, and settlement, m."""

    def __init__(self, results):
        E, nu, permeability = (results.numbers(f"mpm_material_clay_{name}")[0] for name in ("E", "nu", "permeability"))
        modulus = E * (1.0 - nu) / ((1.0 + nu) * (1.0 - 2.0 * nu))
        self.height = results.numbers("mpm_body_clay_upper")[1]
        self.width = results.numbers("mpm_body_clay_upper")[0]
        self.load = -results.numbers("mpm_surface_top_traction")[1]
        self.rate = permeability / results.numbers("mpm_water_viscosity")[0] * modulus / self.height**2
        self.last = self.load / modulus * self.height
        self.root = np.pi * (np.arange(TERMS) + 0.5)

    def pressure(self, y, time):
        weight = 2.0 / self.root * np.exp(-self.root**2 * self.rate * time)
        return self.load * (np.sin(np.outer(1.0 - y / self.height, self.root)) @ weight)

    def settlement(self, time):
        weight = 2.0 / self.root**2
        return self.last * (1.0 - np.exp(-np.outer(np.atleast_1d(time), self.root**2 * self.rate)) @ weight)


def pressure_error(results, theory, step):
    state = results.state(step)
    exact = theory.pressure(results.initial["position0"][:, 1], state.time)
    return np.max(np.abs(state["pressure"] - exact)) / theory.load


def check(results):
    theory = Theory(results)
    scheme = results.option("mpm_time_scheme", "euler")
    error = max(pressure_error(results, theory, step) for step in results.steps[1:])
    settled = results.column("outflow_top") / theory.width  # what has left the pores is what the top has sunk
    time = results.column("time")
    wrong = np.max(np.abs(settled - theory.settlement(time))[theory.rate * time > 0.05]) / theory.last
    return [common.completed(results), Quantity("pressure_error", error, None, PRESSURE[scheme]),
            Quantity("settlement_error", wrong, None, SETTLEMENT[scheme]),
            Quantity("newton", np.max(results.column("newton")), None, 2.0)]


def draw(results):
    import matplotlib.pyplot as plt

    theory = Theory(results)
    figure, (left, right) = plt.subplots(1, 2, figsize=(10.0, 4.2), layout="constrained")
    y = np.linspace(0.0, theory.height, 200)
    place = results.initial["position0"][:, 1]
    for step in results.steps[1:]:
        state = results.state(step)
        line, = left.plot(theory.pressure(y, state.time) / theory.load, y / theory.height, linewidth=1.0)
        left.plot(state["pressure"][::8] / theory.load, place[::8] / theory.height, "o", markersize=3,
                  color=line.get_color(), label=f"T = {theory.rate * state.time:.2g}")
    left.set(xlabel="p/p$_0$", ylabel="y/H")
    time = results.column("time")
    right.plot(theory.rate * time, 1e3 * theory.settlement(time), color="0.3", label="Terzaghi")
    right.plot(theory.rate * time[::4], 1e3 * results.column("outflow_top")[::4] / theory.width, ".", label="Talus")
    right.set(xlabel="T = c_v t/H$^2$", ylabel="settlement (mm)")
    right.invert_yaxis()
    for axes in (left, right):
        axes.grid(alpha=0.3)
        axes.legend(fontsize="small")
    return figure


if __name__ == "__main__":
    common.main(check, draw)
