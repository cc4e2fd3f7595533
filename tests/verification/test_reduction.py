#!/usr/bin/env python3
"""Strength reduction: the stress of confined ground is that of the reduced strength, and elasticity stays; slopes fail where limit
analysis has it; cut steps and restarts change nothing.

A short version of examples/slope_reduction, whose README has the figures of finer grids. With --full: a finer one against a spiral
on the slope as it has moved, and `gimp` where the ground settles.
"""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import EXAMPLES, FULL, Test, difference, example  # noqa: E402

FOLDER = Path(__file__).resolve().parent
FRICTION, FACTOR = 30.0, 2.0
COARSE = {"mpm_grid_cells": "54,16", "mpm_quiet": None, "mpm_output_every": 1000}
FAIL = {"mpm_stage_fail_reduction": "0:1,0.2:1.3,1:1.5", "mpm_stage_fail_time_step": 0.04, "mpm_stage_fail_time_end": 0.8}
KEEP = {"mpm_checkpoint_every": 10, "mpm_checkpoint_keep": 100}


def confined(test, name, parameters, excess, least):
    """Level ground between smooth walls on rock that has no strength: rest, half the strength, all of it again. Past the factor
    1.4 the `least` of the excesses over the points is 0: all of them flow, or some."""
    options = {"mpm_stages": "rest,weak,hold", "mpm_stage_rest_geostatic_k0": 0.43, "mpm_stage_weak_reduction": f"0:1,1:{FACTOR}",
               "mpm_stage_weak_time_step": 0.25, "mpm_material_soil_type": name, "mpm_quiet": None,
               **{f"mpm_material_soil_{key}": value for key, value in parameters.items()}}
    run = test.run(FOLDER / "level.yaml", **options)
    factor, stage = run.results.column("reduction"), run.results.column("stage")
    test.check(f"{name}.factors", np.abs(factor[stage == 2] - [1.25, 1.5, 1.75, 2.0]).max(), None, 1e-12)
    test.check(f"{name}.factor_elsewhere", np.abs(factor[stage != 2] - 1.0).max(), None, 0.0)
    for step in np.flatnonzero(stage > 1):
        state = run.results.state(int(step) + 1)
        ground = state["material"] == 0
        tau = (state["stress"] * np.linalg.det(state["F"].reshape(-1, 3, 3))[:, None])[ground]
        found = excess(tau, state, ground, factor[step] if stage[step] == 2 else FACTOR)
        test.check(f"{name}.excess_{step}", found.max(), None, 1e-4 if stage[step] == 3 else 1e-9)
        if stage[step] == 3 or factor[step] > 1.4:  # with all strength again the stress stays where it was
            test.check(f"{name}.flows_{step}", least(found), -1e-4 if stage[step] == 3 else -1e-9)
    rock = [run.results.state(step) for step in (1, "last")]
    test.check(f"{name}.rock", difference(*(state["stress"][state["material"] == 1] for state in rock)), None, 1e-6)
    test.check(f"{name}.no_factor_of_safety", float(run.results.summary["factor_of_safety"] is None), 1, 1)


def coulomb(tau, _state, _ground, factor):
    """By how much Rankine's active state is passed, over the largest stress; c = 0."""
    high, low = tau[:, 0], tau[:, 1]
    return (high - low + (high + low) * np.sin(np.arctan(np.tan(np.radians(FRICTION)) / factor))) / np.abs(low).max()


def mises(tau, state, ground, factor):
    """By how much von Mises' bound is passed, hardening included."""
    dev = tau[:, :3] - tau[:, :3].mean(axis=1)[:, None]
    limit = (6e4 + 1e6 * state["equivalent_plastic_strain"][ground]) / factor
    return np.sqrt(1.5 * (dev**2).sum(axis=1)) / limit - 1.0


def slope(test, label, options, least, most):
    run = test.run(example("slope_reduction"), **{**COARSE, **FAIL, **options})
    test.check(f"{label}.factor_of_safety", run.results.summary["factor_of_safety"], least, most)
    moved = np.linalg.norm(run.results.state("last")["displacement"], axis=1).max()
    test.check(f"{label}.slides_on", moved, 0.3)
    return run


