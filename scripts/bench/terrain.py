"""Nanoseconds a point and step of flow over terrain, with and without maps of largest values; error against seconds.

Scene scripts/bench/terrain.yaml: bed from a map, friction, 3 x 3 points a cell. Set-up and output are taken off by runs
of two lengths; a block of a solid in explicit steps, of as many points, takes turns with them. Error: the mean error of
the depth of a dam break (examples/ritter) by the cells in sqrt(g h) t, with the seconds of the run. `--alr FOLDER`: an
avalanche against com1DFA's result, in place of these (terrain_alr.py).
"""
import statistics
import tempfile
from pathlib import Path

import numpy as np

from bench import terrain_alr
from bench.runs import ROOT, Table, in_turn, median, run_scene
from maps import read_map, write_ascii

SCENE = Path(__file__).resolve().parent / "terrain.yaml"
SOLID = Path(__file__).resolve().parent / "dynamics_block.yaml"
GRAVITY = 9.81


def add_arguments(parser):
    parser.set_defaults(ranks=1)
    parser.add_argument("--alr", type=Path, metavar="FOLDER", help="com1DFA's test case avaAlr, with its stored result")


def write_bed(folder):
    x, y = np.arange(-8.0, 2008.1, 8.0), np.arange(-8.0, 1208.1, 8.0)
    X, Y = np.meshgrid(x, y)
    write_ascii(folder / "bed.asc", x, y, 900 - 0.35 * X + 0.0004 * (Y - 600) ** 2 + 3 * np.sin(X / 40) * np.cos(Y / 47))
    (folder / SCENE.name).write_text(SCENE.read_text(encoding="utf-8"), encoding="utf-8")
    return folder / SCENE.name


def each(long, short):
    """Nanoseconds a point and step, from runs of two lengths; medians."""
    return statistics.median(
        1e9 * (one["time_total_s"] - one["time"]["output"] - other["time_total_s"] + other["time"]["output"])
        / ((one["steps"] - other["steps"]) * one["points"]) for one, other in zip((run.summary for run in long), (run.summary for run in short)))


def steps(arguments, folder):
    table = Table(arguments.out, "terrain", ("case", "ranks", "points", "steps", "ns_each", "over_solid"))
    scene, end = write_bed(folder), 8.0 if arguments.quick else 20.0
    block = {"mpm_grid_cells": "150,150", "mpm_shape": "gimp", "mpm_body_b_points_per_cell": "2,2", "mpm_time_integrator": "explicit",
             "mpm_output_history": 1000000}
    cases = {"solid": (SOLID, block, (0.05, 0.005)), "flow": (scene, {}, (end, 1.5)), "flow with maps": (scene, {"mpm_maps_every": 0}, (end, 1.5))}
    kinds = [(name, length) for name in cases for length in cases[name][2]]
    runs = in_turn(arguments.repeat or (1 if arguments.quick else 3), [
        lambda name=name, length=length: run_scene(arguments.program, cases[name][0], {**cases[name][1], "mpm_time_end": length},
                                                   arguments.ranks) for name, length in kinds])
    found = {name: each(*(runs[kinds.index((name, length))] for length in cases[name][2])) for name in cases}
    for name, value in found.items():
        first = runs[kinds.index((name, cases[name][2][0]))][0]
        table.add(case=name, ranks=arguments.ranks, points=first["points"], steps=first["steps"], ns_each=value,
                  over_solid=value / found["solid"])


def error_of(prefix):
    last, wave = read_map(f"{prefix}_peak"), np.sqrt(GRAVITY)
    exact = (2 * wave - np.clip(last.x, -wave, 2 * wave)) ** 2 / (9 * GRAVITY)
    return float(abs(last.bands["deposit"][0] - exact).sum() * (last.x[1] - last.x[0]) / wave)


def errors(arguments, folder):
    table = Table(arguments.out, "terrain_error", ("cells_in_wave", "steps", "error", "total_s"))
    text = (ROOT / "examples" / "ritter" / "case.yaml").read_text(encoding="utf-8")
    counts = (120, 240) if arguments.quick else (120, 240, 480, 960)
    for count in counts:
        scene = folder / f"ritter{count}.yaml"
        scene.write_text(text.replace("240,1", f"{count},1").replace(",0.05", f",{12 / count}"), encoding="utf-8")
        runs = in_turn(arguments.repeat or 1, [lambda path=scene: run_scene(arguments.program, path, {}, measure=error_of)])[0]
        table.add(cells_in_wave=count / 12 * float(np.sqrt(GRAVITY)), steps=runs[0]["steps"], error=runs[0].value,
                  total_s=median(runs, "time_total_s"))


def run(arguments):
    with tempfile.TemporaryDirectory() as name:
        if arguments.alr:
            terrain_alr.run(arguments, Path(name))
            return
        steps(arguments, Path(name))
        errors(arguments, Path(name))
