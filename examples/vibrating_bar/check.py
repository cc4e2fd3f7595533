#!/usr/bin/env python3
"""Compares the vibration of a bar under a sudden weight with d'Alembert's solution."""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
import common  # noqa: E402
from common import Quantity, cells, completed  # noqa: E402

LENGTH = 10.0


def material(results):
    return [float(results.option(f"mpm_material_bar_{name}")) for name in ("E", "density")]


def weight(results):
    return float(results.option("mpm_load_weight_value").split(",")[0])


def tip(results, time):
    """Displacement of the tip: parabolas that follow one another in a period of 4 L/c."""
    young, density = material(results)
    quarter = LENGTH / np.sqrt(young / density)
    phase = np.mod(time / quarter, 4.0)
    back = np.minimum(phase, 4.0 - phase)  # 0 to 2 and back
    most = density * weight(results) * LENGTH**2 / young
    return most * np.where(back < 1.0, 0.5 * back**2, 1.0 - 0.5 * (2.0 - back) ** 2)


def period(time, value):
    """Mean time between two passages upwards through half of the largest displacement."""
    level = value - 0.5 * (value.max() + value.min())
    up = np.flatnonzero((level[:-1] < 0) & (level[1:] >= 0))
    passages = time[up] - level[up] * (time[up + 1] - time[up]) / (level[up + 1] - level[up])
    return np.diff(passages).mean()


def check(results):
    history = results.history
    young, density = material(results)
    exact = 4.0 * LENGTH / np.sqrt(young / density)
    fine = cells(results)[0] >= 80
    error = np.abs(history["track_tip_ux"] - tip(results, history["time"])).max() / tip(results, 0.5 * exact)
    lost = history["energy_kinetic"] + history["energy_elastic"] - history["energy_external"]
    return [completed(results),
            Quantity.near("period", period(history["time"], history["track_tip_ux"]), exact,
                          relative=1e-3 if fine else 1e-2),
            Quantity("largest_error_of_displacement", error, upper=0.004 if fine else 0.1),
            Quantity("energy_lost", np.abs(lost).max() / history["energy_kinetic"].max(), upper=1e-4 if fine else 1e-2)]


def draw(results):
    import matplotlib.pyplot as plt

    history = results.history
    figure, axis = plt.subplots(figsize=(8, 4), constrained_layout=True)
    time = np.linspace(0, history["time"][-1], 2000)
    axis.plot(time, 1e3 * tip(results, time), color="0.6", linewidth=4, label="exact")
    axis.plot(history["time"], 1e3 * history["track_tip_ux"], color="C3", linewidth=1, label="computed")
    axis.set_xlabel("time (s)")
    axis.set_ylabel("displacement of the tip (mm)")
    axis.legend()
    return figure


if __name__ == "__main__":
    common.main(check, draw)
