#!/usr/bin/env python3
"""Compares the settlement of an embankment with the one-dimensional estimate, and looks at the water's pressure over time."""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
import common  # noqa: E402
from common import Quantity  # noqa: E402

SETTLEMENT = (0.75, 1.15)  # over the estimate, which spreads no load and knows no shear
REST = 0.05  # mean excess pressure at the end, over the largest there was


class Ground:
    """The clay and the water in it as they were drawn."""

    def __init__(self, results):
        number = lambda name: results.numbers(f"mpm_material_clay_{name}")[0]  # noqa: E731
        self.kappa, self.slope, self.ocr = number("kappa"), number("lambda"), number("ocr")
        self.gravity = -results.numbers("mpm_load_weight_value")[1]
        self.water = results.numbers("mpm_water_density")[0] * self.gravity
        self.buoyant = number("density") * self.gravity - self.water
        self.depth = results.numbers("mpm_body_ground_upper")[1]
        self.fill = results.numbers("mpm_material_sand_density")[0] * self.gravity
        self.height = 2.0

    def estimate(self):
        """Settlement of a column under the whole height, m: kappa up to the preconsolidation, lambda beyond; what sinks below the water is buoyant."""
        z = (np.arange(400) + 0.5) / 400 * self.depth
        settlement = 0.0
        for _ in range(50):
            ratio = 1.0 + (self.height * self.fill - settlement * self.water) / (self.buoyant * z)
            strain = self.kappa * np.log(np.minimum(ratio, self.ocr)) + self.slope * np.log(np.maximum(ratio / self.ocr, 1.0))
            settlement = self.depth * np.mean(1.0 - np.exp(-strain))
        return settlement

    def excess(self, state):
        """Pressure above the hydrostatic one of the clay's points, Pa."""
        return state["pressure"].ravel() - self.water * np.maximum(self.depth - state["position"][:, 1], 0.0)


def clay(results, state):
    return state["material"].ravel() == results.initial["material"].ravel()[0]


def check(results):
    ground = Ground(results)
    settlement = -results.column("track_middle_uy")
    largest = max(np.max(ground.excess(state)[clay(results, state)]) for state in map(results.state, results.steps[1:]))
    last = results.state("last")
    return [common.completed(results),
            Quantity("settlement_over_estimate", settlement[-1] / ground.estimate(), *SETTLEMENT),
            Quantity("comes_up", max(0.0, -np.min(np.diff(settlement[1:]))) / settlement[-1], None, 5e-3),
            Quantity("largest_excess_over_fill", largest / (ground.height * ground.fill), 0.2, 1.0),
            Quantity("excess_left", np.mean(np.abs(ground.excess(last)[clay(results, last)])) / largest, None, REST),
            Quantity("cuts", np.sum(results.column("cuts")), None, 0.0)]


def draw(results):
    import matplotlib.pyplot as plt
    from pictures.plane import draw_body

    ground = Ground(results)
    figure, axes = plt.subplots(2, 2, figsize=(12.0, 6.4), layout="constrained")
    states = [results.state(step) for step in results.steps[1:]]
    fullest = max(states, key=lambda state: np.max(ground.excess(state)[clay(results, state)]))
    for panel, state in zip(axes[:, 0], (fullest, states[-1])):
        points = draw_body(panel, results, state, np.where(clay(results, state), ground.excess(state), 0.0) / 1e3)
        figure.colorbar(points, ax=panel, label="excess pressure (kPa)")
        panel.set(aspect="equal", xlabel="x (m)", ylabel="y (m)", title=f"after {state.time / 86400.0:.0f} days")
    days = results.column("time") / 86400.0
    axes[0, 1].plot(days, -1e3 * results.column("track_middle_uy"), label="middle")
    axes[0, 1].plot(days, -1e3 * results.column("track_toe_uy"), label="1 m beside the toe")
    axes[0, 1].axhline(1e3 * ground.estimate(), color="0.4", linestyle="--", label="column, by hand")
    axes[0, 1].set(xlabel="days", ylabel="settlement (mm)")
    axes[0, 1].invert_yaxis()
    excess = [np.max(ground.excess(state)[clay(results, state)]) / 1e3 for state in states]
    axes[1, 1].plot([state.time / 86400.0 for state in states], excess, ".-")
    axes[1, 1].set(xlabel="days", ylabel="largest excess pressure (kPa)", ylim=(0.0, None))
    for panel in axes[:, 1]:
        panel.grid(alpha=0.3)
    axes[0, 1].legend()
    return figure


if __name__ == "__main__":
    common.main(check, draw)
