#!/usr/bin/env python3
"""Compares a run of bps, its field at the nodes, with the solution."""
import sys
from pathlib import Path

import h5py
import numpy as np
from numpy.polynomial import legendre

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
import common  # noqa: E402
from common import Quantity, cells, completed  # noqa: E402

MORE = 6  # Gauss points an axis and cell beyond the order: the error of their quadrature is below 1e-7 of the error
# Upper bounds of the relative error for the cloud of (order + 2)^3 points a cell with fluxes as load, a tenth above what
# was measured, by order and cells an axis.
BOUNDS = {(2, 4): 1.45e-2, (2, 8): 1.86e-3}


def weierstrass(x, derivative=0):
    """The sum of 2^-n cos(1.5^n pi x) for n = 0, 1, 2, or a derivative of it."""
    terms = [(0.5 ** n, 1.5 ** n * np.pi) for n in range(3)]
    return sum(b * a ** derivative * np.cos(a * x + derivative * np.pi / 2) for b, a in terms)


def lobatto(order):
    """Gauss-Lobatto points of [-1, 1]."""
    inner = legendre.legroots(legendre.legder([0] * order + [1]))
    return np.concatenate([[-1], np.sort(inner), [1]])


def lagrange(nodes, x):
    """Lagrange's functions of the nodes at x, a column each."""
    ratio = [[np.ones_like(x) if k == i else (x - nodes[k]) / (nodes[i] - nodes[k]) for k in range(len(nodes))]
             for i in range(len(nodes))]
    return np.stack([np.prod(row, axis=0) for row in ratio], axis=1)


def nodal(results):
    """Values at the nodes, components first, then the lattice with the last axis first."""
    with h5py.File(results.prefix + ".h5", "r") as file:
        nodes = file["grid"][sorted(file["grid"])[-1]]["nodes"]
        place = nodes["position"][:]
        names = [name for name in ("u", *"xyz") if name in nodes]
        values = [nodes[name][:].reshape(-1) for name in names]
    order = np.lexsort(np.round(place, 9).T)
    side = round(len(place) ** (1 / place.shape[1]))
    shape = (side,) * place.shape[1]
    return np.stack([value[order].reshape(shape) for value in values])


def evaluation(results, x):
    """Matrix from nodal values along an axis to those at x of [-1, 1] in each cell, and these places."""
    order, count = int(results.option("mpm_order")), cells(results)[0]
    matrix = np.zeros((count * len(x), count * order + 1))
    for cell in range(count):
        matrix[cell * len(x):(cell + 1) * len(x), cell * order:(cell + 1) * order + 1] = lagrange(lobatto(order), x)
    return matrix, np.concatenate([(cell + (1 + x) / 2) / count for cell in range(count)])


def outer(line, dim):
    """The product of a function of one place along each axis."""
    product = np.ones(())
    for _ in range(dim):
        product = np.multiply.outer(product, line)
    return product


def error(results):
    """Relative L2 error of the field over the grid."""
    values = nodal(results)
    dim, count = values.ndim - 1, cells(results)[0]
    x, weight = legendre.leggauss(int(results.option("mpm_order")) + MORE)
    matrix, place = evaluation(results, x)
    exact, weight = outer(weierstrass(place), dim), outer(np.tile(weight / (2 * count), count), dim)
    square = norm = 0.0
    for component, field in enumerate(values):
        for _ in range(dim):  # one axis after the other, each goes to the end
            field = np.tensordot(field, matrix, axes=(0, 1))
        square += np.sum(weight * (field - (component + 1) * exact) ** 2)
        norm += np.sum(weight * ((component + 1) * exact) ** 2)
    return np.sqrt(square / norm)


def order_of(coarse, fine):
    """Observed order of an error when the cells are halved."""
    return np.log2(coarse / fine)


def check(results):
    key = int(results.option("mpm_order")), cells(results)[0]
    return [completed(results), Quantity("error", error(results), upper=BOUNDS.get(key, 0.5))]


def draw(results):
    import matplotlib.pyplot as plt

    matrix, place = evaluation(results, np.linspace(-1, 1, 16))
    values = nodal(results)[0]
    middle = values.shape[0] // 2  # a plane of nodes, in the middle for an even number of cells
    field = matrix @ values[middle] @ matrix.T
    exact = outer(weierstrass(place), 2) * weierstrass(0.5)
    figure, axes = plt.subplots(1, 2, figsize=(10, 4.2), constrained_layout=True)
    for axis, value, title in ((axes[0], field, "u in the middle plane"), (axes[1], field - exact, "u less the solution")):
        dots = axis.pcolormesh(place, place, value, shading="gouraud", cmap="coolwarm")
        figure.colorbar(dots, ax=axis)
        axis.set(title=title, xlabel="x (m)", ylabel="y (m)", aspect="equal")
    return figure


if __name__ == "__main__":
    common.main(check, draw)
