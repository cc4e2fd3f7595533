#!/usr/bin/env python3
"""Removal of bodies by a ramp: elastic ground ends where it does after removal at once, steps can be cut, runs go on from within. Quick."""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import Test, difference  # noqa: E402

TRENCH = Path(__file__).resolve().parent / "trench.yaml"
ONCE = {"mpm_stage_dig_removal": "0:1"}
COMMON = {"mpm_stabilization_ghost": 1e-5, "mpm_quiet": None, "mpm_output_every": 1000}


def elastic(test, scene):
    """However many steps and ranks, wherever the ramp ends, and in the next stage."""
    def moved(step, ranks=1, **options):
        run = test.run(scene, ranks=ranks, mpm_stage_dig_time_step=step, **{**COMMON, **options})
        return run.results.state("last")["displacement"]

    once = moved(1.0, **ONCE)
    for label, step, options in (("one", 1.0, {}), ("two", 0.5, {}), ("ten", 0.1, {}), ("ranks", 0.25, {"ranks": 3}),
                                 ("early", 0.1, {"mpm_stage_dig_removal": "0:0.2,0.4:1"}),
                                 ("late", 0.1, {"mpm_stage_dig_removal": "0:0,0.2:0.5,0.8:0.5,1:1"}),
                                 ("next", 0.5, {"mpm_stages": "rest,dig,wait", "mpm_stage_dig_removal": "0:0,1.5:1"})):
        test.check(f"elastic.{label}", difference(once, moved(step, **options)), None, 1e-4)
    half = test.run(scene, mpm_stage_dig_time_step=0.1, **{**COMMON, "mpm_output_every": 1})
    middle = half.results.state(6)
    test.near("elastic.part", middle["mass"][middle["id"] >= len(once)].sum(), 0.5 * 1800 * 16, relative=1e-9)
    test.near("elastic.half", np.abs(middle["displacement"][: len(once)]).max(), 0.5 * np.abs(once).max(), relative=0.5)


def cuts(test):
    """Ground that yields: a step that fails is cut into smaller excavations, which removal at once cannot be."""
    hard = {**COMMON, "mpm_material_sand_cohesion": 11e3, "mpm_stage_dig_time_step": 1, "snes_max_it": 5}
    run = test.run(TRENCH, **hard)
    test.check("cuts.cuts", run.results.summary["step_cuts"], 1)
    free = test.run(TRENCH, **{**hard, "snes_max_it": 50, "mpm_stage_dig_time_step": 0.1})
    test.check("cuts.displacement", difference(*(r.results.state("last")["displacement"] for r in (free, run))), None, 0.02)
    test.check("cuts.at_once", test.run(TRENCH, status=None, **{**hard, **ONCE}).status, 3, 3)


def restarts(test):
    """From within the ramp, on other ranks."""
    options = {**COMMON, "mpm_material_sand_cohesion": 11e3, "mpm_stage_dig_time_step": 0.1}
    whole = test.run(TRENCH, mpm_checkpoint_every=5, mpm_checkpoint_keep=10, **options)
    for ranks in (1, 2):
        run = test.run(TRENCH, ranks=ranks, mpm_restart=whole.prefix + "_checkpoint_000005.h5", **options)
        test.check(f"restart_{ranks}", difference(*(r.results.state("last")["displacement"] for r in (whole, run))), None, 1e-8)


def refused(test):
    for ramp, word in (("0:0,1:0.5", "the last factor must be 1"), ("0:-1,1:1", "must be in [0, 1]")):
        run = test.run(TRENCH, status=2, mpm_stage_dig_removal=ramp)
        test.check(f"refused.{ramp}", float(word in run.errors and "-mpm_stage_dig_removal" in run.errors), 1, 1)
    run = test.run(TRENCH, status=2, mpm_stage_rest_removal="0:0,1:1")
    test.check("refused.nothing", float("-mpm_stage_rest_removal" in run.errors), 1, 1)


with Test() as test:
    text = TRENCH.read_text(encoding="utf-8")
    scene = test.folder() / "elastic.yaml"
    scene.write_text(text.replace("mohr_coulomb, E: 20e6", "hencky, E: 2e9").replace(", cohesion: 4e3, friction: 30, dilation: 0", ""))
    elastic(test, scene)
    cuts(test)
    restarts(test)
    refused(test)
