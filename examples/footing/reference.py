#!/usr/bin/env python3
"""A rigid rough footing on half a block of clay by finite elements: the rows of reference.csv. Needs scipy.

Small strain, von Mises, squares with four nodes and the mean dilatation (B-bar) against locking. Shares with the scene
the problem and where the constrained nodes stand, so that both see the same width of the footing.
"""
import numpy as np
from scipy import sparse
from scipy.sparse.linalg import splu

WIDTH, DEPTH, HALF = 5.0, 5.0, 1.0  # m: ground, half footing
YOUNG, POISSON, STRENGTH = 10e6, 0.49, 10e3  # Pa, -, Pa
SETTLEMENT, STEPS = 0.04, 50  # m
CORNERS = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
TWICE_SHEAR = YOUNG / (1.0 + POISSON)
BULK = YOUNG / (3.0 * (1.0 - 2.0 * POISSON))
UNIT = np.array([1.0, 1.0, 1.0, 0.0])  # xx, yy, zz, xy
COUNTED = np.array([1.0, 1.0, 1.0, 2.0])  # how often a component stands in the full tensor
DEVIATOR = np.diag([1.0, 1.0, 1.0, 0.5]) - np.outer(UNIT, UNIT) / 3.0  # of strains whose xy part is doubled


def strain_matrices(size, mean=True):
    """Strain (xx, yy, zz, twice xy) by displacement of an element's nodes, at its 2 x 2 Gauss points."""
    matrices = np.zeros((4, 4, 8))
    for matrix, (x, y) in zip(matrices, CORNERS / np.sqrt(3.0)):
        by_x = CORNERS[:, 0] * (1.0 + CORNERS[:, 1] * y) / (2.0 * size)
        by_y = CORNERS[:, 1] * (1.0 + CORNERS[:, 0] * x) / (2.0 * size)
        matrix[0, 0::2], matrix[1, 1::2], matrix[3, 0::2], matrix[3, 1::2] = by_x, by_y, by_y, by_x
    if mean:
        volumetric = matrices[:, :3].sum(axis=1)
        matrices[:, :3] += ((volumetric.mean(axis=0) - volumetric) / 3.0)[:, None, :]
    return matrices


def stress(strain, plastic):
    """Radial return from the deviator of the plastic strain: stress, tangent, new plastic strain."""
    strain = strain * [1.0, 1.0, 1.0, 0.5]
    volume = strain[..., :3].sum(axis=-1, keepdims=True)
    deviator = strain - volume / 3.0 * UNIT
    trial = deviator - plastic
    norm = np.sqrt(np.sum(COUNTED * trial**2, axis=-1, keepdims=True))
    limit = np.sqrt(2.0) * STRENGTH / TWICE_SHEAR
    factor = np.where(norm > limit, limit / np.maximum(norm, 1e-300), 1.0)
    along = np.where(norm > limit, trial / np.maximum(norm, 1e-300), 0.0)
    tangent = BULK * np.outer(UNIT, UNIT) + TWICE_SHEAR * factor[..., None] * (
        DEVIATOR - along[..., :, None] * along[..., None, :])
    return TWICE_SHEAR * factor * trial + BULK * volume * UNIT, tangent, deviator - factor * trial


class Ground:
    """Mesh of squares, constrained nodes, and the assembly."""

    def __init__(self, size, mean):
        self.size, self.matrices = size, strain_matrices(size, mean)
        columns, rows = round(WIDTH / size), round(DEPTH / size)
        i, j = (index.ravel() for index in np.meshgrid(np.arange(columns), np.arange(rows), indexing="ij"))
        nodes = np.stack([(i + a) * (rows + 1) + j + b for a, b in ((0, 0), (1, 0), (1, 1), (0, 1))], axis=1)
        self.unknowns = (2 * nodes[:, :, None] + [0, 1]).reshape(len(nodes), 8)
        self.count = 2 * (columns + 1) * (rows + 1)
        index = np.arange(self.count // 2)
        x, y = size * (index // (rows + 1)), size * (index % (rows + 1))
        self.footing = index[(y > DEPTH - 1e-9) & (x < HALF + 1e-9)]
        held = np.zeros((self.count // 2, 2), dtype=bool)
        held[(x < 1e-9) | (x > WIDTH - 1e-9), 0] = True
        held[y < 1e-9] = held[self.footing] = True
        self.free = np.flatnonzero(~held.ravel())

    def assemble(self, displacement, plastic):
        """Internal forces, stiffness, plastic strains."""
        strain = np.einsum("qai,ei->eqa", self.matrices, displacement[self.unknowns])
        value, tangent, plastic = stress(strain, plastic)
        area = self.size**2 / 4.0
        force = np.bincount(self.unknowns.ravel(), area * np.einsum("qai,eqa->ei", self.matrices, value).ravel(),
                            self.count)
        entries = np.einsum("qai,eqab,qbj->eij", self.matrices, tangent, self.matrices, optimize=True)
        place = np.repeat(self.unknowns, 8, axis=1).ravel(), np.tile(self.unknowns, (1, 8)).ravel()
        return force, sparse.csc_matrix((area * entries.ravel(), place), shape=(self.count, self.count)), plastic


def push(size, mean=True):
    """Force on the half footing over its strength, in m, after each of the steps."""
    ground = Ground(size, mean)
    displacement, plastic, curve = np.zeros(ground.count), np.zeros((len(ground.unknowns), 4, 4)), []
    for _ in range(STEPS):
        change = np.zeros(ground.count)
        change[2 * ground.footing + 1] = -SETTLEMENT / STEPS
        for iteration in range(30):
            force, matrix, flow = ground.assemble(displacement, plastic)
            residual = force + matrix @ change
            if iteration and np.linalg.norm(residual[ground.free]) < 1e-8 * np.linalg.norm(force):
                break
            displacement += change
            displacement[ground.free] -= splu(matrix[ground.free][:, ground.free]).solve(residual[ground.free])
            change[:] = 0.0
        else:
            raise RuntimeError("Newton's method does not converge")
        plastic = flow
        curve.append(-force[2 * ground.footing + 1].sum() / STRENGTH)
    return np.array(curve)


if __name__ == "__main__":
    print("h,settlement,factor")
    for h in (0.25, 0.125, 0.0625):
        factors = push(h) / (HALF + 0.5 * h)
        for step in (6, 10, 14, 20, 30, 50):
            print(f"{h:g},{SETTLEMENT * step / STEPS:g},{factors[step - 1]:.4f}", flush=True)
