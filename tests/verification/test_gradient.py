#!/usr/bin/env python3
"""Derivatives of whole runs: adjoint and tangent give the numbers of an independent program, of differences, and of scaling.

Reference numbers of the columns come from a one-dimensional program in numpy with a tangent and an adjoint of its own, which
repeats the displacements of Talus to 13 digits. Results depend on ratios of stresses and forces alone: the sum of p dy/dp
over all of these is 0 for a displacement and y for a force.

Quick.
"""
import re
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import Test, example  # noqa: E402

EXACT = {"snes_rtol": 1e-13, "snes_stol": 0, "mpm_quiet": None}
COLUMN = {"mpm_grid_upper": "1.5625,50", "mpm_grid_cells": "1,32", "mpm_stabilization_ghost": "off",
          "mpm_stabilization_fbar": "false"}
REFERENCE = {
    ("bar_elastic", "gimp"): (9.584122548966e-4, -0.1198015318621),
    ("bar_elastic", "linear"): (9.684558154540e-4, -0.1210569769318),
    ("bar_j2", "gimp"): (7.110445250028e-4, 8.151847749222e-4, -0.1512801513959),
    ("bar_j2", "linear"): (8.132643385035e-4, 5.577579169391e-4, -0.1443524890788),
}
PARAMETERS = {"bar_elastic": "column.E,column.density", "bar_j2": "column.E,column.yield_stress,column.density"}
CANTILEVER = {"mpm_grid_cells": "30,30", "mpm_body_beam_points_per_cell": "3,3", "mpm_time_step": 0.05}


def differentiate(test, scene, parameters, column, method="adjoint", ranks=1, **options):
    """Objective and gradient of a column's last value."""
    run = test.run(example(scene), ranks=ranks, mpm_task="gradient", mpm_gradient_parameters=parameters,
                   mpm_gradient_method=method, mpm_objectives="u", mpm_objective_u_column=column,
                   mpm_objective_u_kind="value", **{**EXACT, **options})
    summary = run.results.summary
    test.check(f"{scene}.{method}.names", summary["parameters"] == parameters.split(","), 1, 1)
    return summary["objective"], np.array(summary["gradient"])


def refuse(test, label, scene, words, **options):
    """A task that is not possible: one line with these words, status 2, no files."""
    run = test.run(example(scene), status=2, mpm_task="gradient", **options)
    test.check(f"{label}.line", words in run.errors and run.errors.count("\n") == 1, 1, 1)
    test.check(f"{label}.files", len(run.files), 0, 0)


