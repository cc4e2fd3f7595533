#!/usr/bin/env python3
"""Compares pressure, effective stress and flux with those of steady upward seepage."""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
import common  # noqa: E402
from common import Quantity  # noqa: E402

STRESS = 0.005  # of the stress at the base
FLUX = 0.005


class Theory:
    """Unit weights, N/m3; gradient, -; conductivity, m/s; initial height, m."""

    def __init__(self, results):
        gravity = -results.numbers("mpm_load_weight_value")[1]
        self.water = results.numbers("mpm_water_density")[0] * gravity
        self.buoyant = results.numbers("mpm_material_sand_density")[0] * gravity - self.water
        self.conductivity = results.numbers("mpm_material_sand_conductivity")[0]
        self.height = results.numbers("mpm_body_layer_upper")[1]
        last = float(results.option("mpm_surface_bottom_ramp").split(":")[-1])
        self.gradient = results.numbers("mpm_surface_bottom_pressure")[0] * last / (self.water * self.height) - 1.0

    def pressure(self, depth):
        return (1.0 + self.gradient) * self.water * depth

    def stress(self, depth):
        return -(self.buoyant - self.gradient * self.water) * depth


def by_rows(results, state, values):
    """Depths below the surface as it stands now and means, for the initial rows of cells: the strain within a cell is one."""
    rows = np.floor(results.initial["position0"][:, 1] / (results.numbers("mpm_grid_upper")[1] / results.numbers("mpm_grid_cells")[1]))
    volume, height = state["volume"], state["position"][:, 1]
    width = results.numbers("mpm_body_layer_upper")[0]
    top = np.sum(volume) / width
    mean = [np.average(np.column_stack([top - height, values])[rows == row], axis=0, weights=volume[rows == row])
            for row in np.unique(rows)]
    return np.array(mean).T


def at_places(results, theory, state):
    """The worst error of the stress along the profile, from half a cell on from both ends."""
    table = results.table("profile", "height")
    last = table["step"] == table["step"][-1]
    top = np.sum(state["volume"]) / results.numbers("mpm_body_layer_upper")[0]
    return np.max(np.abs(table["yy"][last] - theory.stress(top - table["y"][last])))


def check(results):
    theory, state = Theory(results), results.state("last")
    depth, stress = by_rows(results, state, state["stress"][:, 1])
    base = -theory.stress(theory.height)
    top, bottom = results.column("outflow_top"), results.column("outflow_bottom")
    width, step = results.numbers("mpm_body_layer_upper")[0], results.column("dt")[-1]
    flux = theory.conductivity * theory.gradient * width
    pressure = np.max(np.abs(state["pressure"] - theory.pressure(theory.height - state["position"][:, 1])))
    quantities = [common.completed(results),
                  Quantity("stress_error", np.max(np.abs(stress - theory.stress(depth))) / base, None, STRESS),
                  Quantity("stress_error_at_places", at_places(results, theory, state) / base, None, STRESS),
                  Quantity("pressure_error", pressure / theory.pressure(theory.height), None, STRESS),
                  Quantity.near("flux_top", (top[-1] - top[-2]) / step, flux, FLUX),
                  Quantity.near("flux_bottom", (bottom[-1] - bottom[-2]) / step, -flux, FLUX)]
    if results.option("mpm_shape_edge", "linear") == "open":
        error = state["stress"][:, 1] - theory.stress(np.sum(state["volume"]) / width - state["position"][:, 1])
        quantities.append(Quantity("stress_error_at_points", np.max(np.abs(error)) / base, None, STRESS))
    return quantities


def draw(results):
    import matplotlib.pyplot as plt

    theory = Theory(results)
    figure, (left, right) = plt.subplots(1, 2, figsize=(10.0, 4.2), layout="constrained", sharey=True)
    y = np.linspace(0.0, theory.height, 2)
    for step in results.steps[1:]:
        state = results.state(step)
        line, = left.plot(1e-3 * state["pressure"], state["position"][:, 1], ".", markersize=3, label=f"{state.time / 3600:.2g} h")
        depth, stress = by_rows(results, state, state["stress"][:, 1])
        right.plot(1e-3 * stress, theory.height - depth, "o", markersize=4, color=line.get_color(), label=f"{state.time / 3600:.2g} h")
    left.plot(1e-3 * theory.pressure(theory.height - y), y, color="0.3", linewidth=0.8)
    right.plot(1e-3 * theory.stress(theory.height - y), y, color="0.3", linewidth=0.8, label="theory, steady")
    left.set(xlabel="pressure of water (kPa)", ylabel="y (m)")
    right.set(xlabel="vertical effective stress (kPa)")
    for axes in (left, right):
        axes.grid(alpha=0.3)
        axes.legend()
    return figure


if __name__ == "__main__":
    common.main(check, draw)
