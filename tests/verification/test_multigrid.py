#!/usr/bin/env python3
"""Multigrid on coarser lattices, and on elements of lower order: few iterations that do not grow with the grid, whatever the shape, and the answer of a direct
solver, on any number of ranks; with inclined rollers, contact, small cuts and cells that do not divide; coarse operators without a matrix; refused settings."""
import json
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import Test, example  # noqa: E402

BLOCK = Path(__file__).resolve().parent / "levels.yaml"
HMG = {"mpm_solver": "hmg"}
PMG = {"mpm_solver": "pmg"}
ELEMENTS = {"mpm_shape": "gimp_element", "mpm_order": 2, "mpm_body_block_points_per_cell": "3,3,3"}
SHAPES = (("linear", 8, {}), ("gimp_bspline2", 12, {"mpm_multigrid_coarsen": 3}))


def iterations(run):
    """Of a linear solve."""
    return np.sum(run.results.column("linear")) / np.sum(run.results.column("newton"))


def apart(one, other, column="track_top_uz"):
    a, b = one.results.column(column), other.results.column(column)
    return np.max(np.abs(a - b)) / np.max(np.abs(a))


def summary(run):
    return json.loads(Path(run.prefix + "_summary.json").read_text(encoding="utf-8"))


def grids(test):
    """Linear functions and their averages: to 1e-10 at most 8 iterations, one more a refinement."""
    for shape in ("gimp",):
        coarse, fine = (test.run(BLOCK, mpm_shape=shape, mpm_grid_refine=refine, ksp_rtol=1e-10, **HMG) for refine in (1, 2))
        test.check(f"{shape}.most", max(iterations(coarse), iterations(fine)), None, 8)
        test.check(f"{shape}.growth", iterations(fine) - iterations(coarse), None, 1)


def answers(test):
    """The answer does not depend on solver, levels, smoother or ranks."""
    for shape, most, options in SHAPES:
        run = test.run(BLOCK, mpm_shape=shape, **options, **HMG)
        test.check(f"{shape}.iterations", iterations(run), None, most)
        test.check(f"{shape}.direct", apart(test.run(BLOCK, mpm_shape=shape, mpm_solver="direct"), run), None, 1e-9)
    direct = test.run(BLOCK, mpm_solver="direct", mpm_multigrid_levels=3, mpm_multigrid_smoother="auto")
    test.check("unused", float(direct.errors.strip() == "talus: warning: -mpm_multigrid_levels 3: not used, -mpm_solver is direct"), 1, 1)
    for name, options in (("levels", {"mpm_multigrid_levels": 3}), ("jacobi", {"mpm_multigrid_smoother": "jacobi"}), ("pbjacobi", {"mpm_multigrid_smoother": "pbjacobi"}),
                          ("gamg", {"mpm_multigrid_coarse": "gamg", "mpm_multigrid_smooths": 2}),
                          ("matfree", {"mpm_jacobian": "matfree", "ksp_rtol": 1e-8}), ("uneven", {"mpm_multigrid_coarsen": 3})):
        test.check(name, apart(direct, test.run(BLOCK, **options, **HMG)), None, 1e-9)
    three = test.run(BLOCK, ranks=3, mpm_multigrid_levels=3, **HMG)
    test.check("on_3", apart(direct, three), None, 1e-9)
    told = summary(three)
    test.check("levels.summary", told["levels"], 3, 3)
    test.check("levels.iterations", told["iterations_multigrid"], *2 * [np.sum(three.results.column("linear"))])
    test.check("levels.absent", "levels" in summary(direct), False, False)
    test.check("on_3.iterations", iterations(three), None, 8)


def coarse_operator(test, scene=BLOCK, material="rock", **options):
    """The coarsest level's matrix of a run, {(row, column): value}, and the shape of the matrix."""
    file = test.folder() / "coarse"
    test.run(scene, mg_coarse_ksp_view_mat=f"binary:{file}", mpm_multigrid_levels=3,
             **{**HMG, f"mpm_material_{material}_type": "linear_elastic", **options})
    data = file.read_bytes()
    _, rows, columns, entries = np.frombuffer(data, ">i4", 4)
    counts = np.frombuffer(data, ">i4", rows, 16)
    column = np.frombuffer(data, ">i4", entries, 16 + 4 * rows)
    matrix = np.zeros((rows, columns))
    matrix[np.repeat(np.arange(rows), counts), column] = np.frombuffer(data, ">f8", entries, 16 + 4 * (rows + entries))
    return matrix


def operators(test):
    """Without a matrix the coarse operators are summed from the points' tangents and element blocks; they are P^T A P."""
    for name, options in (("moved", {}), ("rollers", {"scene": BLOCK.parent / "rollers.yaml", "material": "block"}),
                          ("penalty", {"mpm_stabilization_ghost": 0.1, "mpm_shape": "bspline2"}),
                          ("elements", {**ELEMENTS, **PMG}),
                          ("inertia", {"mpm_time_integrator": "backward_euler", "mpm_time_step": 0.01, "mpm_time_end": 0.02})):
        assembled, summed = (coarse_operator(test, mpm_jacobian=form, **options) for form in ("local", "matfree"))
        test.check(f"operators.{name}", np.max(np.abs(assembled - summed)) / np.max(np.abs(assembled)), None, 1e-12)