def excess(test, label, run):
    """The stress keeps to the strength of the last step's end, and reaches it."""
    state, factor = run.results.state("last"), run.results.column("reduction")[-1]
    sine = np.sin(np.arctan(np.tan(np.radians(20.0)) / factor))
    tau = state["stress"] * np.linalg.det(state["F"].reshape(-1, 3, 3))[:, None]
    centre, radius = 0.5 * (tau[:, 0] + tau[:, 1]), np.hypot(0.5 * (tau[:, 0] - tau[:, 1]), tau[:, 3])
    high, low = np.maximum(centre + radius, tau[:, 2]), np.minimum(centre - radius, tau[:, 2])
    passed = (high - low + (high + low) * sine) / (2.0 * 10e3 / factor * np.sqrt(1.0 - sine**2)) - 1.0
    test.check(f"{label}.yield_excess", passed.max(), -1e-6, 1e-6)


def slopes(test):
    associated = slope(test, "associated", KEEP, 1.32, 1.40)
    excess(test, "associated", associated)
    low = test.run(example("slope_reduction"), **{**COARSE, **FAIL}, mpm_material_soil_dilation=0, mpm_stage_fail_reduction_slide="false")
    test.check("psi_0.factor_of_safety", low.results.summary["factor_of_safety"], 1.25, associated.results.summary["factor_of_safety"])
    test.check("psi_0.lower", low.results.summary["factor_of_safety"] / associated.results.summary["factor_of_safety"], None, 0.999)
    # steps that are far too long: cut, and again with the strength of their own end
    long = slope(test, "cut", {"mpm_stage_fail_time_step": 0.5, "snes_max_it": 8}, 1.3, 1.5)
    test.check("cut.cuts", long.results.summary["step_cuts"], 1)
    excess(test, "cut", long)
    return associated


CUT = {"mpm_grid_cells": "26,18", "mpm_stage_fail_reduction": "0:1,1:1.3", "mpm_quiet": None}


def brackets(test):
    """The factor of a vertical cut is the same whatever the ramp's step, and where the ramp begins beyond it; the last state stands."""
    scene = FOLDER / "vertical_cut.yaml"
    factors = []
    for ramp, step in (("0:1,1:1.3", 0.32), ("0:1,1:1.3", 0.02), ("0:1.4,1:1.5", 0.25), ("0:1.4", 1.0)):
        run = test.run(scene, **{**CUT, "mpm_stage_fail_reduction": ramp, "mpm_stage_fail_time_step": step, "mpm_output_every": 1000})
        factors.append(run.results.summary["factor_of_safety"])
        moved = np.linalg.norm(run.results.state("last")["displacement"], axis=1).max()
        test.check(f"brackets.{ramp}.{step}.stands", moved, 1e-3, 0.1)
        test.check(f"brackets.{ramp}.{step}.below", run.results.column("reduction")[-1], 0.998 * factors[-1], factors[-1])
    test.check("brackets.spread", max(factors) / min(factors) - 1.0, None, 3e-3)
    slide = test.run(scene, **{**CUT, "mpm_stage_fail_reduction": "0:1,1:1.25"}, mpm_stage_fail_time_step=0.1,
                     mpm_stage_fail_reduction_slide="true")
    test.near("brackets.slide.factor", slide.results.summary["factor_of_safety"], factors[0], relative=3e-3)
    test.check("brackets.slide.goes_on", slide.results.column("reduction")[-1], 1.24)
    late = test.run(scene, **CUT, mpm_stage_fail_time_step=0.1, mpm_stages="rest,fail,last", mpm_stage_last_time_step=1)
    test.check("brackets.next_stage", late.results.column("stage")[-1], 3, 3)
    # a solver that gives up far from failure says how far it came
    confined = {"mpm_stages": "rest,weak,hold", "mpm_stage_rest_geostatic_k0": 0.43, "mpm_stage_weak_reduction": "0:1,1:2",
                "mpm_stage_weak_time_step": 0.25, "mpm_material_soil_type": "j2", "mpm_material_soil_yield_stress": 6e4,
                "mpm_material_soil_hardening": 1e6, "mpm_quiet": None}
    lower = test.run(FOLDER / "level.yaml", status=3, snes_max_it=1, **confined)
    test.near("brackets.lower_bound", lower.results.summary["factor_of_safety"], lower.results.column("reduction")[-1], relative=1e-8)
    test.check("brackets.lower_bound_line", float("factor of safety at least 1.4" in lower.errors), 1, 1)


