#!/usr/bin/env python3
"""A disc that rolls down a slope of 30 degrees and slips down one of 60, with implicit and explicit steps; on any number of ranks, and
after a restart.

Quick.
"""
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import EXAMPLES, Test, difference  # noqa: E402

DISC = EXAMPLES / "incline_slide" / "disc.yaml"
STEEP = "8.495709211,-4.905"  # 9.81 m/s2 at 60 degrees
RANKS = 1e-9                  # of the largest value, after 20 steps


def ways(test):
    run = test.run(DISC, mpm_time_end=0.25, mpm_output_every=100, mpm_quiet=None)
    test.check_example("rolls", run, "incline_slide")
    run = test.run(DISC, mpm_time_end=0.25, mpm_load_weight_value=STEEP, mpm_output_every=100, mpm_quiet=None)
    test.check_example("slips", run, "incline_slide")
    for young, step in ((1e8, 0.02), (1e10, 0.01)):
        results = test.run(DISC, mpm_material_stone_E=young, mpm_time_step=step, mpm_time_end=0.6, mpm_output_every=0, mpm_quiet=None).results
        test.near(f"E_{young:g}.way", results.column("track_middle_ux")[-1], 3.27 * 0.6**2 / 2, relative=5e-3)
        test.check(f"E_{young:g}.balance", energy_missing(results), None, 5e-3)


def energy_missing(results):
    return abs(results.column("energy_balance")).max() / results.column("energy_external")[-1]


def explicit(test):
    """Lumped masses turn with h^2/3 more inertia; friction that nothing overcomes takes no energy."""
    path = test.folder() / "explicit.yaml"
    text = DISC.read_text(encoding="utf-8")
    path.write_text(text.replace("generalized_alpha", "explicit").replace(", step: 0.01", ""), encoding="utf-8")
    results = test.run(path, mpm_time_end=0.3, mpm_output_every=0, mpm_quiet=None).results
    test.near("explicit.way", results.column("track_middle_ux")[-1], 3.27 * 0.3**2 / 2, relative=0.015)
    results = test.run(path, mpm_time_end=0.3, mpm_boundary_slope_friction=10, mpm_output_every=0, mpm_quiet=None).results
    test.check("explicit.rough.dissipated", results.column("energy_dissipated")[-1] / results.column("energy_external")[-1], None, 0.02)
    test.near("explicit.rough.way", results.column("track_middle_ux")[-1], 0.986 * 3.27 * 0.3**2 / 2, relative=0.015)


def ranks(test):
    runs = [test.run(DISC, ranks=ranks, mpm_time_end=0.05, mpm_time_step=0.0025, mpm_output_every=0, mpm_quiet=None) for ranks in (1, 3)]
    for name in ("reaction_slope_x", "reaction_slope_y", "track_middle_ux"):
        one, other = (run.results.column(name) for run in runs)
        test.check(f"ranks.{name}", difference(one, other), None, RANKS)


def restart(test):
    """Goes on rolling as it would have, on another number of ranks."""
    run = test.run(DISC, mpm_time_end=0.05, mpm_time_step=0.0025, mpm_output_every=0, mpm_checkpoint_every=10, mpm_quiet=None)
    again = test.run(DISC, ranks=2, mpm_time_end=0.05, mpm_time_step=0.0025, mpm_output_every=0, mpm_quiet=None,
                     mpm_restart=run.folder / "disc_checkpoint_000010.h5")
    for name in ("reaction_slope_x", "reaction_slope_y", "track_middle_ux"):
        whole, rest = run.results.column(name), again.results.column(name)
        test.check(f"restart.{name}", difference(whole[-rest.size:], rest), None, RANKS)


with Test() as check:
    restart(check)
    ways(check)
    explicit(check)
    ranks(check)