with Test() as test:
    for (scene, shape), expected in REFERENCE.items():
        for method in ("adjoint", "tangent"):
            _, gradient = differentiate(test, scene, PARAMETERS[scene], "track_top_uy", method, mpm_shape=shape, **COLUMN)
            for name, value, reference in zip(PARAMETERS[scene].split(","), gradient, expected):
                test.near(f"{scene}.{shape}.{method}.{name}", value, reference, relative=1e-10)

    # a beam that bends far: both methods, ranks, differences, and scaling
    _, gradient = differentiate(test, "cantilever", "beam.E,tip.factor", "track_tip_ux", **CANTILEVER)
    test.near("cantilever.scaling", 12e6 * gradient[0], -gradient[1], relative=1e-9)
    for method, ranks in (("tangent", 1), ("adjoint", 3), ("tangent", 2)):
        _, other = differentiate(test, "cantilever", "beam.E,tip.factor", "track_tip_ux", method, ranks, **CANTILEVER)
        for k in range(2):
            test.near(f"cantilever.{method}.ranks={ranks}.{k}", other[k], gradient[k], relative=1e-9)
    ends = [differentiate(test, "cantilever", "beam.E", "track_tip_ux", mpm_material_beam_E=repr(12e6 * (1 + step)),
                          **CANTILEVER)[0] for step in (-1e-6, 1e-6)]
    test.near("cantilever.differences", gradient[0], (ends[1] - ends[0]) / 24.0, relative=1e-7)

    # plastic flow under F-bar: the scaling, and differences by the yield stress
    soft = {"mpm_grid_cells": "16,8", "mpm_time_step": 0.05, "mpm_output_every": 0}
    _, gradient = differentiate(test, "collapse", "soil.E,soil.yield_stress,soil.density", "track_toe_ux", **soft)
    parts = gradient * (1e6, 24494.897, 1000.0)
    test.near("collapse.scaling", parts.sum(), 0.0, absolute=1e-9 * abs(parts).max())
    _, other = differentiate(test, "collapse", "soil.E,soil.yield_stress,soil.density", "track_toe_ux", "tangent", 2, **soft)
    test.near("collapse.tangent", abs(other / gradient - 1.0).max(), 0.0, absolute=1e-9)
    ends = [differentiate(test, "collapse", "soil.E", "track_toe_ux", mpm_material_soil_yield_stress=repr(24494.897 * (1 + step)),
                          **soft)[0] for step in (-1e-7, 1e-7)]
    test.near("collapse.differences", gradient[1], (ends[1] - ends[0]) / 2e-7 / 24494.897, relative=1e-7)

    # a force of a support: its derivatives by all stresses add up to itself
    push = {"mpm_grid_cells": "20,24", "mpm_body_ground_points_per_cell": "2,2", "mpm_time_step": 0.1, "mpm_output_every": 0}
    force, gradient = differentiate(test, "footing", "clay.E,clay.yield_stress", "reaction_footing_y", **push)
    test.near("footing.scaling", gradient @ (10e6, 17320.508), force, relative=1e-9)
    test.check("footing.yield_stress", gradient[1], None, -3.0)  # N_c 5.14 over sqrt(3), for half of the footing: 2.97

    # tractions act at faces, and gravity under this shape at the ends of domains
    loads = (("cook", "panel.E", 70.0, "track_middle_uy",
              {"mpm_grid_cells": "13,16", "mpm_time_end": 0.1, "mpm_time_step": 0.05}),
             ("bar_elastic", "column.E", 10e3, "track_top_uy", {"mpm_shape": "gimp_bspline2", "mpm_grid_cells": "1,32",
                                                                "mpm_grid_upper": "1.5625,50", "mpm_time_step": 0.1}))
    for scene, parameter, stiffness, column, options in loads:
        _, gradient = differentiate(test, scene, parameter, column, **options)
        _, other = differentiate(test, scene, parameter, column, "tangent", **options)
        test.near(f"{scene}.loads.tangent", other[0], gradient[0], relative=1e-9)
        name = "mpm_material_" + parameter.replace(".", "_")
        ends = [differentiate(test, scene, parameter, column, **options, **{name: repr(stiffness * (1 + step))})[0]
                for step in (-1e-6, 1e-6)]
        test.near(f"{scene}.loads.differences", gradient[0], (ends[1] - ends[0]) / 2e-6 / stiffness, relative=1e-6)

    # the program's own check, which fails a derivative that is wrong
    ask = {"mpm_objectives": "u", "mpm_objective_u_column": "track_tip_ux", "mpm_objective_u_kind": "value"}
    check = {"mpm_task": "check_gradient", "mpm_gradient_parameters": "beam.E,tip.factor", **ask, "snes_rtol": 1e-13, "snes_stol": 0}
    run = test.run(example("cantilever"), **{**CANTILEVER, "mpm_time_step": 0.2}, **check)
    lines = [line for line in run.output.splitlines() if "tangent" in line]
    test.check("check.lines", len(lines), 2, 2)
    test.check("check.differences", sum("apart; differences" in line for line in lines), 2, 2)
    bar = {**check, "mpm_shape": "gimp_bspline2", "mpm_grid_cells": "1,32", "mpm_grid_upper": "1.5625,50", "mpm_time_step": 0.25,
           "mpm_gradient_parameters": "column.E,column.density", "mpm_objective_u_column": "track_top_uy"}
    lines = re.findall(r"random direction .* rates by decade ([^:]*): near 2 over (\d+)", test.run(example("bar_elastic"), **bar).output)
    test.check("taylor.directions", len(lines), 2, 2)
    for n, (rates, decades) in enumerate(lines):
        test.check(f"taylor.{n}.decades", int(decades), 3, 4)
        for rate in rates.split(", "):
            test.near(f"taylor.{n}.rate", float(rate), 2.0, absolute=0.05)
    loose = {**check, "mpm_gradient_parameters": "beam.E", "snes_rtol": 0.1}  # no solution that has a derivative
    run = test.run(example("cantilever"), status=3, **{**CANTILEVER, "mpm_time_step": 0.2}, **loose)
    test.check("check.fails", "derivative by beam.E" in run.errors, 1, 1)

    # options of the gradient's own linear solves
    run = test.run(example("cantilever"), **{**CANTILEVER, "mpm_time_step": 0.5}, **{**check, "mpm_task": "gradient"},
                   gradient_ksp_converged_reason=None)
    test.check("solves", run.output.count("gradient_ solve converged"), 2, 2)

    refuse(test, "no_parameters", "cantilever", "-mpm_parameters is missing", **ask)
    refuse(test, "no_objectives", "cantilever", "-mpm_objectives is missing", mpm_gradient_parameters="beam.E")
    refuse(test, "key", "cantilever", "beam has no number Q", mpm_gradient_parameters="beam.Q", **ask)
    refuse(test, "block", "cantilever", "no block has this name", mpm_gradient_parameters="soil.E", **ask)
    refuse(test, "column", "cantilever", "no such column", mpm_gradient_parameters="beam.E",
           **{**ask, "mpm_objective_u_column": "track_tip_uw"})
    refuse(test, "without", "cantilever", "no derivative of this column", mpm_gradient_parameters="beam.E",
           **{**ask, "mpm_objective_u_column": "newton"})
