#!/usr/bin/env python3
"""Finite elements for the plate with a slot: reference.py CELLS FILE.csv.

Bilinear elements at finite strain, 2 x 2 Gauss points, on the mesh of the scene's cells without those of the slot.
Energies of physics/damage.c: neo-Hookean solid, AT2, volumetric split. Displacement and damage are minimised in turn,
until neither changes; damage of a node does not fall, which its equation gets as bounds (primal-dual active set).
Bourdin, Francfort and Marigo (2000), doi:10.1016/S0022-5096(99)00028-9; Hintermueller, Ito and Kunisch (2002),
doi:10.1137/S1052623401383558. Writes displacement of the ends, force, elastic energy and energy of fracture.
"""
import sys

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import splu

E, NU, G_C, LENGTH, RESIDUAL = 210e3, 0.3, 2.7, 1.0 / 16.0, 1e-3
MU, BULK = E / (2.0 * (1.0 + NU)), E / (3.0 * (1.0 - 2.0 * NU))
END, STEPS = 6e-3, 60
TOLERANCE, MOST = 1e-5, 2000


class Mesh:
    """Square cells of the unit plate; 2 x 2 Gauss points."""

    def __init__(self, cells):
        self.n, self.h = cells + 1, 1.0 / cells
        j, i = np.divmod(np.arange(cells * cells), cells)
        middle = (np.stack([i, j], 1) + 0.5) * self.h
        solid = ~((middle[:, 0] < 0.5) & (abs(middle[:, 1] - 0.5) < 1.0 / 64.0))
        first = (j * self.n + i)[solid]
        self.nodes = np.stack([first, first + 1, first + self.n, first + self.n + 1], 1)
        gauss = np.array([-1.0, 1.0]) / np.sqrt(3.0)
        self.shape, self.slope = [], []
        for b in gauss:
            for a in gauss:
                x, y = np.array([1.0 - a, 1.0 + a]) / 2.0, np.array([1.0 - b, 1.0 + b]) / 2.0
                ends = np.array([-1.0, 1.0]) / self.h
                self.shape.append(np.outer(y, x).ravel())
                self.slope.append(np.stack([np.outer(y, ends).ravel(), np.outer(ends, x).ravel()], 1))
        self.shape, self.slope, self.weight = np.array(self.shape), np.array(self.slope), self.h**2 / 4.0
        self.used = np.unique(self.nodes)
        place = np.arange(self.n * self.n) // self.n
        self.low, self.high = self.used[place[self.used] == 0], self.used[place[self.used] == cells]
        dofs = (2 * self.nodes[:, :, None] + np.arange(2)).reshape(len(self.nodes), 8)
        self.dofs = dofs
        self.rows_u, self.columns_u = np.repeat(dofs, 8, 1).ravel(), np.tile(dofs, 8).ravel()
        self.rows_d, self.columns_d = np.repeat(self.nodes, 4, 1).ravel(), np.tile(self.nodes, 4).ravel()


def material(F, tangent=True):
    """psi+, psi-, and P and dP/dF of both, of F at all points, (..., 2, 2)."""
    J = F[..., 0, 0] * F[..., 1, 1] - F[..., 0, 1] * F[..., 1, 0]
    G = np.stack([np.stack([F[..., 1, 1], -F[..., 1, 0]], -1), np.stack([-F[..., 0, 1], F[..., 0, 0]], -1)], -2) / J[..., None, None]
    first, m = (F**2).sum((-2, -1)) + 1.0, MU * J ** (-2.0 / 3.0)
    shape, volume = 0.5 * (m * first - 3.0 * MU), 0.25 * BULK * (J**2 - 1.0 - 2.0 * np.log(J))
    P_shape = m[..., None, None] * (F - first[..., None, None] / 3.0 * G)
    P_volume = (0.5 * BULK * (J**2 - 1.0))[..., None, None] * G
    shrinks = J < 1.0
    plus, minus = shape + np.where(shrinks, 0.0, volume), np.where(shrinks, volume, 0.0)
    keep = np.where(shrinks, 0.0, 1.0)
    P = P_shape + keep[..., None, None] * P_volume, (1.0 - keep)[..., None, None] * P_volume
    if not tangent:
        return plus, minus, P, None
    GG, FG = np.einsum("...ij,...kl->...ijkl", G, G), np.einsum("...ij,...kl->...ijkl", F, G)
    turn = np.einsum("...il,...kj->...ijkl", G, G)
    one = np.einsum("ik,jl->ijkl", np.eye(2), np.eye(2))
    e = np.s_[..., None, None, None, None]
    A_shape = m[e] * (one - 2.0 / 3.0 * (FG + np.einsum("...ijkl->...klij", FG)) + (2.0 / 9.0 * first)[e] * GG + (first / 3.0)[e] * turn)
    A_volume = BULK * ((J**2)[e] * GG - (0.5 * (J**2 - 1.0))[e] * turn)
    return plus, minus, P, (A_shape + keep[e] * A_volume, (1.0 - keep)[e] * A_volume)


