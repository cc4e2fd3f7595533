#!/usr/bin/env python3
"""A circular footing on Tresca clay, rough and smooth: 6.05 and 5.69 times the shear strength.

Shield (1955), On the plastic flow of metals under conditions of axial symmetry, smooth; Eason and Shield (1960), The plastic indentation
of a semi-infinite solid by a perfectly rough circular punch. Nodes of the grid carry the footing. Beyond the last of them linear
functions fall to zero over a cell: the footing acts as one that is wider by 0.3 cells. With splines of degree 2 the last node's
neighbour already moves the edge, and the radius is the footing's. A rigid box whose edge lies inside a cell keeps its load as it
is pushed down: contact at the edge neither comes nor goes by halves of a cell.
"""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import Test  # noqa: E402

COHESION, WIDER = 1e3, 0.3  # Pa; of a cell, by linear functions
SCENE = """
mpm:
  dim: 2
  kinematics: axisymmetric
  grid: {lower: "0,-1.5", upper: "2.5,0.25", cells: "%d,%d"}
  shape: %s
  materials: clay
  material_clay: {type: mohr_coulomb, E: 1e7, nu: 0.49, density: 0, cohesion: 1e3, friction: 0, dilation: 0}
  bodies: ground
  body_ground: {region: box, lower: "0,-1.5", upper: "2.5,0", points_per_cell: "2,2", material: clay}
  bcs: side,base,footing
  bc_side: {region: box, lower: "2.5,-3", upper: "2.5,1", components: "x"}
  bc_base: {region: box, lower: "0,-1.5", upper: "5,-1.5", components: "x,y"}
  bc_footing: {region: box, lower: "0,0", upper: "1,1", %s, ramp: "0:0,1:1"}
  time: {end: 1, step: 0.05}
  output: {prefix: footing, every: 1000}
"""
BOX = """
  boundaries: footing
  boundary_footing: {type: box, lower: "-1,0", upper: "%g,0.2", motion: "0,-0.03", friction: %s}
"""
FACES = {"smooth": ('components: "y", value: "-0.006"', 5.69), "rough": ('components: "x,y", value: "0,-0.006"', 6.05)}


def factor(test, cells, shape, face):
    """Mean pressure over the strength at the end; the load no longer grows there."""
    scene = test.folder() / "case.yaml"
    scene.write_text(SCENE % (round(2.5 * cells), round(1.75 * cells), shape, FACES[face][0]))
    force = -test.run(scene).results.column("reaction_footing_y")
    radius = 1.0 + (WIDER / cells if shape == "gimp" else 0.0)
    test.check(f"{face}.{shape}_{cells}.plateau", force[-1] / force[len(force) // 2], 0.98, 1.01)
    return force[-1] / (np.pi * radius**2 * COHESION)


def edge(test, cells, face, part):
    """A box with its edge so many cells before a grid line: the largest change of its load in a step of the last three quarters."""
    text = SCENE.replace("bcs: side,base,footing", "bcs: side,base") % (round(2.5 * cells), round(1.75 * cells), "gimp", "")
    lines = [line for line in text.splitlines() if "bc_footing" not in line]
    scene = test.folder() / "case.yaml"
    scene.write_text("\n".join(lines) + BOX % (1.0 - part / cells, {"smooth": "frictionless", "rough": "stick"}[face]))
    force = test.run(scene).results.column("reaction_footing_y")[5:]
    return np.max(np.abs(np.diff(force) / force[:-1]))


with Test() as test:
    test.check("edge.rough", edge(test, 8, "rough", 0.5), None, 0.02)
    test.check("edge.smooth", edge(test, 8, "smooth", 0.75), None, 0.1)
    for face, (_, exact) in FACES.items():
        test.near(f"{face}.gimp_8", factor(test, 8, "gimp", face), exact, relative=0.02)
        test.near(f"{face}.gimp_bspline2_8", factor(test, 8, "gimp_bspline2", face), exact, relative=0.035)
    test.near("rough.gimp_bspline2_16", factor(test, 16, "gimp_bspline2", "rough"), FACES["rough"][1], relative=0.02)
