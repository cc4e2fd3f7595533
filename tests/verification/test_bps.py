#!/usr/bin/env python3
"""CEED's problems BP1 to BP4: two physics outside the tree, without displacement, whose field has one component or one an axis.

Errors against numbers of tensor quadrature at Gauss points (computed apart, with numpy, from one-dimensional matrices for BP1), and
iterations of the conjugate gradient method to 1e-10 in its natural norm. --full: orders 3 and 4, clouds of points. Quick.
"""
import sys
from pathlib import Path

import numpy as np
from numpy.polynomial import legendre

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import EXAMPLES, FULL, Run, Test, difference  # noqa: E402

sys.path.insert(0, str(EXAMPLES / "bps"))
from check import MORE, error, lagrange, lobatto, nodal, order_of, weierstrass  # noqa: E402

# Relative error and iterations with 8^3 cells by order: u = W(x) W(y) W(z), order + 2 Gauss points an axis in a cell.
PROJECTION = {1: (1.768489e-2, 29), 2: (1.557580e-3, 16), 3: (4.674741e-5, 8), 4: (2.428252e-6, 6)}
POISSON = {1: (5.467784e-2, 19), 2: (1.679799e-3, 64), 3: (7.377077e-5, 107), 4: (2.839659e-6, 156)}
PLANE = {"mpm_dim": 2, "mpm_grid_lower": "0,0", "mpm_grid_upper": "1,1", "mpm_grid_cells": "4,4", "mpm_body_cube_lower": "0,0",
         "mpm_body_cube_upper": "1,1", "mpm_body_cube_points_per_cell": "4,4"}
EDGES = ("west", "east", "south", "north", "bottom", "top")
REFUSED = {"loads": ({"mpm_loads": "g", "mpm_load_g_type": "gravity", "mpm_load_g_value": "0,0,-1"}, "-mpm_loads: not available for physics poisson"),
           "ghost": ({"mpm_stabilization_ghost": 0.1}, "-mpm_stabilization_ghost: not available for physics poisson"),
           "normal": ({"mpm_bcs": "edge_west,a", "mpm_bc_a_region": "box", "mpm_bc_a_lower": "0,0,0", "mpm_bc_a_upper": "0,1,1",
                       "mpm_bc_a_normal": "1,0,0"}, "-mpm_bc_a_normal: the physics has no displacement"),
           "backgrounds": ({"mpm_backgrounds": "d", "mpm_background_d_region": "box", "mpm_background_d_lower": "0,0,0",
                            "mpm_background_d_upper": "1,1,1", "mpm_background_d_E": 1, "mpm_background_d_nu": 0}, "-mpm_backgrounds: not available"),
           "inertia": ({"mpm_time_integrator": "newmark"}, "has no inertia"),
           "component": ({"mpm_bc_edge_west_components": "x"}, "-mpm_bc_edge_west_components x: this scene has no such unknown")}


def run(test, physics, order, cells, status=0, ranks=1, points="gauss", load="value", **more):
    """A run of the program bps beside talus."""
    poisson, build = physics.startswith("poisson"), test.program.parent
    build = build if (build / "bps").exists() else build.parent
    options = {"mpm_plugin": build / "bp.so", "mpm_physics": physics, "mpm_order": order, "mpm_grid_cells": f"{cells},{cells},{cells}",
               "mpm_body_cube_points_per_cell": ",".join(3 * [str(order + 2)]), "bps_points": points, "bps_load": load,
               "mpm_jacobian": "matfree", "ksp_type": "cg", "ksp_norm_type": "natural", "ksp_rtol": 1e-10,
               "snes_rtol": 1e-4, "mpm_output_fields": "volume", "mpm_quiet": None}
    if "mpm_solver" not in more:
        options.update(mpm_solver="pbjacobi", pc_type="none" if poisson else "jacobi")
    for edge in EDGES if physics == "poisson_vector" else ():
        options[f"mpm_bc_edge_{edge}_components"] = "x,y,z"
    scene = EXAMPLES / "bps" / ("case.yaml" if poisson else "projection.yaml")
    ended = Run(build / "bps", scene, ranks, {**options, **more}, test.folder())
    if status is not None:
        test.check(f"{physics}.{order}.{ranks}.status", ended.status, status, status)
    return ended


