#!/usr/bin/env python3
"""Cook's membrane at small strain by finite elements of high order: the numbers of reference.csv. Needs scipy.

    reference.py             # convergence at nu = 0.499, then the rows of reference.csv
    reference.py --classic   # the same program on the problem as Cook posed it: plane stress, nu = 1/3, E = F = 1

Displacement elements of degree p on Gauss-Lobatto points. They do not lock at high degree, and the mesh grows finer
geometrically, by 0.15 an element, towards all four corners, where the stress is singular: convergence is exponential.
Shares nothing with the material point method but the problem.
"""
import sys

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import splu

WIDTH, LEFT, RISE, RIGHT = 48.0, 44.0, 44.0, 16.0  # m: x, left edge, foot of the right edge, right edge
GRADING = 0.15  # ratio of neighbouring elements next to a corner
PLACES = {"foot": 0.0, "middle": 0.5, "corner": 1.0}  # along the right edge: (48, 44), (48, 52), (48, 60)
RATIOS = (0.0, 0.3, 0.49, 0.499, 0.4999)  # Poisson's, for the table


def lobatto(degree):
    """Gauss-Lobatto points on [0, 1]."""
    inner = np.polynomial.legendre.Legendre.basis(degree).deriv().roots()
    return 0.5 * (np.concatenate([[-1.0], inner, [1.0]]) + 1.0)


def lagrange(nodes, points):
    """Values and derivatives at the points of the polynomials that are 1 at one node, (points, nodes)."""
    values, slopes = np.empty((2, len(points), len(nodes)))
    for i, node in enumerate(nodes):
        others = np.delete(nodes, i)
        scale = np.prod(node - others)
        values[:, i] = np.prod(points[:, None] - others, axis=1) / scale
        slopes[:, i] = sum(np.prod(points[:, None] - np.delete(others, k), axis=1) for k in range(len(others))) / scale
    return values, slopes


def graded(layers):
    """Breaks of [0, 1] that grow denser towards both ends; an even number of elements."""
    half = 0.5 * np.concatenate([[0.0], GRADING ** np.arange(layers, -1, -1.0)])
    return np.concatenate([half, 1.0 - half[-2::-1]])


def gradients(breaks, element, basis, rule):
    """Of the element's basis functions at its Gauss points, (points, functions, 2), and the points' areas."""
    (points, weights), (values, slopes) = rule, basis
    (i, j), count = element, len(points)
    sizes = breaks[i + 1] - breaks[i], breaks[j + 1] - breaks[j]
    xi = np.repeat(breaks[i] + sizes[0] * points, count)
    eta = np.tile(breaks[j] + sizes[1] * points, count)
    by_xi = (slopes[:, None, :, None] * values[None, :, None, :]).reshape(count**2, -1) / sizes[0]
    by_eta = (values[:, None, :, None] * slopes[None, :, None, :]).reshape(count**2, -1) / sizes[1]
    # x = WIDTH xi, y = RISE xi + eta height(xi)
    height, slant = LEFT + (RIGHT - LEFT) * xi, RISE + eta * (RIGHT - LEFT)
    by_y = by_eta / height[:, None]
    by_x = (by_xi - slant[:, None] * by_y) / WIDTH
    area = np.outer(weights, weights).ravel() * sizes[0] * sizes[1] * WIDTH * height
    return np.stack([by_x, by_y], axis=-1), area


def element_stiffness(gradient, area, lame, shear):
    """lambda tr(eps) tr(eps') + 2 mu eps : eps', components interleaved."""
    weighted = gradient * area[:, None, None]
    products = np.einsum("qia,qjb->iajb", weighted, gradient, optimize=True)
    stiffness = lame * products + shear * products.transpose(0, 3, 2, 1)
    stiffness += shear * np.einsum("icjc->ij", products)[:, None, :, None] * np.eye(2)[None, :, None, :]
    size = 2 * gradient.shape[1]
    return stiffness.reshape(size, size)


def solve(degree, layers, lame, shear, force):
    """Vertical displacement at PLACES under a force spread evenly over the right edge."""
    breaks, nodes = graded(layers), lobatto(degree)
    elements, line = len(breaks) - 1, degree * (len(breaks) - 1) + 1
    points, weights = np.polynomial.legendre.leggauss(degree + 2)
    rule = 0.5 * (points + 1.0), 0.5 * weights
    basis = lagrange(nodes, rule[0])
    rows, columns, entries = [], [], []
    for i in range(elements):
        for j in range(elements):
            local = ((degree * i + np.arange(degree + 1))[:, None] * line + degree * j + np.arange(degree + 1)).ravel()
            unknowns = (2 * local[:, None] + [0, 1]).ravel()
            gradient, area = gradients(breaks, (i, j), basis, rule)
            rows.append(np.repeat(unknowns, len(unknowns)))
            columns.append(np.tile(unknowns, len(unknowns)))
            entries.append(element_stiffness(gradient, area, lame, shear).ravel())
    size = 2 * line**2
    index = np.concatenate(rows), np.concatenate(columns)
    matrix = sparse.csc_matrix((np.concatenate(entries), index), shape=(size, size))
    load = np.zeros(size)
    for j in range(elements):
        edge = (line - 1) * line + degree * j + np.arange(degree + 1)
        load[2 * edge + 1] += force * (breaks[j + 1] - breaks[j]) * (rule[1] @ basis[0])
    free = np.arange(2 * line, size)  # the first row of nodes, xi = 0, is clamped
    displacement = np.zeros(size)
    displacement[free] = splu(matrix[free][:, free]).solve(load[free])
    edge = displacement[2 * (line - 1) * line + 1:: 2]
    places = [degree * int(np.argmin(np.abs(breaks - at))) for at in PLACES.values()]
    return edge[places], size


def moduli(young, poisson, plane_stress=False):
    """Lame's constants; in plane stress lambda is the reduced one."""
    shear = young / (2.0 * (1.0 + poisson))
    lame = young * poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson))
    return (2.0 * lame * shear / (lame + 2.0 * shear) if plane_stress else lame), shear


def print_row(head, degree, layers, constants):
    values, unknowns = solve(degree, layers, *constants, force=1.0)
    print(head or f"{degree},{layers},{unknowns}", *(f"{value:.7f}" for value in values), sep=",", flush=True)


if __name__ == "__main__":
    classic = "--classic" in sys.argv[1:]
    print("degree,layers,unknowns", *PLACES, sep=",")
    for fine in ((2, 2), (4, 2), (6, 2), (6, 4), (8, 4), (10, 4), (10, 6)):
        print_row(None, *fine, moduli(1.0, 1.0 / 3.0, True) if classic else moduli(70.0, 0.499))
    if not classic:
        print("nu", *PLACES, sep=",")
        for ratio in RATIOS:
            print_row(f"{ratio:g}", 10, 4, moduli(70.0, ratio))
