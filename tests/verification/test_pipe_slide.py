#!/usr/bin/env python3
"""A pipe that is pulled through clay by half its diameter: the clay flows along the surface, and the resistance stays.

Quick.
"""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import Test, difference, example  # noqa: E402

THEORY = {"stick": 4.0 * np.sqrt(2.0) + 2.0 * np.pi, "frictionless": 9.20117}  # over s_u D: examples/pipe/README.md
STRENGTH = 10e3
WAY, STEPS, DEPTH = 0.5, 50, 0.25
RANKS = 1e-9  # between numbers of ranks


def resistance(run):
    """Displacement, and the whole pipe's resistance over s_u D."""
    return WAY * run.results.column("time"), 2.0 * run.results.column("reaction_pipe_x") / STRENGTH


def slab(folder):
    """The scene of a slab of the plane between two planes, and its options."""
    places = {"grid": ("-3,0", "4,3"), "bc_symmetry": ("-3,0", "4,0"), "bc_rim": ("-3,3", "4,3"), "bc_left": ("-3,0", "-3,3"),
              "bc_right": ("4,0", "4,3"), "bc_ends": ("-3,0", "4,3")}
    options = {f"mpm_{name}_{end}": f"{place},{depth}" for name, ends in places.items()
               for end, place, depth in zip(("lower", "upper"), ends, (0, DEPTH))}
    scene = Path(folder) / "slab.yaml"
    text = example("pipe").read_text(encoding="utf-8")
    scene.write_text(text.replace('type: sphere, center: "0,0"', 'type: cylinder, point: "0,0,0"'), encoding="utf-8")
    return scene, {**options, "mpm_dim": 3, "mpm_grid_cells": "28,12,1", "mpm_body_ground_points_per_cell": "2,2,2",
                   "mpm_bcs": "symmetry,rim,left,right,ends", "mpm_bc_ends_region": "box", "mpm_bc_ends_components": "z",
                   "mpm_boundary_pipe_motion": f"{WAY},0,0"}


with Test() as check:
    common = {"mpm_grid_cells": "28,12", "mpm_body_ground_points_per_cell": "2,2", "mpm_boundary_pipe_motion": f"{WAY},0",
              "mpm_time_step": 1.0 / STEPS, "mpm_output_every": 0, "mpm_quiet": None}
    for friction, theory in THEORY.items():
        run = check.run(example("pipe"), mpm_boundary_pipe_friction=friction, **common)
        way, force = resistance(run)
        plateau = force[way > 0.1]
        # waves come as cells at the pipe fill and empty, some of a cell's share of the resistance: 1.7 % on half the cells
        check.near(f"{friction}.mean", np.mean(plateau), theory, relative=0.04)
        check.check(f"{friction}.waves", np.max(np.abs(plateau / np.mean(plateau) - 1.0)), None, 0.03)
        check.check(f"{friction}.cuts", np.sum(run.results.column("cuts")), None, 0)
        check.check(f"{friction}.newton", np.mean(run.results.column("newton")), None, 6.0)
    tight = {**common, "snes_rtol": 1e-12, "mpm_time_end": 0.4}
    runs = [check.run(example("pipe"), ranks=ranks, **tight) for ranks in (1, 3)]
    one, three = (resistance(run)[1] for run in runs)
    check.check("ranks", difference(one, three), None, RANKS)
    slides = {**tight, "mpm_time_end": 0.24, "mpm_boundary_pipe_friction": "0.3"}  # patches at nodes, with pieces of other ranks
    runs = [check.run(example("pipe"), ranks=ranks, **slides) for ranks in (1, 3)]
    one_slides, three_slides = (resistance(run)[1] for run in runs)
    check.check("ranks_sliding", difference(one_slides, three_slides), None, RANKS)
    half = check.run(example("pipe"), mpm_checkpoint_every=1, **{**slides, "mpm_time_end": 0.18})
    rest = check.run(example("pipe"), ranks=2, mpm_restart=half.prefix + "_checkpoint.h5", **slides)
    check.check("restart_sliding", abs(resistance(rest)[1][-1] - one_slides[-1]) / np.max(one_slides), None, RANKS)
    half = check.run(example("pipe"), mpm_checkpoint_every=1, **{**tight, "mpm_time_end": 0.3})
    rest = check.run(example("pipe"), ranks=2, mpm_restart=half.prefix + "_checkpoint.h5", **tight)
    check.check("restart", abs(resistance(rest)[1][-1] - one[-1]) / np.max(one), None, RANKS)
    short = {**tight, "mpm_time_end": 0.14}  # a cell that falls below the least filling does so in one of them first
    plane = resistance(check.run(example("pipe"), **short))[1]
    scene, options = slab(check.folder())
    thick = resistance(check.run(scene, ranks=2, **{**short, **options}))[1] / DEPTH
    check.check("slab", difference(plane, thick), None, 0.01)
