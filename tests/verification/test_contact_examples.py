#!/usr/bin/env python3
"""Examples with rigid boundaries, on coarse grids: the limit load of a pipe, Hertz, Coulomb's law, a die that slides.

Quick.
"""
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import EXAMPLES, Test, difference, example  # noqa: E402

RANKS = 1e-7  # of the largest force, between numbers of ranks: Newton's tolerance, times what a hundred steps make of it


def pipe(test):
    """Rough and smooth against theory; the rough one is the stronger by about what theory says."""
    values = {}
    for friction in ("stick", "frictionless"):
        run = test.run(example("pipe"), mpm_grid_cells="28,12", mpm_time_step=0.02, mpm_output_every=0, mpm_quiet=None,
                       mpm_boundary_pipe_friction=friction)
        values[friction] = test.check_example(f"pipe_{friction}", run, "pipe")["resistance_over_su_D"]
    test.near("pipe.rough_over_smooth", values["stick"] / values["frictionless"], 11.94 / 9.20, relative=0.05)


def hertz(test):
    run = test.run(example("hertz"), mpm_grid_cells="44,44", mpm_output_every=0, mpm_quiet=None)
    test.check_example("cylinder", run, "hertz")
    run = test.run(EXAMPLES / "hertz" / "sphere.yaml", mpm_grid_cells="10,10,6", mpm_time_step=0.25, mpm_output_every=0,
                   mpm_quiet=None)
    test.check_example("sphere", run, "hertz")


def incline(test):
    """Slides with mu N, stays above tan(30 degrees) and not below, on any number of ranks."""
    runs = [test.run(example("incline_friction"), ranks=ranks, mpm_quiet=None) for ranks in (1, 2)]
    for ranks, run in zip((1, 2), runs):
        test.check_example(f"slides_on_{ranks}", run, "incline_friction")
    one, other = (run.results.column("reaction_slope_y") for run in runs)
    test.check("slides.ranks", difference(one, other), None, RANKS)
    stays = EXAMPLES / "incline_friction" / "stays.yaml"
    test.check_example("stays", test.run(stays, mpm_boundary_slope_friction=0.5785, mpm_quiet=None), "incline_friction")
    slips = test.run(stays, status=3, mpm_boundary_slope_friction=0.576, mpm_quiet=None)
    test.check("slips.steps", slips.results.column("step").size if slips.results.history else 0, None, 0)


def ironing(test):
    run = test.run(example("shallow_ironing"), mpm_grid_cells="48,18", mpm_time_end=1.5, mpm_output_every=0, mpm_quiet=None,
                   mpm_boundary_die_motion_table=EXAMPLES / "shallow_ironing" / "motion.csv")
    test.check_example("ironing", run, "shallow_ironing")


with Test() as check:
    pipe(check)
    hertz(check)
    incline(check)
    ironing(check)
