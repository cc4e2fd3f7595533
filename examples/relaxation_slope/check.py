#!/usr/bin/env python3
"""A slope that finds its angle of repose: both criteria, the face it ends with, its area, and how the peaks of its energy decay."""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
import common  # noqa: E402
from common import Quantity, completed  # noqa: E402

HEIGHT, REPOSE, TOE, CREST = 40.0, 20.0, 149.6, 39.7  # m, degrees, m, m: the same area under an even face at the angle of friction


def spacing(results):
    lower, upper = results.numbers("mpm_grid_lower"), results.numbers("mpm_grid_upper")
    return (upper[0] - lower[0]) / common.cells(results)[0]


def heights(results):
    """Middles of the columns of cells, and how high their material would stand."""
    state, h = results.state("last"), spacing(results)
    column = (state["position"][:, 0] / h).astype(int)
    area = np.bincount(column, weights=state["volume"], minlength=common.cells(results)[0])
    return (np.arange(area.size) + 0.5) * h, area / h


def face(results):
    """The straight line through the face, between a tenth and nine tenths of the height: its angle, its toe and its crest."""
    x, height = heights(results)
    middle = (height > 0.1 * HEIGHT) & (height < 0.9 * HEIGHT)
    slope, at = np.polyfit(x[middle], height[middle], 1)
    return np.degrees(np.arctan(-slope)), -at / slope, (HEIGHT - at) / slope


def unloaded(results):
    """The area that is left once the elastic compression is taken out, over that of the start."""
    modulus, ratio = results.numbers("mpm_material_soil_E")[0], results.numbers("mpm_material_soil_nu")[0]
    state = results.state("last")
    pressure = -state["stress"][:, :3].mean(axis=1)
    return (state["volume"] * np.exp(pressure * 3.0 * (1.0 - 2.0 * ratio) / modulus)).sum() / results.initial["volume"].sum()


def peaks(results):
    """The largest kinetic energy before each reset."""
    number, energy = results.column("resets").astype(int), results.column("energy_kinetic")
    return np.array([energy[number == k].max() for k in range(number[-1])])


def check(results):
    tolerance = results.numbers("mpm_stage_slide_relaxation_tolerance")[0]
    angle, toe, crest = face(results)
    state, heights_of_peaks = results.state("last"), peaks(results)
    return [completed(results), Quantity("K_F", results.column("K_F")[-1], None, tolerance),
            Quantity("K_E", results.column("K_E")[-1], None, tolerance),
            Quantity.near("angle_of_repose", angle, REPOSE, absolute=1.5), Quantity.near("toe", toe, TOE, absolute=4.0),
            Quantity.near("crest", crest, CREST, absolute=4.0),
            Quantity.near("area_unloaded", unloaded(results), 1.0, absolute=1e-3 if spacing(results) <= 2.0 else 2e-3),
            Quantity.near("area", state["volume"].sum() / results.initial["volume"].sum(), 1.0, absolute=8e-3),
            Quantity("last_peak_over_first", heights_of_peaks[-1] / heights_of_peaks[0], None, 0.01 if spacing(results) <= 2.0 else 0.02)]


def draw(results):
    """The slope at the end, and the criteria over time."""
    import matplotlib.pyplot as plt
    from pictures.plane import draw_body

    figure, (above, below) = plt.subplots(2, 1, figsize=(9.0, 6.0), layout="constrained")
    state = results.state("last")
    dots = draw_body(above, results, state, np.linalg.norm(state["displacement"], axis=1))
    above.plot([0, 60, 60 + HEIGHT * np.sqrt(3)], [HEIGHT, HEIGHT, 0], color="k", linewidth=0.8, label="before")
    above.plot([CREST, TOE], [HEIGHT, 0], color="r", linewidth=0.8, linestyle="--", label="20 degrees, same area")
    figure.colorbar(dots, ax=above, label="displacement (m)")
    above.set(aspect="equal", xlabel="x (m)", ylabel="y (m)", xlim=(0, 170), ylim=(0, 44))
    above.legend()
    time = results.column("time")
    for name in ("K_F", "K_E"):
        below.semilogy(time, np.maximum(results.column(name), 1e-6), linewidth=0.7, label=name)
    below.axhline(results.numbers("mpm_stage_slide_relaxation_tolerance")[0], color="k", linewidth=0.8, linestyle="--")
    below.set(xlabel="time (s)", ylabel="criteria")
    below.legend()
    return figure


if __name__ == "__main__":
    common.main(check, draw)
