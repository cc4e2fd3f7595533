#!/usr/bin/env python3
"""Stages under water: a layer is dug away under open water, put down there, or put on ground whose table is at its surface; the water's
excess pressure and what flows out follow the series of one-dimensional consolidation, on any number of ranks and over a restart.
And a table that is lowered bit by bit.

Quick.
"""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import Test, difference  # noqa: E402

SCENE = Path(__file__).resolve().parent / "wet_stages.yaml"
WATER, SOIL, WIDTH, GROUND, TOP = 1e4, 2e4, 0.25, 2.0, 3.0  # N/m3; m
MODULUS = 1e7 * 0.7 / (1.3 * 0.4)
DIFFUSIVITY = 1e-12 / 1e-3 * MODULUS
FILL = {"mpm_stage_rest_surfaces": "ground"}


class Column:
    """Excess pressure above a sealed base, drained at the height `top`, from a first one that is straight between heights."""

    def __init__(self, top, heights, pressures):
        y = np.linspace(0.0, top, 20001)
        y = 0.5 * (y[1:] + y[:-1])
        self.root = (np.arange(300) + 0.5) * np.pi / top
        self.part = 2.0 / len(y) * np.cos(np.outer(self.root, y)) @ np.interp(y, heights, pressures)

    def excess(self, y, time):
        return np.cos(np.outer(y, self.root)) @ (self.part * np.exp(-self.root**2 * DIFFUSIVITY * time))

    def outflow(self, time):
        """By area: the fall of the mean pressure over the modulus."""
        gone = 1.0 - np.exp(-np.outer(time, self.root**2 * DIFFUSIVITY))
        return gone @ (self.part * np.sin(self.root * np.pi / (2.0 * self.root[0])) / self.root) / MODULUS


def follows(test, label, run, column, surface, level, height):
    """Pressures at all points and what has passed the surface, from the second step on; `height`: of the saturated ground."""
    results, load, worst = run.results, np.max(np.abs(column.excess(np.array([0.0]), 0.0))), 0.0
    for step in results.steps[2:]:
        state = results.state(step)
        rows = state["position"][:, 1] < height
        place = state["position"][rows, 1]
        excess = state["pressure"][rows] - WATER * (level - place)
        worst = max(worst, np.max(np.abs(excess - column.excess(place, state.time - 1.0))))
    test.check(f"{label}.pressure", worst / load, None, 0.015)
    time, passed = results.column("time") - 1.0, results.column(f"outflow_{surface}") / WIDTH
    wrong = np.abs(passed - passed[0] - column.outflow(time))[2:]
    test.check(f"{label}.outflow", np.max(wrong) / np.max(np.abs(column.outflow(time))), None, 0.01)


def dig(test):
    """Under open water: the ground loses the buoyant weight above it, and takes up water."""
    column = Column(GROUND, [0, GROUND], [-(SOIL - WATER)] * 2)
    alone = test.run(SCENE, mpm_checkpoint_every=20)
    follows(test, "dig", alone, column, "ground", 3.5, GROUND)
    rises = np.max(alone.table("displacement")[:, 1])
    test.near("dig.rises", rises, (SOIL - WATER) * GROUND / MODULUS * (1 - 0.0625 / 2), 0.01)
    y = alone.table("position")[:, 1]
    test.near("dig.stress", np.mean(alone.table("stress")[:, 1]), -(SOIL - WATER) * np.mean(GROUND - y), 0.01)
    several = test.run(SCENE, ranks=3)
    test.check("dig_on_3.same", difference(alone.table("pressure"), several.table("pressure")), None, 1e-9)
    again = test.run(SCENE, ranks=2, mpm_restart=min(alone.folder.glob("work_checkpoint_*.h5")))
    test.check("dig_again.same", difference(alone.table("pressure"), again.table("pressure")), None, 1e-9)


def fill(test):
    """A lift that is put down under water brings its buoyant weight, and drains at its own top; on a table at the surface all of its
    weight."""
    text = SCENE.read_text(encoding="utf-8").replace("remove: layer, surfaces: ground", "bodies: layer, surfaces: layer")
    scene = test.folder() / "fill.yaml"
    scene.write_text(text, encoding="utf-8")
    wet = test.run(scene, **FILL, mpm_stage_work_time_end=1500)
    load = SOIL - WATER
    follows(test, "wet", wet, Column(TOP, [0, GROUND, TOP], [load, load, 0.0]), "layer", 3.5, TOP)
    test.near("wet.sinks", -np.min(wet.table("displacement")[:, 1]), load * (GROUND + 0.5) / MODULUS, 0.03)
    y = wet.table("position")[:, 1]
    test.near("wet.stress", np.mean(wet.table("stress")[:, 1]), -load * np.mean(TOP - y), 0.01)
    dry = test.run(scene, **FILL, mpm_water_level=2)
    column = Column(GROUND, [0, GROUND], [SOIL, SOIL])
    worst = 0.0
    for step in dry.results.steps[2:]:
        state = dry.results.state(step)
        place = state["position"][:, 1]
        wanted = np.where(place < GROUND, WATER * (2.0 - place) + column.excess(place, state.time - 1.0), 0.0)
        worst = max(worst, np.max(np.abs(state["pressure"] - wanted)))
    test.check("dry.pressure", worst / SOIL, None, 0.015)
    ground = dry.table("position")[:, 1] < GROUND
    test.near("dry.sinks", -np.min(dry.table("displacement")[ground, 1]), SOIL * GROUND / MODULUS * (1 - 0.0625 / 2), 0.015)
    test.near("dry.stress", np.mean(dry.table("stress")[~ground, 1]), -SOIL * 0.5, 0.02)
    test.near("dry.force", dry.results.column("reaction_base_y")[-1], SOIL * TOP * WIDTH, 1e-3)


def lower(test):
    """A table that falls by a metre within the ground, in time with the run: what becomes dry no longer floats."""
    lines = [line for line in SCENE.read_text(encoding="utf-8").splitlines() if "surface_ground" not in line]
    scene = test.folder() / "lower.yaml"
    scene.write_text("\n".join(lines).replace("remove: layer, surfaces: ground, ", "") + "\n", encoding="utf-8")
    run = test.run(scene, mpm_water_level=3, mpm_water_ramp="1:1,601:0.66666666666666663", mpm_stage_work_time_end=3000)
    last = run.results.state("last")
    place = last["position"][:, 1]
    test.check("lower.pressure", np.max(np.abs(last["pressure"] - WATER * np.maximum(2.0 - place, 0))) / (WATER * TOP), None, 2e-3)
    wanted = -SOIL * (TOP - place) + WATER * np.maximum(2.0 - place, 0)
    test.check("lower.stress", np.max(np.abs(last["stress"][:, 1] - wanted)) / (SOIL * TOP), None, 0.03)
    test.near("lower.mean", np.mean(last["stress"][:, 1]), np.mean(wanted), 5e-3)  # small strain: heights are initial ones
    test.near("lower.force", run.results.column("reaction_base_y")[-1], SOIL * TOP * WIDTH, 1e-3)


def main():
    with Test() as test:
        dig(test)
        fill(test)
        lower(test)


if __name__ == "__main__":
    main()