class Plate:
    def __init__(self, cells):
        self.mesh = mesh = Mesh(cells)
        self.u, self.d = np.zeros(2 * mesh.n**2), np.zeros(mesh.n**2)
        inside = np.setdiff1d(mesh.used, np.concatenate([mesh.low, mesh.high]))
        self.free = np.sort(np.concatenate([2 * inside, 2 * inside + 1]))
        mass = mesh.weight * np.einsum("qi,qj->ij", mesh.shape, mesh.shape)
        stiff = mesh.weight * np.einsum("qia,qja->ij", mesh.slope, mesh.slope)
        self.fracture = self._sum(np.tile(G_C * (mass / LENGTH + LENGTH * stiff), (len(mesh.nodes), 1, 1)))

    def _sum(self, blocks):
        mesh = self.mesh
        return sparse.csr_matrix((blocks.ravel(), (mesh.rows_d, mesh.columns_d)), shape=(mesh.n**2,) * 2)

    def _points(self):
        mesh = self.mesh
        u = self.u[mesh.dofs].reshape(-1, 4, 2)
        F = np.eye(2) + np.einsum("eia,qib->eqab", u, mesh.slope)
        return F, (1.0 - RESIDUAL) * (1.0 - np.einsum("ei,qi->eq", self.d[mesh.nodes], mesh.shape)) ** 2 + RESIDUAL

    def forces(self, tangent=True):
        """Internal forces, their derivative, and psi+ at the points."""
        mesh = self.mesh
        F, g = self._points()
        plus, minus, P, A = material(F, tangent)
        stress = g[..., None, None] * P[0] + P[1]
        f = np.bincount(mesh.dofs.ravel(), (mesh.weight * np.einsum("eqab,qib->eia", stress, mesh.slope)).ravel(), len(self.u))
        energy = mesh.weight * (g * plus + minus).sum()
        if not tangent:
            return f, None, plus, energy
        D = g[..., None, None, None, None] * A[0] + A[1]
        half = np.einsum("eqabcd,qjd->eqabjc", D, mesh.slope)
        K = mesh.weight * np.einsum("eqabjc,qib->eiajc", half, mesh.slope)
        return f, sparse.csr_matrix((K.ravel(), (mesh.rows_u, mesh.columns_u)), shape=(len(self.u),) * 2), plus, energy

    def solve_u(self):
        for _ in range(30):
            f, K, plus, _ = self.forces()
            size = np.linalg.norm(f)
            if np.linalg.norm(f[self.free]) <= 1e-9 * size:
                return plus
            self.u[self.free] -= splu(K[self.free][:, self.free].tocsc()).solve(f[self.free])
        raise RuntimeError("displacement does not converge")

    def solve_d(self, plus, least):
        """Bounds least <= d, by the active set."""
        mesh = self.mesh
        drive = 2.0 * (1.0 - RESIDUAL) * mesh.weight * plus
        A = self.fracture + self._sum(np.einsum("eq,qi,qj->eij", drive, mesh.shape, mesh.shape))
        b = np.bincount(mesh.nodes.ravel(), np.einsum("eq,qi->ei", drive, mesh.shape).ravel(), mesh.n**2)
        held = self.d <= least
        for _ in range(100):
            free = mesh.used[~held[mesh.used]]
            d = least.copy()
            if len(free):
                d[free] = splu(A[free][:, free].tocsc()).solve(b[free] - (A[free] @ np.where(held, least, 0.0)))
            pull = A @ d - b
            new = np.where(held, pull > 0.0, d < least)
            if (new == held)[mesh.used].all():
                return d
            held = new
        raise RuntimeError("active set does not settle")

    def step(self, end):
        mesh, least = self.mesh, self.d.copy()
        self.u[2 * mesh.high + 1], self.u[2 * mesh.low + 1] = 0.5 * end, -0.5 * end
        for count in range(MOST):
            d = self.solve_d(self.solve_u(), least)
            change, self.d = abs(d - self.d).max(), d
            if change < TOLERANCE:
                break
        self.solve_u()
        f, _, _, elastic = self.forces(False)
        return f[2 * mesh.high + 1].sum(), elastic, 0.5 * self.d @ (self.fracture @ self.d), count + 1


if __name__ == "__main__":
    plate = Plate(int(sys.argv[1]))
    with open(sys.argv[2], "w") as out:
        print("displacement,force,elastic,fracture", file=out)
        for k in range(1, STEPS + 1):
            force, elastic, fracture, count = plate.step(END * k / STEPS)
            print(f"{END * k / STEPS:.6g},{force:.8g},{elastic:.8g},{fracture:.8g}", file=out, flush=True)
            print(k, force, elastic, fracture, count, plate.d.max(), flush=True)
            if k > 5 and force < 5.0:
                break
