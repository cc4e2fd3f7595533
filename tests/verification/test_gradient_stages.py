#!/usr/bin/env python3
"""Derivatives of runs with stages, geostatic starts and dilation: both methods, ranks, and differences of whole runs.

Reference numbers are central differences of runs of this program, inside the change in which they agree with one another.

Quick.
"""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import Test, example  # noqa: E402

EXACT = {"snes_rtol": 1e-13, "snes_stol": 0, "mpm_quiet": None, "mpm_output_every": 0}
FOOTING = {"mpm_grid_cells": "34,12", "mpm_time_step": 0.1, "mpm_material_soil_dilation": 25}


def differentiate(test, scene, parameters, column, method="adjoint", ranks=1, **options):
    """Last value of a column, and its gradient."""
    run = test.run(scene, ranks=ranks, mpm_task="gradient", mpm_gradient_parameters=parameters, mpm_gradient_method=method,
                   mpm_objectives="u", mpm_objective_u_column=column, mpm_objective_u_kind="value", **{**EXACT, **options})
    summary = run.results.summary
    return summary["objective"], np.array(summary["gradient"])


def agree(test, label, scene, parameters, column, ranks=3, **options):
    """The gradient by the adjoint, which the tangent gives as well, on one rank and on several."""
    value, gradient = differentiate(test, scene, parameters, column, **options)
    for method, count in (("tangent", 1), ("adjoint", ranks)):
        _, other = differentiate(test, scene, parameters, column, method, count, **options)
        test.near(f"{label}.{method}.ranks={count}", abs(other / gradient - 1.0).max(), 0.0,
                  absolute=1e-10 if count == 1 else 1e-9)
    return value, gradient


