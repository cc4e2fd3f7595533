#!/usr/bin/env python3
"""Water that slides down to a wall: its speed by depth, impulse on the wall in 3D, force on the wall at rest.

PREFIX is that of case.yaml, wall.yaml or pond.yaml.
"""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
import common  # noqa: E402
from common import Quantity, completed  # noqa: E402
from make import DEPTH, bed  # noqa: E402

G, DENSITY = 9.81, 1000.0
SPEED = {"vertical": 6.651, "normal": 6.237}  # m/s at 3 s: HLL scheme, well-balanced, 8 000 cells
PLACE = 16.31  # m


def mean(history, name, since):
    late = history["time"] > since
    return (history[name] * history["dt"])[late].sum() / history["dt"][late].sum()


def flow(results):
    """The depth-averaged run."""
    state, slope = results.state("last"), results.option("mpm_slope", "normal")
    share = state["mass"].ravel() / state["mass"].sum()
    quantities = [Quantity.near("speed", share @ state["velocity"][:, 0], SPEED[slope], relative=0.015)]
    if slope == "vertical":
        quantities.append(Quantity.near("place", share @ state["position"][:, 0], PLACE, relative=0.01))
    return quantities


def impact(results):
    """Impulses against the change of momentum; no point below the bed."""
    history, state = results.history, results.state("last")
    wall, ground = ((history[f"reaction_{name}_x"] * history["dt"])[1:].sum() for name in ("wall", "ground"))
    change = history["momentum_x"][-1] - history["momentum_x"][0]
    low = (state["position"][:, 2] - bed(state["position"][:, 0])).min()
    return [Quantity.near("impulse", wall, change - ground, relative=0.01), Quantity("below_bed", -low, None, 0.02),
            Quantity("energy", history["energy_balance"].max() / history["energy_kinetic"].max(), None, 0.01)]


def pond(results):
    width = results.numbers("mpm_grid_upper")[1]
    return [Quantity.near("force", -mean(results.history, "reaction_wall_x", 0.1) / width, 0.5 * DENSITY * G * DEPTH**2, relative=0.03)]


def check(results):
    if results.summary["dim"] == 2:
        return [completed(results), *flow(results)]
    return [completed(results), *(pond(results) if results.numbers("mpm_grid_lower")[0] > 0 else impact(results))]


def draw(results):
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(2, 1, figsize=(7.0, 5.0), layout="constrained")
    x = np.linspace(0, 21, 200)
    axes[0].fill_between(x, bed(x), 5.5, color="0.85")
    axes[0].plot([20, 20], [bed(20.0), 12], color="0.3")
    for step in results.steps[:: max(1, len(results.steps) // 4)]:
        state = results.state(step)
        axes[0].plot(state["position"][:, 0], state["position"][:, -1], ".", markersize=3, label=f"{state.time + 1.8:.2f} s")
    axes[0].set(xlabel="x (m)", ylabel="z (m)")
    axes[0].legend()
    history = results.history
    axes[1].plot(history["time"] + 1.8, -np.cumsum(history["reaction_wall_x"] * history["dt"]) / results.numbers("mpm_grid_upper")[1] / 1e3)
    axes[1].set(xlabel="t (s)", ylabel="impulse on the wall (kN s/m)")
    return figure


if __name__ == "__main__":
    common.main(check, draw)
