"""Factor of safety of a vertical cut: error against time, beside the limit load of the discretisation itself.

Cut in clay of 10 m (Pastor et al. 2009: gamma H/s_u = 3.776, a factor of 1.133). The second factor is that of a kinematic limit
analysis of the same functions and points: the least dissipation, s_u times the shear rate, at the power 1 of the weight and
without a mean change of volume (polynomials of degree order - 1 in a cell), by viscosities s_u/rate that are solved again. No
run on that grid can come closer to 1.133; what Talus has beside it is the program's own error.
"""
import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import spsolve

from bench.runs import ROOT, Table, median, repeated, run_scene

SCENE = ROOT / "tests" / "verification" / "vertical_cut.yaml"
EXACT, HEIGHT, WIDTH, TOE, FACE = 1.133, 10.0, 26.0, 6.0, 16.0  # factor; m: of the scene
RESISTANCE = 60e3 / 20e3  # m: strength over weight, of the scene
SWEEPS, VOLUME = 120, 1e5  # solves; stiffness of volume over the median viscosity
ROWS = [("gimp", 1, 2, n) for n in (10, 20, 40)] + [("gimp_bspline2", 0, 2, 20), ("gimp_element", 2, 3, 10), ("gimp_element", 2, 3, 20),
                                                    ("gimp_element", 3, 4, 10)]


def add_arguments(parser):
    parser.set_defaults(ranks=1)


def lagrange(order, x):
    """Values and derivatives (order + 1, places) of the functions of equidistant nodes in [0, 1], whose span is that of the element's."""
    basis = [np.poly1d(np.linalg.solve(np.vander(np.linspace(0, 1, order + 1)), row)) for row in np.eye(order + 1)]
    return np.array([f(x) for f in basis]), np.array([f.deriv()(x) for f in basis])


def of_cell(order, points, h):
    """Averages over the points' domains of values and gradients, (points^2, (order + 1)^2) each, in a cell of size h."""
    edges = np.arange(points + 1) / points
    gauss, weight = np.polynomial.legendre.leggauss(order + 1)
    places = edges[:-1, None] + (gauss + 1) / (2 * points)
    value, slope = (np.tensordot(part.reshape(order + 1, points, -1), weight / 2, 1).T for part in lagrange(order, places.ravel()))
    return np.kron(value, value), np.kron(slope, value) / h, np.kron(value, slope) / h


def limit(order, points, cells):
    """The factor of safety of the cut by limit analysis with `cells` in its height."""
    h = HEIGHT / cells
    columns, rows = round(WIDTH / h), round((HEIGHT + TOE) / h)
    filled = [(i, j) for i in range(columns) for j in range(rows) if (i + 0.5) * h < FACE or (j + 0.5) * h < TOE]
    along, up, own = columns * order + 1, rows * order + 1, np.arange(order + 1)
    nodes = np.array([((i * order + own)[:, None] * up + j * order + own).ravel() for i, j in filled])
    value, by_x, by_y = of_cell(order, points, h)

    def operator(of_x, of_y):
        """Rows: of_x times u_x plus of_y times u_y in each cell."""
        count = len(of_x)
        row = np.repeat(np.arange(len(nodes) * count).reshape(-1, count), nodes.shape[1], 1).ravel()
        column = np.repeat(2 * nodes[:, None], count, 1).ravel()
        return sp.csr_matrix((np.concatenate([np.tile(of_x.ravel(), len(nodes)), np.tile(of_y.ravel(), len(nodes))]),
                              (np.concatenate([row, row]), np.concatenate([column, column + 1]))), shape=(len(nodes) * count, 2 * along * up))

    place = (np.arange(points) + 0.5) / points - 0.5
    x, y = (part.ravel() for part in np.meshgrid(place, place, indexing="ij"))
    modes = np.linalg.qr(np.array([x**a * y**b for a in range(order) for b in range(order - a)]).T)[0].T
    weight = np.zeros(2 * along * up)
    np.add.at(weight, 2 * nodes + 1, -value.sum(0) * (h / points) ** 2)
    held = np.ones((along, up, 2), bool)
    held.reshape(-1, 2)[nodes.ravel()] = False
    held[[0, -1], :, 0] = held[:, 0] = True
    free = np.flatnonzero(~held.ravel())
    stretch, shear, volume = (matrix[:, free] for matrix in (operator(by_x, -by_y), operator(by_y, by_x), operator(modes @ by_x, modes @ by_y)))
    weight, viscosity, area = weight[free], np.ones(stretch.shape[0]), (h / points) ** 2
    for sweep in range(SWEEPS):
        diagonal = sp.diags(viscosity)
        speed = spsolve((stretch.T @ diagonal @ stretch + shear.T @ diagonal @ shear + VOLUME * volume.T @ volume).tocsc(), weight)
        speed /= weight @ speed
        rate = np.hypot(stretch @ speed, shear @ speed)
        viscosity = 1 / np.hypot(rate, rate.max() * 0.01 * max(1e-3, 0.9**sweep))
        viscosity /= np.median(viscosity)
    return RESISTANCE * area * rate.sum()


def run(arguments):
    table = Table(arguments.out, "limit", ("shape", "order", "points", "cells", "factor", "error_percent", "limit_percent", "seconds"))
    for shape, order, points, cells in ROWS[:1] if arguments.quick else ROWS:
        options = {"mpm_shape": shape, "mpm_grid_cells": f"{round(2.6 * cells)},{round(1.8 * cells)}",
                   "mpm_body_cut_points_per_cell": f"{points},{points}"} | ({"mpm_order": order} if order > 1 else {})
        runs = repeated(arguments.repeat or 1, lambda: run_scene(arguments.program, SCENE, options, arguments.ranks))
        factor = runs[0]["factor_of_safety"]
        best = 100 * (limit(order, points, cells) / EXACT - 1) if order else ""
        table.add(shape=shape, order=order or 2, points=points**2, cells=cells, factor=factor, error_percent=100 * (factor / EXACT - 1),
                  limit_percent=best, seconds=median(runs, "time_total_s"))
