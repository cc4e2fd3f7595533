#!/usr/bin/env python3
"""Compares a column's settlement and pressure at finite strain with the exact solution for Uzuoka and Borja's permeability."""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
import common  # noqa: E402
from common import Quantity  # noqa: E402

TERMS = 4000
SETTLEMENT = 9e-4  # of the last one, at every step
PRESSURE = {"second": 5e-3, "euler": 1e-3}  # of the load, at the base and at half the height, from T = 0.01 on
SOLUTIONS = 100


class Theory:
    """Where the permeability makes dJ/dt = c_v d2J/dX2, J is Terzaghi's series between 1 and the J that bears the load."""

    def __init__(self, results):
        E, nu, permeability = (results.numbers(f"mpm_material_clay_{name}")[0] for name in ("E", "nu", "permeability"))
        self.mu, self.lame = E / (2.0 * (1.0 + nu)), E * nu / ((1.0 + nu) * (1.0 - 2.0 * nu))
        self.width, self.height = results.numbers("mpm_body_cap_upper")
        self.load = -results.numbers("mpm_surface_top_traction")[1]
        mobility = permeability / results.numbers("mpm_water_viscosity")[0]
        self.rate = mobility * (self.lame + 2.0 * self.mu) / self.height**2
        self.root = np.pi * (np.arange(TERMS) + 0.5)
        low, high = 1e-3, 1.0
        for _ in range(100):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if self.stress(middle) < -self.load else (low, middle)
        self.end = middle
        self.last = self.height * (1.0 - self.end)

    def stress(self, J):
        """Effective, along the column: the neo-Hookean solid in uniaxial strain, Pa."""
        return self.mu * (J - 1.0 / J) + self.lame * np.log(J) / J

    def decay(self, time):
        """What is left of each term of the series, by rows of times."""
        return np.exp(-np.outer(np.atleast_1d(time), self.root**2 * self.rate))

    def decay_in_steps(self, lengths):
        """The same after steps of backward Euler's method: the limit of fine grids."""
        return np.cumprod(1.0 / (1.0 + np.outer(lengths, self.root**2 * self.rate)), axis=0)

    def settlement(self, decay):
        return self.last * (1.0 - decay @ (2.0 / self.root**2))

    def pressure(self, X, decay):
        part = 1.0 - np.sin(np.outer(1.0 - np.atleast_1d(X) / self.height, self.root)) @ (2.0 / self.root * decay)
        return self.stress(1.0 - (1.0 - self.end) * part) + self.load


def pressure_error(results, theory, decay):
    error, X, number = 0.0, results.initial["position0"][:, 1], results.column("step").astype(int)
    for step in results.steps[1:]:
        state = results.state(step)
        if theory.rate * state.time < 0.01:
            continue
        left = decay[np.searchsorted(number, step)]
        for place in (0.0, 0.5 * theory.height):
            near = np.argmin(np.abs(X - place))
            error = max(error, abs(state["pressure"][near] - theory.pressure(X[near], left)[0]))
    return error / theory.load


def convex(time, settled):
    """The largest second divided difference of the settlement, over its mean rate squared: never positive."""
    time, settled = np.append(0.0, time), np.append(0.0, settled)
    rate = np.diff(settled) / np.diff(time)
    return np.max(np.diff(rate)) / np.max(rate)


def check(results):
    theory = Theory(results)
    scheme = results.option("mpm_time_scheme", "euler")
    time, settled = results.column("time"), results.column("outflow_top") / theory.width
    decay = theory.decay_in_steps(results.column("dt")) if scheme == "euler" else theory.decay(time)
    wrong = np.max(np.abs(settled - theory.settlement(decay))) / theory.last
    quantities = [common.completed(results), Quantity("settlement_error", wrong, None, SETTLEMENT),
                  Quantity("pressure_error", pressure_error(results, theory, decay), None, PRESSURE[scheme]),
                  Quantity("bends_upward", convex(time, settled), None, 1e-9),
                  Quantity("newton", np.max(results.column("newton")), None, 5.0)]
    if results.option("mpm_time_error") != "not given":
        solutions = 2 * (len(time) + np.sum(results.column("cuts")))
        quantities.append(Quantity("solutions", solutions, None, SOLUTIONS))
    return quantities


def draw(results):
    import matplotlib.pyplot as plt

    theory = Theory(results)
    figure, (left, right) = plt.subplots(1, 2, figsize=(10.0, 4.2), layout="constrained")
    time = np.geomspace(0.05, 7500.0, 300)
    left.semilogx(time, theory.settlement(theory.decay(time)), color="0.3", label="exact")
    left.semilogx(results.column("time"), results.column("outflow_top") / theory.width, "o", markersize=4, label="Talus")
    left.set(xlabel="time (s)", ylabel="settlement (m)")
    left.invert_yaxis()
    X = np.linspace(0.0, theory.height, 200)
    place = results.initial["position0"][:, 1]
    for step in results.steps[1:]:
        state = results.state(step)
        line, = right.plot(theory.pressure(X, theory.decay(state.time)[0]) / theory.load, X / theory.height, linewidth=1.0)
        right.plot(state["pressure"][::12] / theory.load, place[::12] / theory.height, "o", markersize=3,
                   color=line.get_color(), label=f"T = {theory.rate * state.time:.2g}")
    right.set(xlabel="p over the load", ylabel="X/H")
    for axes in (left, right):
        axes.grid(alpha=0.3)
        axes.legend(fontsize="small")
    return figure


if __name__ == "__main__":
    common.main(check, draw)
