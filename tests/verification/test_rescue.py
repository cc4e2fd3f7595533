#!/usr/bin/env python3
"""A relaxation in place of a quasi-static step that gives up: the state that Newton's method finds, and one that it does not."""
import sys
from pathlib import Path

import numpy as np

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))
from talus_test import Test, difference  # noqa: E402

HEAP, BAR = HERE / "rescue_heap.yaml", HERE / "rescue_bar.yaml"
DENIED = {"snes_max_it": 1, "snes_rtol": 1e-15}  # of Newton's iterations, to rounding: every step gives up


def told(run):
    return run.output.count("rescued by relaxation at time")


def same_state(test):
    """Where Newton's method finds the state of rest the relaxation does, in 2D and 3D, by any damping, under loads or a motion."""
    spatial = {"mpm_dim": 3, "mpm_grid_lower": "0,0,0", "mpm_grid_upper": "4,14,1", "mpm_grid_cells": "4,14,1", "mpm_body_bar_lower": "1,0,0",
               "mpm_body_bar_upper": "3,10,1", "mpm_body_bar_points_per_cell": "2,2,2", "mpm_bc_base_lower": "0,0,0", "mpm_bc_base_upper": "4,0,1",
               "mpm_bc_sides_lower": "0,0,0", "mpm_bc_sides_upper": "4,14,1", "mpm_bc_sides_components": "x,z",
               "mpm_load_weight_value": "0,-9.81,0", "mpm_track_top_at": "2,10,0.5"}
    pushed = {"mpm_motions": "push", "mpm_motion_push_body": "bar", "mpm_motion_push_region": "box", "mpm_motion_push_lower": "0,9.5",
              "mpm_motion_push_upper": "4,10", "mpm_motion_push_components": "y", "mpm_motion_push_value": "-0.1",
              "mpm_load_weight_value": "0,0"}
    short = {"mpm_time_step": 0.02, "mpm_time_step_min": 0.02}  # which nodes a motion holds is of a step's start
    for name, more, bound in (("kinetic", {}, 1e-3), ("viscous", {"mpm_relaxation_damping": "viscous", "mpm_relaxation_xi": 5}, 5e-3),
                              ("local", {"mpm_relaxation_damping": "local"}, 2e-3), ("spatial", spatial, 2e-3), ("pushed", pushed, 2e-3)):
        scene = {key: value for key, value in more.items() if "relaxation" not in key}
        exact = test.run(BAR, **scene, **(short if name == "pushed" else {})).results
        run = test.run(BAR, **DENIED, **more)
        other = run.results
        test.check(f"same.{name}.rescues", told(run), 2, 2)
        test.check(f"same.{name}.place", abs(other.column("track_top_uy")[-1] / exact.column("track_top_uy")[-1] - 1), None, bound)
        test.check(f"same.{name}.base", abs(other.column("reaction_base_y")[-1] / exact.column("reaction_base_y")[-1] - 1), None, bound)
        test.check(f"same.{name}.elastic", abs(other.column("energy_elastic")[-1] / exact.column("energy_elastic")[-1] - 1), None, 2 * bound)
        test.check(f"same.{name}.times", np.abs(other.column("time") - [0.5, 1]).max() + np.abs(other.column("dt") - 0.5).max(), None, 1e-12)
        test.check(f"same.{name}.K_F", other.column("K_F").max(), 1e-16, 0.01)
        # what the damping has taken, and nothing else, is missing; loads grow in proportion
        test.check(f"same.{name}.account", (other.column("energy_balance") / other.column("energy_external")).max(), None, 0.0)
        test.check(f"same.{name}.kinetic", np.abs(other.column("energy_kinetic")).max(), 0, 0)


def unused(test):
    """A rescue that nothing needs changes no number, and its columns are zero."""
    plain = test.folder() / "plain.yaml"
    plain.write_text(BAR.read_text(encoding="utf-8").replace(", rescue: relaxation", ""), encoding="utf-8")
    with_it, without = test.run(BAR).results, test.run(plain).results
    for column in ("track_top_uy", "reaction_base_y", "newton"):
        test.check(f"unused.{column}", np.abs(with_it.column(column) - without.column(column)).max(), 0, 0)
    test.check("unused.columns", max(np.abs(with_it.column(name)).max() for name in ("K_F", "K_E", "resets")), 0, 0)
    balance = with_it.column("energy_balance")[-1] / with_it.column("energy_external")[-1]
    test.check("unused.account", abs(balance), None, 0.01)


def slide(test):
    """Newton's method gives up and says what may help; the rescue finds sand at rest below its angle of friction, the same on any ranks."""
    bounded = {ranks: test.run(HEAP, status=3, ranks=ranks, mpm_relaxation_steps=200) for ranks in (1, 3)}
    errors = bounded[1].errors
    test.check("slide.bounded", "has not come to rest in 200 steps: K_F is" in errors, 1, 1)
    test.check("slide.bounded.lines", len(errors.strip().splitlines()), 1, 1)
    test.check("slide.ranks", errors.strip() in bounded[3].errors, 1, 1)
    one = test.run(HEAP)
    test.check("slide.told", told(one), 1, 4)
    state = one.results.state("last")
    x, y = state["position"].T
    rows = [x[np.abs(y - middle) < 0.25].max() for middle in (0.75, 1.25, 1.75, 2.25)]
    test.check("slide.angle", np.degrees(np.arctan(-1 / np.polyfit((0.75, 1.25, 1.75, 2.25), rows, 1)[0])), 15.0, 27.0)
    test.near("slide.weight", one.results.column("reaction_base_y")[-1], one.results.initial["mass"].sum() * 9.81 * 0.5, relative=0.01)
    on = test.run(HEAP, mpm_restart=f"{bounded[3].prefix}_checkpoint.h5").results
    for column in ("track_crest_uy", "energy_external", "energy_balance", "K_F", "resets", "cuts"):
        test.check(f"slide.restart.{column}", difference(on.column(column), one.results.column(column)), None, 1e-6)


def refused(test):
    for text, more in (("is an option of integrator quasistatic alone", {"mpm_time_integrator": "backward_euler"}),
                       ("must be one of none, relaxation", {"mpm_time_rescue": "newton"}),
                       ("-mpm_relaxation_steps 0: must be >= 1", {"mpm_relaxation_steps": 0})):
        run = test.run(HEAP, status=2, **more)
        test.check(f"refused.{list(more)[0]}", text in run.errors and len(run.errors.strip().splitlines()) == 1, 1, 1)


with Test() as test:
    same_state(test)
    unused(test)
    slide(test)
    refused(test)
