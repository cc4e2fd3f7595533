#!/usr/bin/env python3
"""Steps of given lengths: a run with the schedule of another repeats it to the last bit; and signatures of steps.

The signature is a number of a step's discrete decisions: equal on any ranks, and for steps that take the same decisions.

Quick.
"""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import Test, example, read_table  # noqa: E402

SCENES = {
    "consolidation_finite": {"mpm_time_end": 2000, "mpm_time_error": 0.01},
    "slope_stages": {"mpm_grid_cells": "24,11"},
    "vibrating_bar": {"mpm_time_end": 0.2},
    "column_collapse": {"mpm_time_end": 0.02},
}
SIGNED = {"mpm_quiet": None, "mpm_output_signature": None, "mpm_output_every": 0}


def history(run):
    """Path and columns of a run's history."""
    path = run.prefix + "_history.csv"
    return path, read_table(path)


def same(one, other):
    """How many columns of two histories differ, counts of iterations aside."""
    return sum(not np.array_equal(one[name], other[name], equal_nan=True) for name in one
               if name not in ("cuts", "newton", "linear"))


def refuse(test, label, words, text, **options):
    """A schedule that does not fit: one line with these words, status 2, no files."""
    path = test.folder() / "schedule.csv"
    path.write_text(text)
    run = test.run(example("collapse"), status=2, mpm_time_schedule=path, mpm_quiet=None, **options)
    test.check(f"{label}.line", words in run.errors and run.errors.count("\n") == 1, 1, 1)
    test.check(f"{label}.files", len(run.files), 0, 0)


with Test() as test:
    for scene, options in SCENES.items():
        path, first = history(test.run(example(scene), **options, **SIGNED))
        _, again = history(test.run(example(scene), **options, **SIGNED, mpm_time_schedule=path))
        test.check(f"{scene}.differs", same(first, again), 0, 0)
        test.check(f"{scene}.signatures", len(set(first["signature"])), 2, None)

    # steps of another run; ranks do not matter to signatures, a change of the decisions does
    coarse = {"mpm_grid_cells": "16,8", "mpm_time_step": 0.1}
    path, first = history(test.run(example("collapse"), **coarse, **SIGNED))
    _, other = history(test.run(example("collapse"), ranks=3, **coarse, **SIGNED))
    test.check("ranks.signatures", int((first["signature"] != other["signature"]).sum()), 0, 0)
    _, other = history(test.run(example("collapse"), **coarse, **SIGNED, mpm_material_soil_yield_stress=24e3))
    test.check("other.signatures", int((first["signature"] != other["signature"]).sum()), 1, None)
    ends = [0.2, 0.25, 0.5, 0.7, 1]
    target = test.folder() / "uneven.csv"
    target.write_text("time\n" + "\n".join(map(str, ends)))
    _, other = history(test.run(example("cantilever"), mpm_time_schedule=target, **SIGNED))
    test.check("uneven.steps", float(np.abs(other["time"][-5:] - ends).max()), 0, 0)
    run = test.run(example("collapse"), status=3, mpm_time_schedule=target, **coarse, **SIGNED)
    test.check("hard.line", "the schedule's step to 0.7:" in run.errors, 1, 1)

    refuse(test, "short", "is of another scene: no step ends at 1", "time\n0.3\n0.5\n")
    refuse(test, "long", "is of another scene: its steps go on to 2", "time\n0.3\n1\n2\n")
    refuse(test, "order", "times must ascend: 0.3 comes behind 0.5", "time\n0.5\n0.3\n1\n")
    refuse(test, "finite", "time of row 2 is not a finite number", "time\n0.3\ninf\n")
    refuse(test, "column", "has no column time", "step\n1\n2\n")
    refuse(test, "rescue", "ends when its state says so", "time\n1\n", mpm_time_rescue="relaxation")
