#!/usr/bin/env python3
"""Momentum, angular momentum and energy of two discs that collide."""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
import common  # noqa: E402
from common import Quantity, cells, completed  # noqa: E402


def is_exact(results):
    """Explicit steps with APIC and splines keep angular momentum to rounding."""
    return (results.option("mpm_time_integrator") == "explicit" and results.option("mpm_time_transfer", "apic") == "apic"
            and results.option("mpm_shape").endswith("bspline2"))


def overlap(results, state):
    """How far points at one rim are beyond that of the other disc, in cells: their distances less their depths at the start."""
    first, cell = results.state("first"), 4.0 / cells(results)[0]
    sides = []
    for name in ("left", "right"):
        centre = [float(value) for value in results.option(f"mpm_body_{name}_center").split(",")]
        radius = float(results.option(f"mpm_body_{name}_radius"))
        depth = radius - np.hypot(*(first["position0"] - centre).T)
        rim = (depth > -1e-9) & (depth < cell / 3.0)
        sides.append((state["position"][rim], depth[rim]))
    (left, of_left), (right, of_right) = sides
    return max((of_left + at - np.hypot(*(left - point).T)).max() for point, at in zip(right, of_right)) / cell


def check(results):
    history, first = results.history, results.state("first")
    speed = np.array([float(value) for value in results.option("mpm_body_left_velocity").split(",")])
    scale = 0.5 * first["mass"].sum() * np.hypot(*speed)
    momentum = max(np.abs(history[f"momentum_{axis}"]).max() for axis in "xy") / scale
    angular = history["angular_momentum_z"]
    kinetic = history["energy_kinetic"]
    apart = history["track_right_ux"][-1] - history["track_left_ux"][-1] + 2.4
    return [completed(results),
            Quantity("momentum", momentum, upper=1e-12 if is_exact(results) else 1e-8),
            Quantity("change_of_angular_momentum", np.abs(angular / angular[0] - 1).max(),
                     upper=1e-10 if is_exact(results) else 0.15),
            Quantity("kinetic_energy_after_over_before", kinetic[-1] / kinetic[0], lower=0.5, upper=1.0),
            Quantity("distance_of_middles_at_the_end", apart, lower=0.8),
            Quantity("overlap_in_cells", max(overlap(results, results.state(step)) for step in results.steps), upper=0.2)]


def draw(results):
    import matplotlib.pyplot as plt
    from pictures.plane import draw_body

    figure, axes = plt.subplots(2, 2, figsize=(9, 5.5), constrained_layout=True)
    steps = list(results.steps)
    for axis, step in zip(axes.flat[:3], (steps[0], steps[len(steps) // 2], steps[-1])):
        state = results.state(step)
        speed = np.hypot(*state["velocity"].T)
        dots = draw_body(axis, results, state, speed, ("viridis", 0.0, 0.6))
        axis.set(title=f"t = {state.time:.2f} s", aspect="equal", xlim=(0, 4), ylim=(0, 2))
    figure.colorbar(dots, ax=axes.flat[2], label="speed (m/s)")
    history = results.history
    for name in ("kinetic", "elastic"):
        axes.flat[3].plot(history["time"], history[f"energy_{name}"], label=name)
    axes.flat[3].set(xlabel="time (s)", ylabel="energy (J)")
    axes.flat[3].legend()
    return figure


if __name__ == "__main__":
    common.main(check, draw)