with Test() as test:
    # flow that dilates under F-bar: the dilation of a step's start depends on history and strengths
    force, gradient = agree(test, "footing_drained", example("footing_drained"),
                            "soil.cohesion,soil.E,soil.friction,soil.dilation", "reaction_footing_y", **FOOTING)
    test.near("footing_drained.scaling", gradient[:2] @ (10e3, 1e9), force, relative=1e-9)
    test.near("footing_drained.cohesion", gradient[0], -24.51505833, relative=1e-8)
    test.near("footing_drained.friction", gradient[2], -19149.35422, relative=1e-7)
    test.near("footing_drained.dilation", gradient[3], -207.7852, relative=2e-6)

    # friction left after softening is that before, unless given: a number that others follow, in all forms of the means
    soft = {"mpm_grid_cells": "17,6", "mpm_time_end": 0.2, "mpm_material_soil_softening_strain": 0.02,
            "mpm_material_soil_cohesion_residual": 2e3, "mpm_material_soil_dilation": 10}
    for means in ("true", "false", "spread"):
        ends = [differentiate(test, example("footing_drained"), "soil.friction", "reaction_footing_y", mpm_stabilization_fbar=means,
                              **{**soft, "mpm_material_soil_friction": repr(30 * (1 + step))})[0] for step in (-1e-5, 1e-5)]
        for method in ("adjoint", "tangent"):
            _, gradient = differentiate(test, example("footing_drained"), "soil.friction", "reaction_footing_y", method,
                                        mpm_stabilization_fbar=means, **soft)
            test.near(f"soft.{means}.{method}", gradient[0], (ends[1] - ends[0]) / 60e-5, relative=1e-6)

    # a geostatic start, then stages: bodies go, other loads act, displacements begin anew
    names = "soil.E,soil.cohesion,soil.density,crest.factor,weight.factor,rest.geostatic_k0"
    steps = {"mpm_grid_cells": "24,11", "mpm_stage_load_time_step": 0.1}
    slope = example("slope_stages")
    _, gradient = agree(test, "slope", slope, names, "track_side_ux", **steps)
    parts = gradient[:5] * (30e6, 12e3, 2000, 1, 1)
    test.near("slope.scaling", parts[[0, 1, 3, 4]].sum(), 0.0, absolute=1e-8 * abs(parts).max())
    test.near("slope.weight", parts[2], parts[4], relative=1e-8)  # a density acts as gravity
    ends = [differentiate(test, slope, "soil.E", "track_side_ux", mpm_material_soil_E=repr(30e6 * (1 + step)), **steps)[0]
            for step in (-1e-5, 1e-5)]
    test.near("slope.differences", gradient[0], (ends[1] - ends[0]) / 600.0, relative=1e-6)

    # k0 acts on the start alone: the adjoint knows it, as twins of the whole run do
    _, twins = differentiate(test, slope, "rest.geostatic_k0", "track_side_ux", "twins", **steps)
    test.near("k0.twins", gradient[5], twins[0], relative=1e-6)

    # bodies that join, with masses of their own
    dig = Path(__file__).with_name("dig.yaml")
    _, gradient = agree(test, "dig", dig, "soil.E,hard.density,push.factor", "track_top_uy", mpm_stages="rest,dig,fill,load")
    ends = [differentiate(test, dig, "soil.E", "track_top_uy", mpm_stages="rest,dig,fill,load",
                          mpm_material_hard_density=repr(2000 * (1 + step)))[0] for step in (-0.1, 0.1)]
    test.near("dig.differences", gradient[1], (ends[1] - ends[0]) / 400.0, relative=1e-3)  # of a number of 1e-13

    # bodies with initial stress
    block, names = Path(__file__).with_name("stressed_block.yaml"), "soil.E,soil.nu,side.factor"
    _, gradient = agree(test, "stress", block, names, "track_corner_ux")
    for k, (name, value) in enumerate((("E", 20e6), ("nu", 0.3))):
        ends = [differentiate(test, block, "soil.E", "track_corner_ux", **{f"mpm_material_soil_{name}": repr(value * (1 + step))})[0]
                for step in (-1e-4, 1e-4)]
        test.near(f"stress.differences.{name}", gradient[k], (ends[1] - ends[0]) / 2e-4 / value, relative=1e-6)

    # penalties across faces, which go with E: of cut cells, of points one a cell, and of all faces
    coarse, beam = {"mpm_grid_cells": "30,30", "mpm_body_beam_points_per_cell": "3,3", "mpm_time_step": 0.2}, example("cantilever")
    for label, options in (("ghost", {"mpm_stabilization_ghost": 0.1}), ("sparse", {"mpm_body_beam_points_per_cell": "1,1"}),
                           ("interior", {"mpm_stabilization_interior": 0.05})):
        ways = [differentiate(test, beam, "beam.E,beam.nu,tip.factor", "track_tip_ux", method, ranks, **{**coarse, **options})[1]
                for method, ranks in (("adjoint", 1), ("tangent", 3))]
        test.near(f"{label}.tangent", abs(ways[1] / ways[0] - 1.0).max(), 0.0, absolute=1e-9)
        test.near(f"{label}.scaling", ways[0][0] * 12e6 + ways[0][2], 0.0, absolute=1e-9 * abs(ways[0][2]))
        ends = [differentiate(test, beam, "beam.nu", "track_tip_ux", mpm_material_beam_nu=repr(0.2 * (1 + step)),
                              **{**coarse, **options})[0] for step in (-1e-5, 1e-5)]
        test.near(f"{label}.differences", ways[0][1], (ends[1] - ends[0]) / 0.4e-5, relative=1e-6)

    # axial symmetry: weights over the radius, gradients averaged by volume
    round_block, strengths = Path(__file__).with_name("round_block.yaml"), (2e6, 25e3, 1, 1)
    for shape in ("gimp", "bspline2"):
        options = {"mpm_shape": shape}
        _, gradient = agree(test, f"axial.{shape}", round_block, "soil.E,soil.yield_stress,weight.factor,top.factor",
                            "track_corner_ux", **options)
        parts = gradient * strengths
        test.near(f"axial.{shape}.scaling", parts.sum(), 0.0, absolute=1e-9 * abs(parts).max())
        ends = [differentiate(test, round_block, "soil.E", "track_corner_ux", mpm_material_soil_yield_stress=repr(25e3 * (1 + step)),
                              **options)[0] for step in (-1e-5, 1e-5)]
        test.near(f"axial.{shape}.differences", gradient[1], (ends[1] - ends[0]) / 0.5, relative=1e-6)