def table(test, physics, order, known, **more):
    ended = run(test, physics, order, 8, **more)
    label = f"{physics}.{order}.{more.get('ranks', 1)}"
    test.near(f"{label}.error", error(ended.results), known[0], relative=1e-5)
    test.near(f"{label}.iterations", ended.results.summary["linear_iterations"], known[1], absolute=1)


def projection_error(dim, order, count):
    """Relative error of a projection by order + 2 Gauss points an axis, from its factors along one axis."""
    def line(points):
        x, weight = legendre.leggauss(points)
        basis = np.zeros((count * points, count * order + 1))
        for cell in range(count):
            basis[cell * points:(cell + 1) * points, cell * order:(cell + 1) * order + 1] = lagrange(lobatto(order), x)
        place = np.concatenate([(cell + (1 + x) / 2) / count for cell in range(count)])
        return basis, weierstrass(place), np.tile(weight / (2 * count), count)

    basis, exact, weight = line(order + 2)
    field = np.linalg.solve(basis.T @ (weight[:, None] * basis), basis.T @ (weight * exact))
    basis, exact, weight = line(order + MORE)
    squares = [np.sum(weight * a * b) ** dim for a, b in ((basis @ field, basis @ field), (basis @ field, exact), (exact, exact))]
    return np.sqrt((squares[0] - 2 * squares[1] + squares[2]) / squares[2])


def plane(test):
    """In the plane, of one and of two components."""
    for physics in ("projection", "projection_vector"):
        ended = run(test, physics, 2, 4, **PLANE)
        test.near(f"plane.{physics}", error(ended.results), projection_error(2, 2, 4), relative=1e-6)


def forms(test):
    """The field is the same by a matrix and without, with points between the cells' Gauss points."""
    for physics in ("poisson", "poisson_vector"):
        fields = [nodal(run(test, physics, 2, 3, points="random", mpm_jacobian=form).results) for form in ("local", "matfree")]
        test.check(f"forms.{physics}", difference(*fields), upper=1e-8)


def clouds(test, orders):
    """Fluxes as load keep the order of the element on a cloud of points; values with volumes as weights stay below 2."""
    for order in orders:
        for load, lower, upper in (("flux", order + 0.8, None), ("value", None, 2)):
            errors = [error(run(test, "poisson", order, cells, points="cloud", load=load).results) for cells in (4, 8)]
            test.check(f"cloud.{order}.{load}.order", order_of(*errors), lower, upper)


def multigrid(test, orders, counts):
    """Iterations of BP3 by orders of elements and larger cells, at Gauss points and on a cloud, hardly grow with the grid."""
    for order in orders:
        for points in ("gauss", "cloud"):
            runs = [run(test, "poisson", order, cells, points=points, load="flux", mpm_solver="pmg", mpm_jacobian="auto")
                    for cells in counts]
            steps = [ended.results.summary["linear_iterations"] for ended in runs]
            test.check(f"multigrid.{order}.{points}", max(steps), upper=8)
            test.check(f"multigrid.{order}.{points}.growth", steps[-1] - steps[0], upper=1)


with Test() as test:
    for order in (1, 2, 3, 4) if FULL else (1, 2):
        table(test, "projection", order, PROJECTION[order])
        table(test, "poisson", order, POISSON[order])
        if FULL or order == 1:
            table(test, "projection_vector", order, PROJECTION[order])
            table(test, "poisson_vector", order, POISSON[order])
    table(test, "poisson", 1, POISSON[1], ranks=3)
    table(test, "projection", 1, PROJECTION[1], ranks=3)
    test.check_example("example", run(test, "poisson", 2, 4, points="cloud", load="flux"), "bps")
    plane(test)
    forms(test)
    multigrid(test, (2, 3, 4) if FULL else (2,), (4, 8) if FULL else (2, 4))
    clouds(test, (1, 2, 3, 4) if FULL else (1,))
    for name, (options, text) in REFUSED.items():
        refused = run(test, "poisson", 1, 2, status=None, **options)
        test.check(f"{name}.refused", int(refused.status != 0 and text in refused.errors and not refused.files), 1, 1)
