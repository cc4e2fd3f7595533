#!/usr/bin/env python3
"""Relaxation of an elastic bar: where it comes to rest, when velocities are reset, and when the criteria hold."""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
import common  # noqa: E402
from common import Quantity  # noqa: E402

FIRST_RESET = 10.28  # for points that stay where they are


def parameters(results):
    load, modulus = results.numbers("mpm_load_pull_value")[0], results.numbers("mpm_material_bar_E")[0]
    return load, load / modulus * results.numbers("mpm_track_middle_at")[0]


def times(results):
    """When both criteria hold first, and since when they do without a break, from the columns; the summary says the same."""
    tolerance = results.numbers("mpm_stage_rest_relaxation_tolerance")[0]
    time = results.column("time")
    good = (results.column("K_F") < tolerance) & (results.column("K_E") < tolerance)
    return (time[good][0] if good.any() else np.nan), (time[~good][-1] if good[-1] else np.nan)


def resets(results):
    """Times of the resets."""
    return results.column("time")[1:][np.diff(results.column("resets")) > 0]


def peaks(results):
    """The largest kinetic energy before each reset."""
    number, energy = results.column("resets").astype(int), results.column("energy_kinetic")
    return np.array([energy[number == k].max() for k in range(number[-1])])


def check(results):
    load, displacement = parameters(results)
    state = results.state("last")
    middle = np.argmin(np.abs(state["position"][:, 0] - state["displacement"][:, 0] - results.numbers("mpm_track_middle_at")[0]))
    stretch = state["F"].reshape(-1, 3, 3)[middle, 0, 0]  # a cell holds as many points as at the start: J sigma balances the load
    first, always = times(results)
    at_once = results.option("mpm_stage_rest_relaxation_damping") == "kinetic" and results.option("mpm_stage_rest_time_update") == "musl"
    quantities = [common.completed(results),
                  Quantity.near("displacement", results.column("track_middle_ux")[-1], displacement, relative=1e-3),
                  Quantity.near("stress", state["stress"][middle, 0] * stretch, load, relative=1e-3),
                  Quantity.near("cauchy_stress", state["stress"][middle, 0], load, relative=1e-3 if at_once else 2e-3),
                  Quantity("first", first, 0.0), Quantity("always", always, first),
                  Quantity.near("summary_first", results.summary["criteria_first"], first, absolute=1e-6),
                  Quantity.near("summary_since", results.summary["criteria_since"], always, absolute=1e-6)]
    if results.option("mpm_stage_rest_relaxation_damping") == "kinetic":
        heights = peaks(results)
        quantities += [Quantity.near("first_reset", resets(results)[0], FIRST_RESET, absolute=0.05),
                       Quantity("second_peak_over_first", heights[1] / heights[0], None, 0.5),
                       Quantity("last_peak_over_first", heights[-1] / heights[0], None, 1e-2)]
    return quantities


def draw(results):
    """Displacement of the middle, and the criteria, over time."""
    import matplotlib.pyplot as plt

    time = results.column("time")
    _, displacement = parameters(results)
    figure, (above, below) = plt.subplots(2, 1, figsize=(8.0, 6.4), sharex=True, layout="constrained")
    above.plot(time, results.column("track_middle_ux") / displacement)
    above.axhline(1.0, color="black", linewidth=0.8, linestyle="--", label="static")
    above.set_ylabel("displacement of the middle / static")
    above.legend()
    for name in ("K_F", "K_E"):
        below.semilogy(time, np.maximum(results.column(name), 1e-8), label=name)
    below.axhline(results.numbers("mpm_stage_rest_relaxation_tolerance")[0], color="black", linewidth=0.8, linestyle="--")
    below.set(xlabel="time", ylabel="criteria")
    below.legend()
    return figure


if __name__ == "__main__":
    common.main(check, draw)
