#!/usr/bin/env python3
"""Drop and return of a beam that is let go under its own weight, against what finer grids tend to, and its energy."""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
import common  # noqa: E402
from common import Quantity, cells, completed  # noqa: E402

# Extrapolated from grids of 1/4 and 1/8 m: the deepest place of the tip, when, and where it comes back to.
DEEPEST, WHEN, BACK = -3.787, 1.09, 0.01


def check(results):
    history = results.history
    tip, time = history["track_tip_uy"], history["time"]
    deepest = tip.argmin()
    fine = cells(results)[0] >= 24
    energy = np.abs(history["energy_balance"]).max() / np.abs(history["energy_external"]).max()
    quantities = [completed(results),
                  Quantity.near("deepest_tip", tip[deepest], DEEPEST, relative=0.015 if fine else 0.05),
                  Quantity.near("at_time", time[deepest], WHEN, relative=0.03 if fine else 0.1)]
    if time[-1] >= 2.6:
        quantities.append(Quantity.near("back_at", tip[deepest:].max(), BACK, absolute=0.15 if fine else 0.6))
    quantities.append(Quantity("energy_balance_over_work", energy, upper=0.05 if fine else 0.15))
    return quantities


def draw(results):
    import matplotlib.pyplot as plt

    figure, (left, right) = plt.subplots(1, 2, figsize=(10, 4), constrained_layout=True)
    for step in list(results.steps)[:8]:
        left.scatter(*results.state(step)["position"].T, s=1)
    left.set(aspect="equal", xlabel="x (m)", ylabel="y (m)", title="every 0.15 s on the way down")
    history = results.history
    right.plot(history["time"], history["track_tip_uy"], color="C3", label="tip (m)")
    for name in ("kinetic", "elastic", "external"):
        right.plot(history["time"], history[f"energy_{name}"] / 1e5, label=f"{name} energy (100 kJ)")
    right.set_xlabel("time (s)")
    right.legend(fontsize="small")
    return figure


if __name__ == "__main__":
    common.main(check, draw)
