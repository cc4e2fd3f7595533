#!/usr/bin/env python3
"""Axial symmetry against a quarter in 3D of the same cells: two layers under a circular load, axis along z and along y. Quick."""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import Test, difference  # noqa: E402

SCENE = """
mpm:
  dim: %d
  grid: {lower: "%s", upper: "%s", cells: "%s"}
  shape: gimp
  materials: soft,stiff
  material_soft: {type: neo_hookean, E: 1e6, nu: 0.3, density: 1800}
  material_stiff: {type: neo_hookean, E: 5e6, nu: 0.2, density: 2200}
  bodies: low,high
  body_low: {%s, material: stiff}
  body_high: {%s, material: soft}
  bcs: base,%s
%s
  loads: weight
  load_weight: {type: gravity, value: "%s", ramp: "0:0,1:1"}
  surfaces: load
  surface_load: {body: high, side: "+%s", normal: -2e5, %s}
  time: {end: 1, step: 0.25}
  output: {prefix: block, every: 1000}
"""


def vector(along, axis, *across):
    """Text of a vector with a component along the axis and others across it."""
    values = list(across)
    values.insert("xyz".index(axis), along)
    return ",".join(f"{value:g}" for value in values)


def layers(test):
    """The scene with axial symmetry."""
    box = 'region: box, lower: "%s", upper: "%s", points_per_cell: "2,2"'
    path = test.folder() / "case.yaml"
    path.write_text(SCENE % (
        2, "0,0", "2.5,2", "10,8", box % ("0,0", "2,0.75"), box % ("0,0.75", "2,1.5"), "side",
        '  bc_base: {region: box, lower: "0,0", upper: "3,0", components: "x,y"}\\n'.replace("\\n", "\n") +
        '  bc_side: {region: box, lower: "0,0", upper: "0,3", components: "x"}',
        "0,-10", "y", 'region: box, lower: "0,1", upper: "1,2"'))
    return test.run(path, mpm_kinematics="axisymmetric")


def quarter(test, axis):
    """The scene in 3D: a quarter of the cylinder about an axis."""
    cylinder = 'region: cylinder, point: "%s", axis: "%s", radius: %g, length: %g, clip_lower: "0,0,0"'
    up = vector(1, axis, 0, 0)

    def part(low, high, radius=2.0):
        return cylinder % (vector(low, axis, 0, 0), up, radius, high - low)

    planes = []
    for name in "xyz":
        place = [3.0, 3.0, 3.0]
        place["xyz".index(name)] = 0.0
        text = ",".join(f"{value:g}" for value in place)
        components = "x,y,z" if name == axis else name
        planes.append(f'  bc_{"base" if name == axis else name}: {{region: box, lower: "0,0,0", upper: "{text}", components: "{components}"}}')
    path = test.folder() / "case.yaml"
    path.write_text(SCENE % (
        3, "0,0,0", vector(2, axis, 2.5, 2.5), vector(8, axis, 10, 10), part(0, 0.75), part(0.75, 1.5),
        ",".join(name for name in "xyz" if name != axis), "\n".join(planes), vector(-10, axis, 0, 0), axis, part(1, 2, 1.0)))
    return test.run(path)


def meridian(run, axis):
    """Place and displacement of the points in 3D, along the radius and the axis."""
    state = run.results.state("last")
    up = "xyz".index(axis)
    across = [a for a in range(3) if a != up]
    moved, place = state["displacement"], state["position"] - state["displacement"]
    radius = np.hypot(*place[:, across].T)
    return radius, place[:, up], np.sum(moved[:, across] * place[:, across], axis=1) / radius, moved[:, up]


def interpolated(run, radius, height):
    """Displacement of the run with axial symmetry at places at heights of its points."""
    state = run.results.state("last")
    moved = state["displacement"]
    r, y = (state["position"] - moved).T
    result = np.empty((2, len(radius)))
    for level in np.unique(np.round(height, 9)):
        row = np.flatnonzero(np.abs(y - level) < 1e-6)
        row = row[np.argsort(r[row])]
        here = np.abs(height - level) < 1e-6
        for a in range(2):
            result[a, here] = np.interp(radius[here], r[row], moved[row, a])
    return result


with Test() as test:
    flat = layers(test)
    solids = {axis: quarter(test, axis) for axis in "zy"}
    for axis, solid in solids.items():
        radius, height, across, along = meridian(solid, axis)
        exact = interpolated(flat, radius, height)
        error = np.sqrt(np.mean((np.stack([across, along]) - exact) ** 2, axis=1)) / np.abs(exact[1]).max()
        test.check(f"{axis}.across", error[0], None, 2e-3)  # a third of it with cells half as large
        test.check(f"{axis}.along", error[1], None, 5e-3)
        force = 4 * solid.results.column(f"reaction_base_{axis}")[-1]
        test.near(f"{axis}.force", force, flat.results.column("reaction_base_y")[-1], relative=0.01)
    forces = [solids[axis].results.column(f"reaction_base_{axis}") for axis in "zy"]
    test.check("turned", difference(*forces), None, 1e-9)