def elements(test):
    """Orders of elements, then larger cells: the answer of a direct solver, by few iterations; with contact on 3 ranks."""
    whole = {"mpm_grid_cells": "3,3,3", "mpm_body_block_lower": "0.5,0.5,0", "mpm_body_block_upper": "1,1,1", "mpm_time_step_min": 1}
    for order, shape, points, most, options in ((2, "gimp_element", "3,3,3", 12, {}), (3, "element", "4,4,4", 16, whole),
                                                (4, "gimp_element", "6,6,6", 14, whole)):
        common = {"mpm_shape": shape, "mpm_order": order, "mpm_body_block_points_per_cell": points, "ksp_rtol": 1e-8, **options}
        direct, pmg = (test.run(BLOCK, mpm_solver=solver, **common) for solver in ("direct", "pmg"))
        test.check(f"order{order}.direct", apart(direct, pmg), None, 1e-9)
        test.check(f"order{order}.iterations", iterations(pmg), None, most)
        if order == 2:
            for name, more in (("matfree", {"mpm_jacobian": "matfree", "mpm_multigrid_precision": "single"}), ("hmg", {"mpm_solver": "hmg"})):
                test.check(f"order2.{name}", apart(direct, test.run(BLOCK, **{**PMG, **common, **more})), None, 1e-9)
            three = test.run(BLOCK, ranks=3, **common, **PMG)
            test.check("order2.on_3", apart(direct, three), None, 1e-9)
            test.check("order2.on_3.iterations", iterations(three) - iterations(pmg), None, 4)


def cells(test):
    """Stiff and soft points in the same cells: inverses of these where Jacobi's method does not serve; on 3 ranks."""
    hole = {"region": "sphere", "center": "0.77,0.73,0.5", "radius": 0.36, "points_per_cell": "4,4,4", "material": "air", "priority": "true"}
    air = {"type": "linear_elastic", "E": 100, "nu": 0, "density": 1e-6}
    options = {"mpm_shape": "element", "mpm_order": 2, "mpm_body_block_points_per_cell": "4,4,4", "mpm_materials": "rock,air",
               "mpm_material_rock_type": "linear_elastic", "mpm_material_rock_E": 1e8, "mpm_bodies": "block,hole", "ksp_rtol": 1e-8,
               "mpm_jacobian": "matfree", **{f"mpm_body_hole_{key}": value for key, value in hole.items()},
               **{f"mpm_material_air_{key}": value for key, value in air.items()}}
    one, jacobi = (test.run(BLOCK, mpm_multigrid_smoother=smoother, **options, **PMG) for smoother in ("auto", "jacobi"))
    three = test.run(BLOCK, ranks=3, **options, **PMG)
    test.check("cells.jacobi", iterations(one) / iterations(jacobi), None, 0.5)
    test.check("cells.answer", apart(one, jacobi), None, 1e-6)
    test.check("cells.on_3", apart(one, three), None, 1e-6)
    test.check("cells.on_3.iterations", iterations(three) / iterations(jacobi), None, 0.8)


def scenes(test):
    """Rollers at an angle, and contact with a Jacobian that is not symmetric: as many Newton iterations as a direct solver."""
    for name, scene, solver, options in (("rollers", BLOCK.parent / "rollers.yaml", "hmg", {}),
                                         ("two_supports", example("two_supports"), "hmg", {}),
                                         ("two_supports_elements", example("two_supports"), "pmg",
                                          {"mpm_shape": "gimp_element", "mpm_order": 2})):
        one, other = (test.run(scene, mpm_solver=which, **options) for which in ("direct", solver))
        test.check(f"{name}.newton", np.sum(other.results.column("newton")) / np.sum(one.results.column("newton")), None, 1.5)
        test.check(f"{name}.iterations", iterations(other), None, 25)


def refused(test):
    for name, value, message in (("multigrid_levels", 1, "must be auto or a number"),
                                 ("multigrid_levels", "many", "must be auto or a number"),
                                 ("multigrid_coarsen", 4, "-mpm_multigrid_coarsen"),
                                 ("multigrid_smoother", "sponge", "-mpm_multigrid_smoother"),
                                 ("multigrid_smoother", "cells", "needs -mpm_jacobian matfree"),
                                 ("mat_type", "baij", "not available with -mpm_solver hmg")):
        run = test.run(BLOCK, status=2, **{f"mpm_{name}": value}, **HMG)
        test.check(f"{name}.{value}", message in run.errors, True, True)
    for value, message, options in (("2,2", "must be auto or orders that decrease", ELEMENTS), ("3,1", "orders that decrease", ELEMENTS),
                                    ("2,0", "orders that decrease", ELEMENTS), ("2,1", "needs -mpm_shape element", {}),
                                    ("2,1", "only", {**ELEMENTS, **HMG})):
        run = test.run(BLOCK, status=2, mpm_multigrid_order=value, **{**PMG, **options})
        test.check(f"order.{value}.{message}", message in run.errors, True, True)


with Test() as harness:
    grids(harness)
    answers(harness)
    operators(harness)
    elements(harness)
    cells(harness)
    scenes(harness)
    refused(harness)
