#!/usr/bin/env python3
"""Linear solvers of saturated ground, and when its fields have converged: blocks against factors over permeability, step and grid;
no system of units is preferred; a linear problem takes one iteration of Newton's."""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import Test  # noqa: E402

SEAM = Path(__file__).resolve().parent / "seam.yaml"
BLOCKS = {"mpm_solver": "poro-fieldsplit"}
COLUMNS = ("reaction_base_y", "reaction_top_p", "track_under_ux", "track_under_uy")


def ground(permeability, seam, step, **options):
    return {"mpm_material_ground_permeability": permeability, "mpm_material_seam_permeability": seam, "mpm_time_step": step,
            "mpm_time_end": 2 * step, **options}


def apart(one, other, columns=COLUMNS, scales=None):
    """The largest difference of the histories, each column over its largest number."""
    worst = 0.0
    for column in columns:
        a, b = one.results.column(column), (scales or {}).get(column, 1.0) * other.results.column(column)
        worst = max(worst, np.max(np.abs(a - b)) / np.max(np.abs(a)))
    return worst


def iterations(run):
    return np.sum(run.results.column("linear")) / np.sum(run.results.column("newton"))


def blocks(test):
    """The same answer as by factors, in few iterations that hardly grow."""
    cases = ((1e-8, 1e-8, 1e3), (1e-16, 1e-16, 1e-3), (1e-8, 1e-16, 1e3), (1e-16, 1e-8, 1e3))
    for k, seam, step in cases:
        name, options = f"{k:g}_{seam:g}_{step:g}", ground(k, seam, step)
        coarse, fine = (test.run(SEAM, mpm_grid_refine=refine, **options, **BLOCKS) for refine in (1, 2))
        test.check(f"{name}.most", iterations(fine), None, 12)  # factorised blocks: 6 to 9
        test.check(f"{name}.growth", iterations(fine) / iterations(coarse), None, 1.25)
        test.check(f"{name}.direct", apart(test.run(SEAM, mpm_solver="direct", **options), coarse), None, 1e-8)
    options = ground(1e-12, 1e-14, 1.0)
    one = test.run(SEAM, **options, **BLOCKS)
    for ranks in (2, 3):
        test.check(f"on_{ranks}", apart(one, test.run(SEAM, ranks=ranks, **options, **BLOCKS)), None, 1e-8)
    test.check("matfree", apart(one, test.run(SEAM, mpm_jacobian="matfree", **options, **BLOCKS)), None, 1e-8)
    gamg = test.run(SEAM, fieldsplit_u_pc_type="gamg", **options, **BLOCKS)
    test.check("gamg", apart(one, gamg), None, 1e-8)
    test.check("fewer", iterations(one) / iterations(gamg), None, 1.0)


def units(test):
    """Pa and kPa: the same numbers of iterations, and the same answer. And fields converge far below what Newton needs for the sum."""
    options = ground(1e-12, 1e-12, 1.0, mpm_solver="direct")
    kilo = {"mpm_material_ground_E": 10e3, "mpm_material_seam_E": 10e3, "mpm_load_strip_value": "0,-100", "mpm_water_viscosity": 1e-6}
    pascal, other = test.run(SEAM, **options), test.run(SEAM, **options, **kilo)
    test.check("units.same", apart(pascal, other, scales={"reaction_base_y": 1e3}), None, 1e-8)
    test.check("units.newton", np.sum(np.abs(pascal.results.column("newton") - other.results.column("newton"))), 0, 0)
    tight = test.run(SEAM, **options, snes_rtol=1e-12)
    test.check("converged", apart(tight, pascal), None, 1e-8)


def linear(test):
    """Small strain: one iteration, by LDL^T and by LU, which is the same."""
    options = ground(1e-10, 1e-15, 10.0, mpm_solver="direct", mpm_material_ground_type="linear_elastic",
                     mpm_material_seam_type="linear_elastic")
    run = test.run(SEAM, **options)
    test.check("linear.newton", np.max(run.results.column("newton")), 1, 1)
    test.check("linear.lu", apart(run, test.run(SEAM, pc_type="lu", **options)), None, 1e-9)


with Test() as harness:
    blocks(harness)
    units(harness)
    linear(harness)
