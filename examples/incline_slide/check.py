#!/usr/bin/env python3
"""Way, speed and friction of what slides or rolls down a slope, against Coulomb's law."""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
import common  # noqa: E402
from common import Quantity, completed  # noqa: E402


def motion(results):
    """Acceleration of a rigid body along the slope, its pressure on it a mass, and the mean of friction over pressure."""
    along, across = (float(value) for value in results.option("mpm_load_weight_value").split(","))
    mu = float(results.option("mpm_boundary_slope_friction"))
    if results.option("mpm_bodies") == "disc" and along <= -3 * mu * across:
        return along * 2 / 3, -across, -along / across / 3
    return along + mu * across, -across, mu


def check(results):
    history = results.history
    weight = results.state("first")["mass"].sum()
    time, way, speed = history["time"][-1], history["track_middle_ux"][-1], history["momentum_x"][-1] / weight
    exact, across, mu = motion(results)
    friction, pressure = -history["reaction_slope_x"], history["reaction_slope_y"]
    if results.option("mpm_bodies") == "disc":
        way_bound, speed_bound, ratio_bound = 0.01, 0.03, 0.03
    elif results.option("mpm_time_integrator") == "generalized_alpha":
        way_bound, speed_bound, ratio_bound = 3e-3, 3e-3, 1e-3
    else:
        way_bound, speed_bound, ratio_bound = 0.015, 0.03, 1e-3
    return [completed(results),
            Quantity.near("way", way, exact * time**2 / 2, relative=way_bound),
            Quantity.near("speed", speed, exact * time, relative=speed_bound),
            Quantity.near("friction_over_pressure", friction.sum() / pressure.sum(), mu, relative=ratio_bound),
            Quantity.near("mean_pressure_over_weight", pressure.mean() / weight, across, relative=0.02),
            Quantity("energy_balance_over_work", np.abs(history["energy_balance"]).max() / history["energy_external"][-1],
                     upper=0.02)]


def draw(results):
    import matplotlib.pyplot as plt

    figure, (above, below) = plt.subplots(2, 1, figsize=(8, 5), constrained_layout=True)
    place = results.state("first")["position0"]
    rim = common.outline(place)
    spoke = [np.abs(place - (place[rim].mean(axis=0) + offset)).sum(axis=1).argmin() for offset in ((0.0, 0.0), (0.0, 1.0))]
    steps = list(results.steps)[::2]
    for step, shade in zip(steps, plt.cm.viridis(np.linspace(0.9, 0.1, len(steps)))):
        state = results.state(step)
        above.fill(*state["position"][rim].T, facecolor=shade, alpha=0.25)
        above.fill(*state["position"][rim].T, fill=False, edgecolor=shade, label=f"{state.time:.1f} s")
        if results.option("mpm_bodies") == "disc":
            above.plot(*state["position"][spoke].T, color=shade)
    above.axhline(0, color="0.4")
    above.legend(fontsize="small", loc="center left", bbox_to_anchor=(1.0, 0.5))
    above.set(aspect="equal", xlabel="along the slope (m)", ylabel="across it (m)")
    history, (exact, *_) = results.history, motion(results)
    below.plot(history["time"], exact * history["time"] ** 2 / 2, color="0.6", linewidth=4, label="rigid body")
    below.plot(history["time"], history["track_middle_ux"], color="C3", linewidth=1, label="computed")
    below.set(xlabel="time (s)", ylabel="way (m)")
    below.legend()
    return figure


if __name__ == "__main__":
    common.main(check, draw)
