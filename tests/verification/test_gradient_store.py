#!/usr/bin/env python3
"""Derivatives of a run whose states are kept in memory, on disk, or found again: the same bits on one rank.

With so little memory that it takes a state in four, the steps between are taken again from their solutions. Ranks
exchange points in no fixed order, so that runs on several ranks repeat to rounding only.

Quick.
"""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import Test, example  # noqa: E402

SCENE = {"mpm_task": "gradient", "mpm_gradient_parameters": "soil.E,soil.yield_stress", "mpm_objectives": "toe",
         "mpm_objective_toe_column": "track_toe_ux", "mpm_objective_toe_kind": "value", "mpm_grid_cells": "16,8",
         "mpm_time_step": 0.05, "mpm_quiet": None}
LITTLE = 7e5


def gradient(test, method, ranks=1, **options):
    """The gradient, with the states kept in a way."""
    run = test.run(example("collapse"), ranks=ranks, mpm_gradient_method=method, **SCENE, **options)
    test.check(f"{method}.{ranks}.files", sum("tape" in str(name) for name in run.files), 0, 0)
    return np.array(run.results.summary["gradient"])


with Test() as test:
    for method in ("adjoint", "tangent"):
        whole = gradient(test, method)
        for label, options in {"disk": {"mpm_gradient_store": "disk"}, "little": {"mpm_gradient_memory": LITTLE}}.items():
            other = gradient(test, method, **options)
            test.check(f"{method}.{label}.same", bool((other == whole).all()), 1, 1)
            other = gradient(test, method, ranks=3, **options)
            for k in range(2):
                test.near(f"{method}.{label}.ranks.{k}", other[k], whole[k], relative=1e-10)
    run = test.run(example("collapse"), status=2, **SCENE, mpm_gradient_memory=1e4)
    test.check("least.line", "-mpm_gradient_memory 10000.: is too little" in run.errors and run.errors.count("\n") == 1, 1, 1)
    test.check("least.files", len(run.files), 0, 0)
