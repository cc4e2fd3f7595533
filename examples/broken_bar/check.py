#!/usr/bin/env python3
"""Energy and stress of a bar that breaks in its middle, against the crack of AT1 on linear elements."""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
import common  # noqa: E402
from common import Quantity, completed  # noqa: E402

E, G_C, LENGTH, CELLS = 210e9, 2700.0, 0.1, 81
H = 2.0 / CELLS
STRENGTH = np.sqrt(3.0 * E * G_C / (8.0 * LENGTH))  # Pa, where AT1 begins


def curves(results):
    return results.column("reaction_drawn_x") / H, results.column("energy_fracture") / (G_C * H)


def check(results):
    stress, energy = curves(results)
    after = int(np.argmax(results.column("damage_max") > 0.9))
    return [completed(results),
            Quantity.near("peak", stress.max(), np.sqrt(0.98) * STRENGTH, relative=0.01),
            Quantity.near("energy", energy[after], 1.0 + 3.0 * H / (8.0 * LENGTH), relative=0.01),
            Quantity("stress_left", stress[after] / stress.max(), None, 2e-3),
            Quantity("cuts", results.summary["step_cuts"], None, 0)]


def draw(results):
    import matplotlib.pyplot as plt

    figure, (left, right) = plt.subplots(1, 2, figsize=(7.0, 2.6), layout="constrained")
    state = results.state("last")
    x, damage = state["position"][:, 0], state["damage"].ravel()
    order = np.argsort(x)
    away = np.linspace(-0.3, 0.3, 301)
    profile = np.clip(1.0 - abs(away) / (2.0 * LENGTH), 0.0, None) ** 2
    left.plot(1.0 + away, profile, color="0.6", linewidth=3, label="AT1's crack")
    left.plot(x[order], damage[order], ".-", markersize=3, label="computed")
    left.set(xlabel="x (m)", ylabel="damage", xlim=(0.6, 1.4))
    left.legend()
    stress, _ = curves(results)
    right.plot(results.column("time"), stress / 1e6, ".-")
    right.axhline(STRENGTH / 1e6, color="0.6", label="strength of a sound bar")
    right.set(xlabel="time (s)", ylabel="stress (MPa)")
    right.legend()
    return figure


if __name__ == "__main__":
    common.main(check, draw)
