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

    figure = plt.figure(figsize=(10, 4.4), constrained_layout=True)
    grid = figure.add_gridspec(2, 2)
    left, above, below = (figure.add_subplot(place) for place in (grid[:, 0], grid[0, 1], grid[1, 1]))
    rim = common.outline(results.state("first")["position0"])
    steps = list(results.steps)[:8]
    for step, shade in zip(steps, plt.cm.viridis(np.linspace(0.95, 0.05, len(steps)))):
        state = results.state(step)
        left.fill(*state["position"][rim].T, facecolor=shade, edgecolor="k", linewidth=0.5, alpha=0.7, label=f"{state.time:.2f} s")
    left.set(aspect="equal", xlim=(-0.1, 5.0), xlabel="x (m)", ylabel="y (m)", title="on the way down")
    left.legend(fontsize="small", loc="lower right", title="after")
    history = results.history
    above.plot(history["time"], history["track_tip_uy"], color="C3")
    above.set(ylabel="tip (m)")
    for name, label in (("kinetic", "kinetic"), ("elastic", "elastic"), ("external", "from the weight")):
        below.plot(history["time"], history[f"energy_{name}"] / 1e3, label=label)
    below.set(xlabel="time (s)", ylabel="energy (kJ/m)")
    below.legend(fontsize="small")
    return figure


if __name__ == "__main__":
    common.main(check, draw)
