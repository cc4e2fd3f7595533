#!/usr/bin/env python3
"""A pile pushed into clay on a grid that goes with it, by conditions at its faces and by contact, for the first steps.

A short version of examples/pile_push, whose README has the whole way.
"""
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import EXAMPLES, Test, difference, example  # noqa: E402

QUIET = {"mpm_quiet": None, "mpm_output_every": 0}
WIDER = 1.5**2  # (1 + h/D)^2
FACTORS = (7.5, 10.5)  # as examples/pile_push/check.py has them


def pushed(test):
    run = test.run(example("pile_push"), mpm_time_end=0.12, mpm_quiet=None, mpm_output_every=12)
    quantities = test.check_example("pushed", run, "pile_push")
    test.check("pushed.bearing_factor", quantities["largest_over_su_D2"] / WIDER, *FACTORS)


def same(test):
    """On two ranks."""
    runs = [test.run(example("pile_push"), ranks=ranks, mpm_time_end=0.02, **QUIET) for ranks in (1, 2)]
    for column in ("reaction_tip_z", "reaction_base_z"):
        test.check(f"ranks.{column}", difference(*(run.results.column(column) for run in runs)), None, 1e-8)


def touched(test):
    """As a rigid body that the clay touches: pushed down, in balance."""
    run = test.run(EXAMPLES / "pile_push" / "contact.yaml", mpm_time_end=0.02, **QUIET)
    pile, base = (run.results.column(f"reaction_{name}_z")[-1] for name in ("pile", "base"))
    test.check("touched.force", -pile, 1e4)
    test.near("touched.balance", -pile, base, relative=1e-6)


with Test() as test:
    pushed(test)
    same(test)
    touched(test)
