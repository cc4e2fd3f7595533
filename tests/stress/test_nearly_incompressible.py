#!/usr/bin/env python3
"""nu = 0.4999 (bulk over shear modulus: 5000): a block that sags on a smooth base, and a confined column.

The block keeps its volume to a few times p/K and its base carries its weight. In the column, whose sides cannot move,
strains are of the order of p/M and the stress is the weight above, M = E (1 - nu)/((1 + nu) (1 - 2 nu)).

With --full: nu = 0.49999, the block on more ranks and in 3D at twice the resolution.
"""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent))
from hostile import Hostile  # noqa: E402
from talus_test import FULL, example  # noqa: E402

LIMIT = 90.0  # s, for one run
E, DENSITY, GRAVITY, SIZE = 1e6, 1000.0, 10.0, 4.0  # Pa, kg/m3, m/s2, m
FBAR = {"mpm_stabilization_fbar": "true"}

PLANE = """
mpm:
  dim: 2
  grid: {lower: "0,0", upper: "8,6", cells: "16,12"}
  materials: gel
  material_gel: {type: hencky, E: 1e6, nu: 0.4999, density: 1000}
  bodies: block
  body_block: {region: box, lower: "0,0", upper: "4,4", points_per_cell: "2,2", material: gel}
  bcs: symmetry,base
  bc_symmetry: {region: box, lower: "0,0", upper: "0,8", components: "x"}
  bc_base: {region: box, lower: "0,0", upper: "8,0", components: "y"}
  loads: weight
  load_weight: {type: gravity, value: "0,-10"}
  time: {end: 1, step: 0.1}
  tracks: top
  track_top: {at: "0,4", nearest: 1}
  quiet: true
  output: {prefix: run, every: 5}
"""

SOLID = """
mpm:
  dim: 3
  grid: {lower: "0,0,0", upper: "3,3,3", cells: "6,6,6"}
  materials: gel
  material_gel: {type: hencky, E: 1e6, nu: 0.4999, density: 1000}
  bodies: block
  body_block: {region: box, lower: "0,0,0", upper: "2,2,2", points_per_cell: "2,2,2", material: gel}
  bcs: left,front,base
  bc_left: {region: box, lower: "0,0,0", upper: "0,3,3", components: "x"}
  bc_front: {region: box, lower: "0,0,0", upper: "3,0,3", components: "y"}
  bc_base: {region: box, lower: "0,0,0", upper: "3,3,0", components: "z"}
  loads: weight
  load_weight: {type: gravity, value: "0,0,-10"}
  time: {end: 1, step: 0.5}
  tracks: top
  track_top: {at: "0,0,2", nearest: 1}
  quiet: true
  output: {prefix: run, every: 1}
"""


def bulk(nu):
    return E / (3.0 * (1.0 - 2.0 * nu))


def constrained(nu):
    return E * (1.0 - nu) / ((1.0 + nu) * (1.0 - 2.0 * nu))


def block(test, label, scene, nu, size, dim, **options):
    """The weight is carried, and the volume changes no more than the mean pressure explains."""
    run = test.ends(label, scene, mpm_material_gel_nu=nu, **options)
    if not run.completed:
        return
    axis = "xyz"[dim - 1]
    weight = DENSITY * GRAVITY * size**dim
    test.near(f"{label}.base_reaction", run.last(f"reaction_base_{axis}"), weight, relative=1e-5)
    first, last = run.results.initial["volume"].sum(), run.results.state("last")["volume"].sum()
    largest = DENSITY * GRAVITY * size / bulk(nu)
    test.check(f"{label}.volume_change_over_p_over_k", (1.0 - last / first) / largest, 0, 2)
    # uniaxial estimate: weight over twice the height, plane strain; corners and locking take part of it
    free = DENSITY * GRAVITY * size**2 / (2.0 * E)
    test.check(f"{label}.settlement_over_uniaxial", -run.last(f"track_top_u{axis}") / free, 0.1, 1.5)


def column(test, label, nu, **options):
    """Every node held sideways: sigma_yy = -rho g (H - y), settlement rho g H^2/(2 M)."""
    run = test.ends(label, PLANE, mpm_material_gel_nu=nu, mpm_bc_symmetry_upper="8,8", **options)
    if not run.completed:
        return
    state = run.results.state("last")
    depth = SIZE - run.results.initial["position0"][:, 1]
    scale = DENSITY * GRAVITY * SIZE
    # points of one cell share the mean of their weight: a quarter of a cell off
    off = np.max(np.abs(state["stress"][:, 1] + DENSITY * GRAVITY * depth)) / scale
    test.check(f"{label}.stress_error", off, None, 0.125 / SIZE * 1.01)
    settled = DENSITY * GRAVITY * SIZE**2 / (2.0 * constrained(nu))
    test.near(f"{label}.settlement", -run.last("track_top_uy"), settled, relative=0.01)


with Hostile(LIMIT) as test:
    fbar = test.takes(example("bar_elastic"), **FBAR)
    for nu in (0.4999, 0.49999) if FULL else (0.4999,):
        for law in ("hencky", "neo_hookean"):
            block(test, f"{law}.{nu}.block", PLANE, nu, SIZE, 2, mpm_material_gel_type=law)
            column(test, f"{law}.{nu}.column", nu, mpm_material_gel_type=law)
            block(test, f"{law}.{nu}.block_3d", SOLID, nu, 2.0, 3, mpm_material_gel_type=law)
        if fbar:
            for law in ("hencky", "neo_hookean"):
                block(test, f"{law}.{nu}.block_fbar", PLANE, nu, SIZE, 2, mpm_material_gel_type=law, **FBAR)
                block(test, f"{law}.{nu}.block_3d_fbar", SOLID, nu, 2.0, 3, mpm_material_gel_type=law, **FBAR)
            column(test, f"{nu}.column_fbar", nu, **FBAR)
            block(test, f"{nu}.block_fbar_on_2_ranks", PLANE, nu, SIZE, 2, ranks=2, **FBAR)
        block(test, f"{nu}.block_on_2_ranks", PLANE, nu, SIZE, 2, ranks=2)
        block(test, f"{nu}.block_linear", PLANE, nu, SIZE, 2, mpm_shape="linear")
        block(test, f"{nu}.block_amg", PLANE, nu, SIZE, 2, mpm_solver="amg")
        block(test, f"{nu}.block_boomeramg", PLANE, nu, SIZE, 2, mpm_solver="boomeramg")
    if FULL:
        block(test, "4_ranks", PLANE, 0.4999, SIZE, 2, ranks=4)
        block(test, "fine_3d", SOLID, 0.4999, 2.0, 3, mpm_grid_refine=2, ranks=2)
