#!/usr/bin/env python3
"""A slope's slide: how far it goes, that it comes to rest in a state that is in equilibrium, and the energy on the way."""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
import common  # noqa: E402
from common import Quantity, completed  # noqa: E402


def rows(results, stage):
    return results.column("stage") == stage


def way(results, name):
    return np.hypot(*(results.column(f"track_{name}_u{axis}") for axis in "xy"))


def check(results):
    fail, settle = rows(results, 2), rows(results, 3)
    crest, toe = way(results, "crest"), way(results, "toe")
    kinetic = results.column("energy_kinetic")[fail]
    balance = np.abs(results.column("energy_balance")[fail]).max() / results.column("energy_external")[fail].max()
    area = results.state("last")["volume"].sum() / results.initial["volume"].sum()
    settled = max(abs(one[settle][-1] - one[fail][-1]) for one in (crest, toe))
    return [completed(results), Quantity("crest", crest[fail][-1], 4.5, 8.0), Quantity("toe", toe[fail][-1], 4.0, 8.0),
            Quantity("most_kinetic_energy", kinetic.max(), 2e5, 5e5), Quantity("left_of_it", kinetic[-1] / kinetic.max(), None, 0.01),
            Quantity("energy_missing", balance, None, 0.03), Quantity("settles", settled, None, 0.05),
            Quantity.near("area", area, 1.0, absolute=0.01)]


def draw(results):
    """The slope at the end, where its points come from, and its slide in time."""
    import matplotlib.pyplot as plt
    from pictures.plane import draw_body

    figure, (above, below) = plt.subplots(2, 1, figsize=(9.0, 6.0), layout="constrained", height_ratios=(1, 1.2))
    state = results.state("last")
    dots = draw_body(above, results, state, np.linalg.norm(state["displacement"], axis=1))
    above.plot([0, 17, 37, 60], [15, 15, 5, 5], color="k", linewidth=0.8)
    figure.colorbar(dots, ax=above, label="displacement (m)", shrink=0.8)
    above.set(aspect="equal", xlabel="x (m)", ylabel="y (m)")
    fail = rows(results, 2)
    time = results.column("time")[fail] - results.column("time")[fail][0]
    for name in ("crest", "toe"):
        below.plot(time, way(results, name)[fail], label=name)
    below.set(xlabel="time (s)", ylabel="displacement (m)")
    energy = below.twinx()
    energy.plot(time, 1e-3 * results.column("energy_kinetic")[fail], color="0.6", label="kinetic energy (right)")
    energy.set_ylabel("kinetic energy (kJ/m)")
    energy.set_ylim(bottom=0.0)
    below.set_ylim(bottom=0.0)
    lines = below.get_lines() + energy.get_lines()
    below.legend(lines, [line.get_label() for line in lines], loc="center right")
    return figure


if __name__ == "__main__":
    common.main(check, draw)
