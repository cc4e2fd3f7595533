#!/usr/bin/env python3
"""Axial symmetry: a circular load on an elastic half-space, stress and settlement on its axis. Quick.

Stress on the axis: Timoshenko and Goodier (1970), Theory of elasticity, article 124. The settlement follows from its strain. At the
edges of the grid nodes move as under a point load (Boussinesq 1885), which is right to (a/D)^2.
"""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import Test  # noqa: E402

E, NU, PRESSURE, SIZE = 1e6, 0.3, 1.0, 7  # Pa, -, Pa, radii of the load to the grid's edges
SCENE = """
mpm:
  dim: 2
  kinematics: axisymmetric
  grid: {lower: "0,-%g", upper: "%g,0", cells: "%d,%d"}
  shape: gimp
  materials: ground
  material_ground: {type: linear_elastic, E: 1e6, nu: 0.3, density: 0}
  bodies: ground
  body_ground: {region: box, lower: "0,-%g", upper: "%g,0", points_per_cell: "2,2", material: ground}
  surfaces: load
  surface_load: {body: ground, side: "+y", normal: -1, region: box, lower: "0,-1", upper: "1,1"}
  bcs: %s
%s
  time: {end: 1, step: 1}
  output: {prefix: ground, every: 1000}
"""


def point_load(r, z):
    """Displacement along the radius and down, of a half-space under the load in one point."""
    distance = np.hypot(r, z)
    factor = PRESSURE * (1 + NU) / (2 * E * distance)
    return factor * r * (z / distance**2 - (1 - 2 * NU) / (distance + z)), factor * (2 * (1 - NU) + (z / distance) ** 2)


def scene(test, cells):
    """So many cells to the load's radius."""
    count, names, blocks = cells * SIZE, [], []
    for x, y in [(SIZE, -k / cells) for k in range(count)] + [(k / cells, -SIZE) for k in range(count + 1)]:
        across, down = point_load(x, -y)
        names.append(f"at_{len(names)}")
        value = f'"x,y", value: "{across:.15g},{-down:.15g}"' if x else f'"y", value: "{-down:.15g}"'
        blocks.append(f'  bc_{names[-1]}: {{region: box, lower: "{x},{y}", upper: "{x},{y}", components: {value}}}')
    path = test.folder() / "case.yaml"
    path.write_text(SCENE % (SIZE, SIZE, count, count, SIZE, SIZE, ",".join(names), "\n".join(blocks)))
    return path


def axis_stress(z):
    """Vertical and radial stress at a depth on the axis, over the pressure."""
    slope = z / np.hypot(1, z)
    return -(1 - slope**3), -0.5 * (1 + 2 * NU - 2 * (1 + NU) * slope + slope**3)


def settlement(z):
    """Settlement on the axis, by its strain from far below (there as under a point load)."""
    far = 1000.0
    depth = np.concatenate([[z], z + np.geomspace(1e-4, far, 4000)])
    down, across = axis_stress(depth)
    return np.trapz(-(down - 2 * NU * across) / E, depth) + point_load(0.0, depth[-1])[1]


def errors(test, cells):
    """Largest errors down to 4 radii: of the two stresses over the pressure, means of the cells at the axis, and of the settlement."""
    state = test.run(scene(test, cells)).results.state("last")
    r, z = state["position"][:, 0], -state["position"][:, 1]
    rows = [(r < 1 / cells) & (np.floor(z * cells) == k) for k in range(4 * cells)]
    stress = np.array([state["stress"][row][:, [1, 0, 2]].mean(axis=0) for row in rows])
    down, across = axis_stress(np.array([z[row].mean() for row in rows]))
    test.check(f"hoop_{cells}", np.abs(stress[:, 1] - stress[:, 2]).max(), None, 1e-9)
    near = (r < 0.5 / cells) & (z < 4)
    moved = np.array([-u / settlement(y) for u, y in zip(state["displacement"][near, 1], z[near])])
    return [np.abs(stress[:, 0] - down).max(), np.abs(stress[:, 1] - across).max(), np.abs(moved - 1).max()]


with Test() as test:
    test.near("formulas", settlement(0.0), 2 * (1 - NU**2) / E, relative=1e-5)
    coarse, fine = errors(test, 3), errors(test, 6)
    for name, value, order, least in zip(("vertical", "radial", "settlement"), fine, np.log2(np.divide(coarse, fine)), (1.7, 1.0, 0.6)):
        test.check(name, value, None, 0.01)
        test.check(f"{name}_order", order, least)
