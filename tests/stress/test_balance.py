#!/usr/bin/env python3
"""Bodies that cross the whole grid on 4 ranks: the fullest rank never holds 1.3 times the mean of the points.

`heap` is dragged by the nodes under it and ends as on one rank. `diagonal`, a thin strip, and `ball`, in 3D, are carried
from corner to corner: no cut straight through the grid shares them out at every step. With the balance switched off the
same runs show what it is for. Points that leave the grid end the run with one line and what was reached. With --full:
on 2, 3, 4, 6 and 8 ranks.
"""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent))
from hostile import Hostile  # noqa: E402
from talus_test import FULL, ROOT, difference  # noqa: E402

LIMIT = 240.0  # s, for one run
MOST = 1.3  # points on the fullest rank over their mean
HEAP = (ROOT / "scripts" / "bench" / "slide.yaml").read_text(encoding="utf-8")

CARRIED = """
mpm:
  dim: {dim}
  grid: {{lower: "{zeros}", upper: "{cells}", cells: "{cells}"}}
  materials: soil
  material_soil: {{type: hencky, E: 1e6, nu: 0.3, density: 1000}}
  bodies: body
  body_body: {{{region}, points_per_cell: "{per_cell}", material: soil}}
  bcs: all
  bc_all: {{components: "{components}", value: "{way}", ramp: "0:0,{steps}:1"}}
  time: {{end: {steps}, step: 1}}
  quiet: true
  output: {{prefix: run, every: {steps}}}
"""
DIAGONAL = {"dim": 2, "zeros": "0,0", "cells": "40,40", "per_cell": "2,2", "components": "x,y", "way": "26,26",
            "region": 'region: polygon, vertices: "0,0,3,0,14,11,14,14,11,14,0,3"'}
BALL = {"dim": 3, "zeros": "0,0,0", "cells": "20,20,20", "per_cell": "2,2,2", "components": "x,y,z", "way": "12,12,6",
        "region": 'region: sphere, center: "4,4,4", radius: 3.9'}


def balanced(test, label, scene, ranks, **options):
    """A run that stays balanced; shows that it would not otherwise."""
    run = test.ends(f"{label}.{ranks}_ranks", scene, ranks=ranks, mpm_quiet=None, **options)
    if not run.completed:
        return run
    summary = run.results.summary
    test.check(f"{label}.{ranks}_ranks.imbalance", summary["imbalance"], 1.0, MOST)
    test.check(f"{label}.{ranks}_ranks.rebalances", summary["rebalances"], 5, None)
    return run


def crossed(test, label, run, way):
    """Every point has gone the whole way, none is missing."""
    if not run.completed:
        return
    test.check(f"{label}.way_error", np.max(np.abs(run.table("displacement") - way)), None, 1e-9)
    test.check(f"{label}.ids", np.count_nonzero(run.table("id") != np.arange(run.results.summary["points"])), None, 0)


def never_balanced(test, label, scene, ranks):
    run = test.ends(f"{label}.unbalanced", scene, ranks=ranks, mpm_grid_balance=1e9)
    if run.completed:
        test.check(f"{label}.unbalanced.imbalance", run.results.summary["imbalance"], 2.0, None)


def left_the_grid(test):
    """The heap is pushed beyond the grid's end: no crash, the point and its place named, results there."""
    run = test.ends("beyond", HEAP, ranks=4, or_gives_up=True, mpm_bc_base_ramp="0:0,120:60", mpm_quiet=None,
                    mpm_output_every=50, mpm_output_prefix="run")
    test.check("beyond.status", run.status, 3, 3)
    words = (run.reason or "").split()
    test.check("beyond.tells_point", float(words[:1] == ["point"] and words[1].isdigit() and "at (6" in run.reason), 1, 1)
    test.check("beyond.last_state", run.results.steps[-1], run.results.summary["steps"], run.results.summary["steps"])
    test.check("beyond.steps", run.results.summary["steps"], 50, 119)


with Hostile(LIMIT) as test:
    diagonal, ball = CARRIED.format(steps=70, **DIAGONAL), CARRIED.format(steps=33, **BALL)
    alone = test.ends("heap.1_rank", HEAP, mpm_quiet=None, mpm_output_every=120)
    for ranks in (2, 3, 4, 6, 8) if FULL else (4,):
        heap = balanced(test, "heap", HEAP, ranks, mpm_output_every=120)
        if heap.completed and alone.completed:
            for field in ("displacement", "stress"):
                test.check(f"heap.{ranks}_ranks.{field}", difference(alone.table(field), heap.table(field)), None, 1e-8)
        crossed(test, f"diagonal.{ranks}_ranks", balanced(test, "diagonal", diagonal, ranks), (26.0, 26.0))
        crossed(test, f"ball.{ranks}_ranks", balanced(test, "ball", ball, ranks), (12.0, 12.0, 6.0))
    never_balanced(test, "diagonal", diagonal, 4)
    left_the_grid(test)
