#!/usr/bin/env python3
"""Holds a strip between two rollers against equilibrium, the conservation of volume and the theory of rolling."""
import sys
from pathlib import Path

import numpy as np

FOLDER = Path(__file__).resolve().parent
sys.path.insert(0, str(FOLDER.parent))
import common  # noqa: E402
from common import Quantity  # noqa: E402

STEADY = 0.4  # s: from here on the strip is rolled steadily
STATE = 0.65  # of the run: there is strip on both sides of the rollers
BALANCE = 1e-6  # of a roller's force
VOLUME = 0.03  # of the flow
SLIP = 0.12  # exit faster, entry slower than the rollers, at most
FORCE = 1.4  # over sigma L: uniform compression without friction is 1
ARM = (0.35, 0.55)  # of the length of contact
NOISE = 0.08  # standard deviation of the force over its mean, times h/0.025 m
NEWTON, CUTS = 7.5, 6  # a step, 5.5 at 25 mm; in all in cells twice as large, none at 25 mm


def table(results, roller):
    return common.read_table(FOLDER / f"{roller}.csv")


def flow(results):
    """Speed and thickness of the strip before and behind the rollers, from two states a little apart: rows of two numbers."""
    states = results.steps[: int(STATE * len(results.steps))]
    first, last = results.state(states[-6]), results.state(states[-1])
    middle = results.numbers("mpm_boundary_upper_center")[0]
    place, way = last["position"], last["displacement"] - first["displacement"]
    rows = []
    for lower, upper in ((middle - 0.35, middle - 0.2), (middle + 0.2, middle + 0.35)):
        inside = (place[:, 0] > lower) & (place[:, 0] < upper)
        rows.append([np.mean(way[inside, 0]) / (last.time - first.time), np.sum(last["volume"][inside]) / (upper - lower)])
    return np.array(rows)


def theory(results):
    """Length of contact and force a metre: the strip's flow stress, on average, over that length."""
    radius = results.numbers("mpm_boundary_upper_radius")[0]
    start = 2.0 * results.numbers("mpm_body_strip_upper")[1]
    draught = -2.0 * table(results, "upper")["uy"][-1]
    strain = 2.0 / np.sqrt(3.0) * np.log(start / (start - draught))
    stress = results.numbers("mpm_material_metal_yield_stress")[0] + 0.5 * strain * results.numbers("mpm_material_metal_hardening")[0]
    length = np.sqrt(radius * draught)
    return length, 2.0 / np.sqrt(3.0) * stress * length


def check(results):
    steady = results.column("time") >= STEADY
    force = {name: np.column_stack([results.column(f"reaction_{name}_{axis}") for axis in "xy"])[steady] for name in ("upper", "lower")}
    down = np.abs(force["upper"][:, 1])
    turn = np.abs(results.column("moment_upper_z"))[steady]
    radius = results.numbers("mpm_boundary_upper_radius")[0]
    rows = table(results, "upper")
    speed = radius * np.radians(rows["rz"][-1] - rows["rz"][-2]) / (rows["time"][-1] - rows["time"][-2])
    (entry, before), (leave, behind) = flow(results)
    length, expected = theory(results)
    lower, upper = (np.array(results.numbers(f"mpm_grid_{end}")) for end in ("lower", "upper"))
    cell = np.max((upper - lower) / common.cells(results))
    steps = results.column("step").size
    return [common.completed(results),
            Quantity("balance", np.max(np.hypot(*(force["upper"] + force["lower"]).T)) / np.mean(down), None, BALANCE),
            Quantity("along", np.max(np.abs(force["upper"][:, 0])) / np.mean(down), None, 1e-2),
            Quantity.near("flow_out_over_in", leave * behind / (entry * before), 1.0, absolute=VOLUME),
            Quantity("entry_over_rollers", entry / speed, 1.0 - SLIP, 1.0),
            Quantity("exit_over_rollers", leave / speed, 1.0, 1.0 + SLIP),
            Quantity("force_over_theory", np.mean(down) / expected, 1.0, FORCE),
            Quantity("lever_arm", np.mean(turn) / (np.mean(down) * length), *ARM),
            Quantity("noise", np.std(down) / np.mean(down), None, NOISE * cell / 0.025),
            Quantity("newton_a_step", np.sum(results.column("newton")) / steps, None, NEWTON),
            Quantity("cuts", np.sum(results.column("cuts")), None, CUTS if cell > 0.03 else 0)]


def draw(results):
    """The strip at the end, and force and torque over time."""
    import matplotlib.pyplot as plt
    from pictures.plane import draw_plane

    figure = plt.figure(figsize=(12.0, 4.2), layout="constrained")
    left, right = figure.subfigures(1, 2, width_ratios=(1.6, 1.0))
    state = results.state("last")
    strain = state["equivalent_plastic_strain"]
    axes, body = draw_plane(left, results, state, strain, ("viridis", 0.0, np.percentile(strain, 99.5)), True)
    left.colorbar(body, ax=axes, shrink=0.8, label="equivalent plastic strain")
    for name in ("upper", "lower"):
        center = np.array(results.numbers(f"mpm_boundary_{name}_center"))
        rows = table(results, name)
        center[1] += np.interp(results.column("time")[-1], rows["time"], rows["uy"])
        radius = results.numbers(f"mpm_boundary_{name}_radius")[0]
        angle = np.radians(np.interp(results.column("time")[-1], rows["time"], rows["rz"]))
        axes.add_patch(plt.Circle(center, radius, fill=False, color="0.2"))
        for k in range(4):
            end = center + radius * np.array([np.cos(angle + k * np.pi / 2), np.sin(angle + k * np.pi / 2)])
            axes.plot([center[0], end[0]], [center[1], end[1]], color="0.6", linewidth=0.8)
    axes.set(xlim=(0.4, 2.4), ylim=(-0.75, 0.75))

    axes = right.add_subplot()
    length, expected = theory(results)
    time = results.column("time")
    axes.plot(time, np.abs(results.column("reaction_upper_y")) / 1e6, color="tab:blue", label="force of a roller (MN/m)")
    axes.axhline(expected / 1e6, color="tab:blue", linestyle="--", label="flow stress times contact length")
    axes.plot(time, np.abs(results.column("moment_upper_z")) / 1e5, color="tab:orange", label="torque (100 kN m/m)")
    axes.set(xlabel="time (s)", ylim=(0.0, None))
    axes.grid(alpha=0.3)
    axes.legend()
    return figure


if __name__ == "__main__":
    common.main(check, draw)
