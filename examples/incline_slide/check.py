#!/usr/bin/env python3
"""Way, speed and friction of a block that slides down a slope, against Coulomb's law."""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
import common  # noqa: E402
from common import Quantity, completed  # noqa: E402


def acceleration(results):
    """Of a rigid block, along the slope."""
    along, across = (float(value) for value in results.option("mpm_load_weight_value").split(","))
    return along + float(results.option("mpm_boundary_slope_friction")) * across


def check(results):
    history = results.history
    time, way, speed = history["time"][-1], history["track_middle_ux"][-1], history["track_middle_vx"][-1]
    exact, weight = acceleration(results), results.state("first")["mass"].sum()
    friction, across = -history["reaction_slope_x"], history["reaction_slope_y"]
    relative = 3e-3 if results.option("mpm_time_integrator") == "generalized_alpha" else 0.03
    mu = float(results.option("mpm_boundary_slope_friction"))
    return [completed(results),
            Quantity.near("way", way, exact * time**2 / 2, relative=relative),
            Quantity.near("speed", speed, exact * time, relative=relative),
            Quantity.near("friction_over_pressure", friction.sum() / across.sum(), mu, relative=1e-3),
            Quantity.near("mean_pressure_over_weight", across.mean() / weight, 6.936717523, relative=0.02),
            Quantity("energy_balance_over_work", np.abs(history["energy_balance"]).max() / history["energy_external"][-1],
                     upper=0.02)]


def draw(results):
    import matplotlib.pyplot as plt

    figure, (above, below) = plt.subplots(2, 1, figsize=(8, 5), constrained_layout=True)
    for step in list(results.steps)[::2]:
        above.scatter(*results.state(step)["position"].T, s=2)
    above.axhline(0, color="0.4")
    above.set(aspect="equal", xlabel="along the slope (m)", ylabel="(m)", title="every 0.2 s")
    history, exact = results.history, acceleration(results)
    below.plot(history["time"], exact * history["time"] ** 2 / 2, color="0.6", linewidth=4, label="rigid block")
    below.plot(history["time"], history["track_middle_ux"], color="C3", linewidth=1, label="computed")
    below.set(xlabel="time (s)", ylabel="way (m)")
    below.legend()
    return figure


if __name__ == "__main__":
    common.main(check, draw)
