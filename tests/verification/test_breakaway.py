#!/usr/bin/env python3
"""A bilateral boundary with a tension: it holds up to that pull, to within a step's increment, and lets go for good; it pushes
afterwards; on ranks, after a restart; without a tension it holds.

Quick.
"""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import Test, difference  # noqa: E402

SCENE = Path(__file__).resolve().parent / "breakaway.yaml"
TENSION = 5e3


def pull(run):
    return run.results.column("time"), run.results.column("reaction_plate_y")


with Test() as test:
    run = test.run(SCENE, mpm_quiet=None, mpm_checkpoint_every=15, mpm_checkpoint_keep=9)
    time, force = pull(run)
    step = np.diff(force[:5]).min()
    test.check("peak", -force.min(), TENSION, TENSION - step)
    after = time > time[force.argmin()] + 1e-9
    test.check("for_good", force[after].min(), -1e-6)
    test.check("pushes", force[after].max(), 9e3)
    fine = test.run(SCENE, mpm_quiet=None, mpm_time_step=0.01, mpm_time_end=0.6)
    test.near("fine.peak", -pull(fine)[1].min(), TENSION, relative=0.025)
    held = test.run(SCENE, mpm_quiet=None, mpm_boundary_plate_tension=1e9, mpm_time_end=1)
    test.check("held", -pull(held)[1][-1], 1e4)
    ranks = test.run(SCENE, ranks=3, mpm_quiet=None)
    test.check("ranks", difference(force, pull(ranks)[1]), None, 1e-8)
    again = test.run(SCENE, ranks=2, mpm_quiet=None, mpm_restart=f"{run.prefix}_checkpoint_000015.h5")
    own = pull(again)[1]
    test.check("restart", difference(force[-own.size:], own), None, 1e-7)
    refused = test.run(SCENE, status=2, mpm_boundary_plate_contact="unilateral")
    test.check("refused", float("-mpm_boundary_plate_tension: a unilateral boundary carries none" in refused.errors), 1, 1)
