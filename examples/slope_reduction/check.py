#!/usr/bin/env python3
"""Strength reduction of a slope: the factor of safety against limit analysis, stresses on the reduced surface, and a slide that goes on."""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
import common  # noqa: E402
from common import Quantity  # noqa: E402

SPIRAL = 1.368  # upper bound of a log spiral through the toe, associated flow
SLIDE = 0.75  # m


def parameter(results, name):
    return results.numbers(f"mpm_material_soil_{name}")[0]


def bounds(results):
    """Of the factor of safety: clay against Taylor's 1.47, sand with dilation = friction against a log spiral; less dilation, less."""
    if parameter(results, "friction") == 0.0:
        return 1.42, 1.48
    return (1.32, 1.01 * SPIRAL) if parameter(results, "dilation") == parameter(results, "friction") else (1.25, SPIRAL)


def yield_excess(results):
    """Of the Kirchhoff stress over the reduced planes in the last state, relative to the reduced cohesion, at the worst point."""
    state, factor = results.state("last"), results.column("reduction")[-1]
    sine = np.sin(np.arctan(np.tan(np.radians(parameter(results, "friction"))) / factor))
    limit = 2.0 * parameter(results, "cohesion") / factor * np.sqrt(1.0 - sine**2)
    tau = state["stress"] * np.linalg.det(state["F"].reshape(-1, 3, 3))[:, None]
    full = np.stack([tau[:, [0, 3, 5]], tau[:, [3, 1, 4]], tau[:, [5, 4, 2]]], axis=1)
    low, _, high = np.linalg.eigvalsh(full).T
    return ((high - low + (high + low) * sine) / limit).max() - 1.0


def check(results):
    moved = np.linalg.norm(results.state("last")["displacement"], axis=1).max()
    least, most = bounds(results)
    return [common.completed(results), Quantity("factor_of_safety", results.summary["factor_of_safety"] or np.nan, least, most),
            Quantity("slide", moved, SLIDE), Quantity("yield_excess", yield_excess(results), None, 1e-6)]


def draw(results):
    """How far points move as strength goes, and the slope at the end."""
    import matplotlib.pyplot as plt
    from pictures.plane import draw_body

    figure, (above, below) = plt.subplots(2, 1, figsize=(9.0, 7.6), layout="constrained", height_ratios=(2, 3))
    rows = results.column("stage") == 2
    for name in ("toe", "crest"):
        way = np.hypot(*(results.column(f"track_{name}_u{axis}")[rows] for axis in "xy"))
        above.semilogy(results.column("reduction")[rows], way, label=name)
    above.axvline(results.summary["factor_of_safety"], color="black", linewidth=0.8, linestyle="--", label="factor of safety")
    if parameter(results, "friction") > 0.0:
        above.axvline(SPIRAL, color="grey", linewidth=0.8, label="log spiral")
    above.set(xlabel="F", ylabel="displacement (m)")
    above.legend()
    state = results.state("last")
    dots = draw_body(below, results, state, np.linalg.norm(state["displacement"], axis=1))
    figure.colorbar(dots, ax=below, label="displacement (m)")
    below.set(title=f"F = {results.column('reduction')[-1]:.2f}", aspect="equal", xlabel="x (m)", ylabel="y (m)")
    return figure


if __name__ == "__main__":
    common.main(check, draw)
