#!/usr/bin/env python3
"""Mud against a barrier: impulses on barrier and ground account for the change of momentum; run-up; the window's mass.

PREFIX is that of case.yaml or barrier.yaml.
"""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
import common  # noqa: E402
from common import Quantity, completed  # noqa: E402
from make import bed  # noqa: E402
from results import Results  # noqa: E402

G = 9.81


def impulse(history, name, axis):
    return (history[f"reaction_{name}_{axis}"] * history["dt"])[1:].sum()


def entered(results):
    """Mass and x-momentum of the columns that came into the window after the first state, up to the end."""
    flow = Results(results.option("mpm_body_flow_file").removesuffix(".h5"))
    lower, upper = results.numbers("mpm_grid_lower")[:2], results.numbers("mpm_grid_upper")[:2]
    first, known, total = int(results.option("mpm_body_flow_step")), set(), np.zeros(2)
    start = next(flow.state(step).time for step in flow.steps if int(step) == first)
    for step in flow.steps:
        state = flow.state(step)
        if int(step) < first or state.time - start >= results.history["time"][-1]:
            continue
        inside = ((state["position"] > lower) & (state["position"] < upper)).all(axis=1)
        for row in np.flatnonzero(inside):
            if int(state["id"].ravel()[row]) in known:
                continue
            known.add(int(state["id"].ravel()[row]))
            if int(step) > first:
                mass = state["mass"].ravel()[row]
                total += mass, mass * state["velocity"][row, 0]
    return total


def run_up(results):
    """Height of the highest point within two cells before the barrier, above the ground at its foot, of all states."""
    face, cell = results.numbers("mpm_boundary_barrier_lower")[0], results.numbers("mpm_grid_upper")[0] - results.numbers("mpm_grid_lower")[0]
    cell /= common.cells(results)[0]
    best = 0.0
    for step in results.steps:
        x = results.state(step)["position"]
        near = (x[:, 0] > face - 2 * cell) & (x[:, 0] <= face)
        if near.any():
            best = max(best, (x[near, 2] - bed(np.full(near.sum(), face), x[near, 1])).max())
    return best


def force(history, span=0.1):
    """Force on the barrier along x, mean over spans of time, N."""
    edges = np.arange(0.0, history["time"][-1], span)
    total, _ = np.histogram(history["time"], edges, weights=-history["reaction_barrier_x"] * history["dt"])
    return 0.5 * (edges[1:] + edges[:-1]), total / span


def against(results):
    history, state = results.history, results.state("last")
    change = history["momentum_x"][-1] - history["momentum_x"][0]
    mass, momentum = entered(results)
    barrier, ground = impulse(history, "barrier", "x"), impulse(history, "ground", "x")
    handed = results.summary["handover"]["flow"]
    weight = state["mass"].sum() - mass
    return [Quantity.near("impulse", -barrier, ground + momentum - change, relative=0.01),
            Quantity.near("mass", state["mass"].sum(), handed["mass"] + mass, relative=1e-12),
            Quantity.near("window", handed["mass"], weight, relative=1e-12),
            Quantity("peak_force", force(history)[1].max(), 1.5e7, 4.5e7),
            Quantity("run_up", run_up(results), 10.0, 16.0)]


def check(results):
    if results.summary["dim"] == 2:
        mass = results.state("last")["mass"].sum()
        return [completed(results), Quantity.near("mass", mass, results.state("first")["mass"].sum(), relative=1e-12)]
    return [completed(results), *against(results)]


def draw(results):
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(2, 1, figsize=(7.0, 5.0), layout="constrained")
    times, values = force(results.history)
    at = times[values.argmax()]
    state = min((results.state(step) for step in results.steps), key=lambda state: abs(state.time - at))
    x = np.linspace(*(bound[0] for bound in (results.numbers("mpm_grid_lower"), results.numbers("mpm_grid_upper"))), 100)
    axes[0].fill_between(x, bed(x, 100.0), 10.0, color="0.85")
    box = [results.numbers(f"mpm_boundary_barrier_{end}") for end in ("lower", "upper")]
    axes[0].fill_between([box[0][0], box[1][0]], box[1][2], 10.0, color="0.5")
    middle = abs(state["position"][:, 1] - 100.0) < 10.0
    points = axes[0].scatter(state["position"][middle, 0], state["position"][middle, 2], 3, np.linalg.norm(state["velocity"][middle], axis=1))
    figure.colorbar(points, ax=axes[0], label="speed (m/s)")
    axes[0].set(xlabel="x (m)", ylabel="z (m)", title=f"{state.time:.1f} s after the hand-over, middle 20 m")
    axes[1].plot(times, values / 1e6)
    axes[1].set(xlabel="t (s)", ylabel="force on the barrier (MN)")
    return figure


if __name__ == "__main__":
    common.main(check, draw)
