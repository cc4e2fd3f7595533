#!/usr/bin/env python3
"""Derivatives of awkward scenes: both methods against central differences of whole runs, or a refusal in one line.

Steps that are cut, ramps that bend in or at the end of a step, data over a column that turns back, bodies that join and
displacements that begin anew, points from a file, two objectives on one column, two laws of equal stiffness beside each other.

Quick.
"""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import Test, example  # noqa: E402

BLOCK = Path(__file__).resolve().parent / "packed_block.yaml"
BEAM = {"mpm_grid_cells": "30,30", "mpm_body_beam_points_per_cell": "2,2", "mpm_time_step": 0.5, "mpm_shape": "gimp_bspline2"}
SMOOTH = {"mpm_shape": "gimp_bspline2", "mpm_stabilization_fbar": "false", "mpm_grid_cells": "8,4",
          "mpm_material_soil_cohesion": 14e3}
FILL = {"mpm_materials": "soil,fill", "mpm_material_fill_type": "mohr_coulomb", "mpm_material_fill_E": 1e6,
        "mpm_material_fill_nu": 0.3, "mpm_material_fill_density": 1000, "mpm_material_fill_cohesion": 14e3,
        "mpm_material_fill_friction": 20, "mpm_bodies": "block,top", "mpm_body_top_region": "box", "mpm_body_top_lower": "0,8",
        "mpm_body_top_upper": "4,10", "mpm_body_top_points_per_cell": "2,2", "mpm_body_top_material": "fill",
        "mpm_grid_upper": "16,12", "mpm_grid_cells": "8,6"}
JOINS = {**FILL, "mpm_stages": "first,second", "mpm_stage_first_time_end": 0.4, "mpm_stage_second_time_end": 0.2,
         "mpm_stage_second_bodies": "top", "mpm_stage_second_reset_displacement": "true"}
EXACT = {"snes_rtol": 1e-13, "snes_stol": 0, "mpm_quiet": None, "mpm_output_every": 0, "mpm_task": "gradient"}


def objective(column, name="u", **block):
    return {f"mpm_objective_{name}_{key}": value for key, value in {"column": column, **block}.items()}


def gradient(test, scene, parameters, options, method="adjoint", ranks=1):
    summary = test.run(scene, ranks=ranks, **{**EXACT, "mpm_objectives": "u", **options, "mpm_gradient_method": method,
                                              "mpm_gradient_parameters": ",".join(parameters)}).results.summary
    return summary["objective"], np.array(summary["gradient"])


def compare(test, label, scene, parameters, options, change=1e-5, relative=1e-6, ranks=1):
    """`parameters`: an option and its value by name. Central differences, and the tangent, on other ranks."""
    _, found = gradient(test, scene, parameters, options)
    _, tangent = gradient(test, scene, parameters, options, "tangent", ranks)
    for (name, (option, value)), by, other in zip(parameters.items(), found, tangent):
        high, low = (gradient(test, scene, parameters, {**options, option: repr(value * (1 + step))})[0] for step in (change, -change))
        test.near(f"{label}.{name}", by, (high - low) / (2 * change * value), relative=relative)
        test.near(f"{label}.{name}.tangent", other, by, relative=1e-8)


with Test() as test:
    place = test.folder()
    (place / "times.csv").write_text("time,track_tip_ux\n0.2,-1\n0.9,-5\n")
    (place / "over.csv").write_text("track_tip_uy,track_tip_ux\n-1,-0.1\n-3,-1\n")
    (place / "toe.csv").write_text("time,track_toe_ux\n0.05,0.01\n0.13,0.05\n0.45,0.01\n")
    beam, young = example("cantilever"), {"beam.E": ("mpm_material_beam_E", 12e6)}
    times = objective("track_tip_ux", data=str(place / "times.csv"))
    over = objective("track_tip_ux", data=str(place / "over.csv"), over="track_tip_uy")
    toe = objective("track_toe_ux", data=str(place / "toe.csv"))

    compare(test, "bends", beam, young, {**BEAM, **times, "mpm_load_tip_ramp": "0:0,0.3:0.3,0.5:0.2,1:1"})
    compare(test, "turns", beam, young, {**BEAM, **over, "mpm_load_tip_ramp": "0:0,0.5:1,1:0.2"})
    compare(test, "twice", beam, young, {**BEAM, **times, "mpm_objectives": "u,v",
                                         **objective("track_tip_ux", "v", target=-3, weight=4)})
    compare(test, "cut", BLOCK, {"soil.E": ("mpm_material_soil_E", 1e6)},
            {**SMOOTH, **objective("track_toe_ux", kind="value"), "mpm_time_step": 0.6, "snes_max_it": 9}, ranks=3)
    compare(test, "joins", BLOCK, {"soil.E": ("mpm_material_soil_E", 1e6), "fill.density": ("mpm_material_fill_density", 1000.0)},
            {**SMOOTH, **JOINS, **toe}, ranks=3)

    # the stiffer of two materials has the penalty; where both are as stiff, half of each has it
    compare(test, "equal", BLOCK, {"soil.E": ("mpm_material_soil_E", 1e6), "fill.E": ("mpm_material_fill_E", 1e6)},
            {**SMOOTH, **FILL, **objective("track_toe_ux", kind="value"), "mpm_stabilization_ghost": 0.01,
             "mpm_stabilization_fbar": "spread"}, relative=4e-3)

    # a run that goes on has no derivatives by what came before
    value = {**EXACT, **BEAM, "mpm_objectives": "u", **objective("track_tip_ux", kind="value"), "mpm_gradient_parameters": "beam.E"}
    first = test.run(beam, **{**value, "mpm_checkpoint_every": 1})
    again = test.run(beam, status=2, **{**value, "mpm_restart": f"{first.prefix}_checkpoint_000001.h5"})
    test.check("restart.line", "derivatives need all steps" in again.errors and again.errors.count("\n") == 1, 1, 1)

    # nor has a load of no magnitude by its factor
    none = test.run(beam, status=2, **{**EXACT, **BEAM, "mpm_task": "inverse", "mpm_objectives": "u", **times,
                                       "mpm_parameters": "f", "mpm_parameter_f_of": "tip.factor", "mpm_parameter_f_start": 0})
    test.check("factor.line", "must not be 0" in none.errors and none.errors.count("\n") == 1, 1, 1)
    test.check("factor.files", len(none.files), 0, 0)

    # nor is a number two parameters by two names
    for one, other in (("tip.factor", "tip.value:y"), ("beam.E", "material_beam.E")):
        both = test.run(beam, status=2, **{**value, "mpm_gradient_parameters": f"{one},{other}"})
        test.check(f"names.{one}", f"{other}: is" in both.errors and both.errors.count("\n") == 1, 1, 1)

    # a twin that is refused is freed
    run = test.run(BLOCK, status=3, **{**EXACT, **SMOOTH, "mpm_objectives": "u", **objective("track_toe_ux", kind="value"),
                                       "mpm_material_soil_dilation": 20, "mpm_gradient_method": "twins",
                                       "mpm_gradient_parameters": "soil.dilation", "malloc_debug": None, "malloc_dump": None})
    test.check("refused.line", "must not exceed friction" in run.errors, 1, 1)
    test.check("refused.left", run.errors.count(" bytes ") + run.output.count(" bytes "), None, 20)
