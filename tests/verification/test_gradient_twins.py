#!/usr/bin/env python3
"""Derivatives by twins, of scenes with parts that have none in closed form: against closed forms, identities, and differences of whole runs.

A displacement depends on ratios of stresses and forces alone: the sum of p dy/dp over all of these is 0; that of a force is
the force itself. Where neither is at hand, histories of two runs with changed numbers give a difference.

Quick.
"""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import Test, example  # noqa: E402

HERE = Path(__file__).resolve().parent
EXACT = {"snes_rtol": 1e-13, "snes_stol": 0, "mpm_output_every": 0}
U = {"mpm_objectives": "u", "mpm_objective_u_kind": "value"}


def differentiate(test, scene, parameters, column, ranks=1, **options):
    """Objective, gradient and summary of a column's last value."""
    run = test.run(scene, ranks=ranks, **{"mpm_task": "gradient", "mpm_gradient_parameters": parameters, "mpm_objective_u_column": column,
                                          **U, **EXACT, **options})
    summary = run.results.summary
    return summary["objective"], np.array(summary["gradient"]), summary


def difference(test, scene, name, value, column, change=1e-5, **options):
    """The difference of a column's last values over a change of an option; `value` is its number."""
    ends = [test.run(scene, **{**EXACT, **options, name: repr(value * (1.0 + side * change))}).results.column(column)[-1]
            for side in (-1, 1)]
    return (ends[1] - ends[0]) / (2.0 * change * value)


with Test() as test:
    # twins of what has closed forms
    beam = {"mpm_grid_cells": "30,30", "mpm_body_beam_points_per_cell": "3,3", "mpm_time_step": 0.5}
    _, closed, _ = differentiate(test, example("cantilever"), "beam.E,tip.factor", "track_tip_ux", **beam)
    _, twins, summary = differentiate(test, example("cantilever"), "beam.E,tip.factor", "track_tip_ux", mpm_gradient_method="twins", **beam)
    test.check("cantilever.method", summary["gradient_method"] == ["twins", "twins"], 1, 1)
    for k in range(2):
        test.near(f"cantilever.{k}", twins[k], closed[k], relative=1e-7)
        test.check(f"cantilever.error.{k}", abs(summary["gradient_error"][k] / twins[k]), 0.0, 1e-6)

    # a disc that moves freely on two blocks: its load has the unit of a stress
    disc = {"mpm_grid_cells": "16,12", "mpm_time_step": 0.5}
    _, gradient, summary = differentiate(test, example("two_supports"), "rubber.E,disc.load:y,disc.radius", "position_disc_y", **disc)
    test.near("disc.scaling", gradient[0] * 2e6, gradient[1] * 40e3, relative=1e-6)
    test.near("disc.radius", gradient[2], difference(test, example("two_supports"), "mpm_boundary_disc_radius", 0.8, "position_disc_y", **disc),
              relative=1e-6)
    _, other, _ = differentiate(test, example("two_supports"), "rubber.E,disc.load:y", "position_disc_y", ranks=3, **disc)
    test.near("disc.ranks", abs(other / gradient[:2] - 1.0).max(), 0.0, absolute=1e-6)

    # inertia, implicit and explicit, whose steps go with the stiffness: small motions are proportional to the load
    vibrating = {"mpm_grid_cells": "20,1", "mpm_time_end": 1.0, "mpm_time_step": 0.1}
    for name, scene, options in (("implicit", example("vibrating_bar"), vibrating), ("explicit", HERE / "explicit_bar.yaml", {"mpm_time_end": 1.5})):
        value, gradient, _ = differentiate(test, scene, "weight.factor,bar.E", "track_tip_ux", **options)
        test.near(f"{name}.load", gradient[0], value, relative=1e-2)
        test.near(f"{name}.gravity", differentiate(test, scene, "gravity", "track_tip_ux", **options)[1][0], gradient[0], relative=1e-9)
        if name == "implicit":
            test.near(f"{name}.E", gradient[1], difference(test, scene, "mpm_material_bar_E", 1e4, "track_tip_ux", **options), relative=1e-6)

    # water that leaves through a surface under a load: a settlement goes with permeability over viscosity
    clay = {"mpm_grid_cells": "1,20", "mpm_time_step": 4e6, "mpm_time_end": 2e7, "mpm_tracks": "top", "mpm_track_top_at": "0.05,10"}
    value, gradient, _ = differentiate(test, example("terzaghi"), "clay.permeability,water.viscosity,top.factor", "track_top_uy", **clay)
    test.near("terzaghi.time", gradient[0] * 1e-15, -gradient[1] * 1e-3, relative=1e-6)
    test.near("terzaghi.load", gradient[2], value, relative=1e-2)

    # what there is no derivative by: refused in one line
    def refuse(label, words, **options):
        run = test.run(example("cantilever"), status=2, **{"mpm_task": "gradient", **U, "mpm_objective_u_column": "track_tip_ux", **options})
        test.check(f"{label}.line", words in run.errors and run.errors.count("\n") == 1, 1, 1)

    refuse("block", "did you mean beam.E?", mpm_gradient_parameters="beem.E")
    refuse("key", "did you mean tip.value?", mpm_gradient_parameters="tip.valu")
    refuse("numbers", "has 2 numbers", mpm_gradient_parameters="tip.value")
    refuse("place", "has 2 numbers", mpm_gradient_parameters="tip.value:3")
    refuse("material", "no body is of the material", mpm_gradient_parameters="rock.E", mpm_materials="beam,rock",
           mpm_material_rock_type="hencky", mpm_material_rock_E=1e6, mpm_material_rock_nu=0.2, mpm_material_rock_density=1e3)
    refuse("zero", "no result depends on it", mpm_gradient_parameters="time.step", **beam)
    for method in ("adjoint", "tangent"):  # a strength that no point reaches
        refuse("unreached." + method, "beam.yield_stress: no result depends on it", mpm_gradient_method=method,
               mpm_gradient_parameters="beam.E,beam.yield_stress", mpm_material_beam_type="j2", mpm_material_beam_yield_stress=1e12,
               **{**beam, "mpm_time_end": 0.1})
