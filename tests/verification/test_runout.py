#!/usr/bin/env python3
"""What fails and runs: a dam break, a column of sand, a pile of rods, a slope past failure and one that finds its angle of repose, on coarse grids."""
import sys
from pathlib import Path

import numpy as np

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))
from talus_test import Test, difference, example  # noqa: E402


def dam(test):
    options = {"mpm_grid_cells": "50,25", "mpm_quiet": None}
    run = test.run(example("dam_break"), mpm_output_every=5, **options)
    test.check_example("dam", run, "dam_break")
    short = {**options, "mpm_output_every": 0, "mpm_time_end": 0.2}
    one = test.run(example("dam_break"), **short)
    other = test.run(example("dam_break"), ranks=3, **short)
    test.check("dam.ranks_3", difference(other.results.column("track_toe_ux"), one.results.column("track_toe_ux")), None, 1e-8)


def viscous(test):
    """The step follows the viscosity where that decides: h^2/(2 nu), with nu = (4/3) eta/rho, less what waves take."""
    sound, eta, width, density = 10.0, 1e5, 0.1, 1000.0
    run = test.run(example("dam_break"), mpm_grid_cells="50,25", mpm_output_every=0, mpm_material_water_sound_speed=sound,
                   mpm_material_water_viscosity=eta, mpm_time_end=0.05, mpm_time_cfl=1, mpm_quiet=None)
    spread = 4.0 / 3.0 * eta / density / width
    test.near("viscous.step", run.results.column("dt")[0], width / (np.hypot(sound, spread) + spread), relative=1e-3)
    test.check("viscous.stable", run.results.column("energy_kinetic").max() / run.results.column("energy_external").max(), None, 1.0)


def sand(test):
    run = test.run(example("column_collapse"), mpm_grid_cells="22,10", mpm_output_every=20, mpm_quiet=None)
    test.check_example("column", run, "column_collapse")


def rods(test):
    run = test.run(example("rod_collapse"), mpm_grid_cells="55,12", mpm_output_every=1000, mpm_quiet=None)
    test.check_example("rods", run, "rod_collapse")


def spray(test):
    """Sand that is drawn out without a force parts: its points' domains grow to eight cells and no further."""
    run = test.run(HERE / "spray.yaml")
    test.check("spray.completed", run.results.summary["status"] == "completed", 1, 1)
    velocity, place = (run.results.state("last")[name][:, 0] for name in ("velocity", "position"))
    test.near("spray.left", velocity[place < 1.2].mean(), -2.0, relative=0.02)
    test.near("spray.right", velocity[place > 5.2].mean(), 2.0, relative=0.02)


def slope(test):
    run = test.run(example("slope_runout"), mpm_grid_cells="60,16", mpm_stage_fail_time_cfl=0.9, mpm_output_every=400, mpm_quiet=None)
    test.check_example("slope", run, "slope_runout")


def repose(test):
    """Cells of 4 m come to rest at the angle of friction, with their area; the same on any ranks."""
    runs = [test.run(example("relaxation_slope"), ranks=ranks, mpm_grid_cells="80,11", mpm_stabilization_smooth=0.8, mpm_output_every=100000, mpm_quiet=None) for ranks in (1, 2)]
    test.check_example("repose", runs[0], "relaxation_slope")
    ends = [np.sort(run.results.state("last")["position"][:, 0])[-20:].mean() for run in runs]
    test.near("repose.ranks", ends[1], ends[0], relative=1e-2)


with Test() as check:
    dam(check)
    viscous(check)
    sand(check)
    rods(check)
    spray(check)
    slope(check)
    repose(check)