def unreduced(test):
    """Materials without strength are named, and no more than half of the mass; M of Cam-Clay is a strength."""
    rock = FOLDER / "vertical_cut_rock.yaml"
    run = test.run(FOLDER / "vertical_cut.yaml", options_file=rock, mpm_grid_cells="26,18", mpm_stage_fail_time_step=0.1)
    test.check("unreduced.named", float("stay as they are: rock (32." in run.output), 1, 1)
    heavy = test.run(FOLDER / "vertical_cut.yaml", status=2, options_file=rock, mpm_material_rock_density=8000, **CUT)
    test.check("unreduced.refused", float("more than half of the mass: rock" in heavy.errors), 1, 1)
    clay = test.run(FOLDER / "camclay_factor.yaml", status=None, mpm_quiet=None)
    test.check("unreduced.cam_clay", clay.results.summary["factor_of_safety"], 1.5, 2.6)


def near_spiral(test):
    """At the default limit the slope must stay near a log spiral on the slope as it has moved, 1.377, with more or less stiffness alike."""
    run = test.run(example("slope_reduction"), **{**COARSE, **FAIL, "mpm_grid_cells": "108,32",
                   "mpm_stage_fail_reduction_limit": 0.01, "mpm_stage_fail_time_end": 0.5, "mpm_stage_fail_reduction": "0:1,0.1:1.32,0.5:1.4", "mpm_stage_fail_time_step": 0.05,
                   "mpm_material_soil_E": 100e6})
    test.check("near_spiral.factor_of_safety", run.results.summary["factor_of_safety"], 1.36, 1.01 * 1.377)


def settles(test):
    """No dilation and little cohesion: Newton's method alone finds no state of rest far from failure, and the ground settles."""
    for shape in ("gimp", "gimp_bspline2") if FULL else ("gimp_bspline2",):
        run = test.run(FOLDER / "acads_1a.yaml", mpm_shape=shape, mpm_quiet=None, mpm_stage_fail_time_step=0.08,
                       mpm_stabilization_filled=0.35)
        test.near(f"settles.{shape}.factor", run.results.summary["factor_of_safety"] / 1.5, 0.986, relative=0.03)
    test.check("settles.told", float("settles" in str(run.results.summary["changes"])), 1, 1)


def rests(test):
    """Ground whose points yield as it comes to rest, in few iterations: F-bar's forces do not jump between them."""
    run = test.run(example("slope_reduction"), **COARSE, mpm_material_soil_nu=0.2, mpm_stage_rest_geostatic_iterations=12,
                   mpm_stage_fail_time_end=0.02)
    test.check("rests.completed", float(run.results.summary["status"] == "completed"), 1, 1)


def restarts(test, whole):
    """From a checkpoint before failure, on another number of ranks."""
    checkpoint = whole.prefix + "_checkpoint_000010.h5"
    run = test.run(example("slope_reduction"), ranks=2, **COARSE, **FAIL, mpm_restart=checkpoint)
    for column in ("reduction", "track_toe_ux"):
        own = run.results.column(column)
        test.check(f"restart.{column}", difference(whole.results.column(column)[-own.size:], own), None, 1e-6)
    test.near("restart.factor_of_safety", run.results.summary["factor_of_safety"], whole.results.summary["factor_of_safety"],
              relative=1e-12)


with Test() as test:
    confined(test, "mohr_coulomb", {"cohesion": 0, "friction": FRICTION, "dilation": 5}, coulomb, np.min)
    confined(test, "j2", {"yield_stress": 6e4, "hardening": 1e6}, mises, np.max)
    brackets(test)
    unreduced(test)
    rests(test)
    if FULL:
        near_spiral(test)
    settles(test)
    restarts(test, slopes(test))
    slope(test, "clay", {"options_file": EXAMPLES / "slope_reduction" / "clay.yaml", "mpm_grid_cells": "90,21",
                         "mpm_stage_fail_reduction": "0:1,0.2:1.36,1:1.6"}, 1.42, 1.52)
