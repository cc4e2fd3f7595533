#!/usr/bin/env python3
"""Where the end of the cantilever of `bench.py error-time` ought to be, from finite elements of high order.

    scripts/bench/cantilever_reference.py [--degree 4] [--layers 2 4]

Elements of degree p with Gauss-Lobatto nodes in the initial configuration, for the beam of cantilever_weight.yaml: 10 m
long, 1 m deep, plane strain, compressible neo-Hookean, clamped at its root, under its weight in equal steps. The stress
is singular at the two corners of the root: elements there shrink towards them by a factor a layer.

Prints u/L and v/L of the middle of the end section. Degree 4: -0.551250, -0.842709 with 40 x 4 equal elements (no
layers), -0.551265, -0.842724 with 2 layers, -0.551266, -0.842725 with 4, which takes 2 minutes.
"""
import argparse

import numpy as np
import scipy.sparse
import scipy.sparse.linalg

LENGTH, DEPTH, STEPS = 10.0, 1.0, 20  # m, m
E, NU, WEIGHT = 12e6, 0.2, 1000.0 * 20.0  # Pa, 1, N/m3
MU, LAME = E / (2 * (1 + NU)), E * NU / ((1 + NU) * (1 - 2 * NU))
SHRINK, CORNER = 0.35, 0.25  # of an element to the next, m in which they do
UNIT = np.eye(2)


def basis(degree):
    """Gauss points and weights; values and derivatives of the nodal basis there; the nodes, on [-1, 1]."""
    legendre = np.polynomial.legendre.Legendre.basis(degree)
    nodes = np.concatenate([[-1.0], np.sort(legendre.deriv().roots().real), [1.0]])
    points, weights = np.polynomial.legendre.leggauss(degree + 2)
    coefficients = np.linalg.inv(np.vander(nodes, increasing=True))
    powers = np.vander(points, degree + 1, increasing=True)
    return points, weights, powers @ coefficients, (powers[:, :-1] * np.arange(1, degree + 1)) @ coefficients[1:], nodes


def edges(layers):
    """Lines between elements along the beam and across it."""
    if not layers:
        return np.linspace(0, LENGTH, 41), np.linspace(0, DEPTH, 5)
    corner = CORNER * np.concatenate([[0.0], SHRINK ** np.arange(layers, -1, -1.0)])
    along = np.concatenate([corner, np.linspace(CORNER, LENGTH, 32)[1:]])
    return along, np.concatenate([corner, [0.5 * DEPTH], DEPTH - corner[::-1]])


class Mesh:
    """Nodes of each element, gradients (element, point, node, axis) and weights (element, point)."""

    def __init__(self, degree, layers):
        _, weights, value, slope, nodes = basis(degree)
        along, across = edges(layers)
        lines = [np.concatenate([[e[0]], *(a + (nodes[1:] + 1) / 2 * (b - a) for a, b in zip(e, e[1:]))])
                 for e in (along, across)]
        self.columns, self.rows = len(lines[0]), len(lines[1])
        both = [np.einsum("bj,ai->baji", q, p).reshape(len(weights) ** 2, -1)
                for q, p in ((value, slope), (slope, value), (value, value))]
        area = np.outer(weights, weights).ravel()
        local, element, gradient, weight = np.arange(degree + 1), [], [], []
        for j, high in enumerate(np.diff(across) / 2):
            for i, wide in enumerate(np.diff(along) / 2):
                element.append(((j * degree + local)[:, None] * self.columns + i * degree + local).ravel())
                gradient.append(np.stack([both[0] / wide, both[1] / high], -1))
                weight.append(area * wide * high)
        self.element, self.gradient, self.weight = np.array(element), np.array(gradient), np.array(weight)
        self.unknowns = np.stack([2 * self.element, 2 * self.element + 1], -1).reshape(len(element), -1)
        self.load = np.zeros(2 * self.columns * self.rows)
        np.add.at(self.load, 2 * self.element + 1, -WEIGHT * self.weight @ both[2])
        self.free = np.flatnonzero(np.arange(self.load.size) // 2 % self.columns)  # all but the root
        self.end = (np.abs(lines[1] - DEPTH / 2).argmin() + 1) * self.columns - 1


def forces(mesh, u):
    """Internal forces and the tangent."""
    count, nodes = mesh.element.shape
    F = np.einsum("eni,eqnJ->eqiJ", u[mesh.unknowns].reshape(count, nodes, 2), mesh.gradient) + UNIT
    inverse, log = np.linalg.inv(F), np.log(np.linalg.det(F))
    transposed = np.swapaxes(inverse, -1, -2)
    stress = MU * (F - transposed) + LAME * log[..., None, None] * transposed
    internal = np.zeros_like(u)
    np.add.at(internal, mesh.unknowns,
              np.einsum("eqiJ,eqnJ,eq->eni", stress, mesh.gradient, mesh.weight).reshape(count, -1))
    values = np.empty((count, 2 * nodes, 2 * nodes))
    for e, (back, ln) in enumerate(zip(inverse, log)):
        A = (MU * np.einsum("ik,JL->iJkL", UNIT, UNIT) + LAME * np.einsum("qJi,qLk->qiJkL", back, back)
             + np.einsum("q,qJk,qLi->qiJkL", MU - LAME * ln, back, back))
        half = np.einsum("qiJkL,qnJ,q->qnikL", A, mesh.gradient[e], mesh.weight[e], optimize=True)
        values[e] = np.einsum("qnikL,qmL->nimk", half, mesh.gradient[e], optimize=True).reshape(values[e].shape)
    rows = np.repeat(mesh.unknowns, 2 * nodes, axis=1).ravel()
    columns = np.tile(mesh.unknowns, (1, 2 * nodes)).ravel()
    return internal, scipy.sparse.csr_matrix((values.ravel(), (rows, columns)), shape=(u.size, u.size))


def solve(mesh):
    """u/L and v/L of the middle of the end section."""
    u, last, free = np.zeros_like(mesh.load), np.zeros_like(mesh.load), mesh.free
    for step in range(1, STEPS + 1):
        u, last = 2 * u - last, u
        while True:
            internal, tangent = forces(mesh, u)
            residual = (internal - step / STEPS * mesh.load)[free]
            change = scipy.sparse.linalg.spsolve(tangent[free][:, free].tocsc(), residual)
            u[free] -= change
            if np.abs(change).max() < 1e-8 * LENGTH:
                break
    return u[2 * mesh.end : 2 * mesh.end + 2] / LENGTH


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--degree", type=int, default=4, metavar="P", help="of the elements")
    parser.add_argument("--layers", type=int, nargs="+", default=[2, 4], metavar="N", help="towards the root's corners")
    arguments = parser.parse_args()
    for layers in arguments.layers:
        mesh = Mesh(arguments.degree, layers)
        u, v = solve(mesh)
        print(f"{layers} layers, {mesh.load.size} unknowns: u/L {u:.7f}, v/L {v:.7f}", flush=True)


if __name__ == "__main__":
    main()
