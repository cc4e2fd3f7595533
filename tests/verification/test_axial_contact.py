#!/usr/bin/env python3
"""Axial symmetry, contact and loads: a plug that slides in a rigid and in an elastic ring, with Coulomb's friction; loads on the faces of
a cylinder; a rigid disc of unknown position; ranks. Quick.
"""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import Test, difference  # noqa: E402

STRESS, E, NU, FRICTION, HEIGHT = 1e5, 1e9, 0.25, 0.3, 0.5
PLUG = """
mpm:
  dim: 2
  kinematics: axisymmetric
  grid: {lower: "0,0", upper: "2.25,1", cells: "18,8"}
  shape: %s
  materials: steel
  material_steel: {type: linear_elastic, E: 1e9, nu: 0.25, density: 1000}
  bodies: plug%s
  body_plug: {region: box, lower: "0,0.25", upper: "1,0.75", points_per_cell: "2,2", material: steel, initial_stress: "-1e5"}
  motions: pull%s
  motion_pull: {body: plug, components: "y", value: "0.01", ramp: "0:0,0.1:0,1:1"}
%s
  time: {end: 1, step: 0.1}
  output: {prefix: plug, every: 50}
snes: {rtol: 1e-10}
"""
RIGID = """
  boundaries: wall
  boundary_wall: {type: plane, point: "1,0", normal: "-1,0", friction: 0.3, penalty: 1000}
"""
RING = """
  body_ring: {region: box, lower: "1,0.25", upper: "2,0.75", points_per_cell: "2,2", material: steel}
  motion_hold: {body: ring, components: "y"}
  contacts: fit
  contact_fit: {bodies: "plug,ring", friction: 0.3}
"""


def written(test, text):
    """The scene as a file."""
    scene = test.folder() / "case.yaml"
    scene.write_text(text)
    return scene


def plug(test):
    """A compressed plug in a rigid ring: friction by its pressure, on one rank and three."""
    exact = 2 * np.pi * HEIGHT * STRESS
    for shape in ("gimp", "gimp_bspline2"):
        for ranks in (1, 3):
            results = test.run(written(test, PLUG % (shape, "", "", RIGID)), ranks=ranks).results
            along, across = (np.abs(results.column(f"reaction_wall_{axis}"))[1:] for axis in "yx")
            test.check(f"plug.{shape}_on_{ranks}.friction", np.abs(along / exact / FRICTION - 1).max(), None, 1e-3)
            test.check(f"plug.{shape}_on_{ranks}.ratio", np.abs(along / across / FRICTION - 1).max(), None, 1e-9)


def drag(test):
    """A plug that a motion drags far along the rough wall, under a constant force: no slide of the ground, though it moves without load."""
    far = {"mpm_motion_pull_value": "-2", "mpm_grid_lower": "0,-2", "mpm_grid_cells": "18,24"}
    results = test.run(written(test, PLUG % ("gimp", "", "", RIGID)), **far).results
    along = results.column("reaction_wall_y")[1:]
    test.check("drag.friction", np.abs(along / (2 * np.pi * HEIGHT * STRESS * FRICTION) - 1).max(), None, 1e-3)
    test.check("drag.steps", results.column("step").size, 10, 10)


def shrink(test):
    """A compressed plug that slides in an elastic ring: pressure of Lame's ring on a solid cylinder."""
    soft = (1 + NU) / E
    plug, ring = soft * (1 - 2 * NU), soft / (4 - 1) * ((1 - 2 * NU) + 4)
    exact = 2 * np.pi * HEIGHT * STRESS * plug / (plug + ring) * FRICTION
    for ranks in (1, 3):
        results = test.run(written(test, PLUG % ("gimp", ",ring", ",hold", RING)), ranks=ranks).results
        force = np.abs(results.column("force_fit_y"))[1:]
        test.check(f"shrink.on_{ranks}", np.abs(force / exact - 1).max(), None, 8e-3)
        test.check(f"shrink.on_{ranks}.balance", difference(force, results.column("reaction_pull_y")[1:]), None, 1e-7)


COLUMN = """
mpm:
  dim: 2
  kinematics: axisymmetric
  grid: {lower: "0,0", upper: "1.5,1.5", cells: "12,12"}
  shape: gimp
  materials: steel
  material_steel: {type: linear_elastic, E: 1e9, nu: %g, density: 0}
  bodies: column
  body_column: {region: box, lower: "0,0", upper: "1,1", points_per_cell: "2,2", material: steel}
  bcs: base
  bc_base: {region: box, lower: "0,0", upper: "3,0", components: "y"}
%s
  time: {end: 1, step: 0.5}
  output: {prefix: column, every: 50}
"""
PRESSED = """
  loads: side,top
  load_side: {type: traction, region: box, lower: "1,0", upper: "1,1", face: "+x", value: "-1e5,0"}
  load_top: {type: traction, region: box, lower: "0,1", upper: "1,1", face: "+y", value: "0,-2e5"}
"""
POINT = """
  loads: side,point
  load_side: {type: traction, region: box, lower: "1,0", upper: "1,1", face: "+x", value: "0,-1e5"}
  load_point: {type: force, region: box, lower: "0.5,0.5", upper: "1,1", value: "0,-3e4"}
"""
DISC = """
  boundaries: disc
  boundary_disc: {type: box, lower: "-1,1", upper: "1.4,1.4", free: "y", load: "0,-1e5", penalty: 1e3}
"""


def loads(test):
    """Tractions on the faces of a cylinder make a uniform stress; shear and a force are those of a full turn."""
    stress = test.run(written(test, COLUMN % (NU, PRESSED))).table("stress")
    test.check("loads.stress", np.abs(stress[:, :4] / 1e5 - [-1, -2, -1, 0]).max(), None, 1e-3)
    cut = {"mpm_sections": "cut", "mpm_section_cut_point": "0,0.25", "mpm_section_cut_normal": "0,1"}
    results = test.run(written(test, COLUMN % (NU, POINT)), **cut).results
    test.near("loads.force", results.column("reaction_base_y")[-1], 2 * np.pi * 1e5 + 3e4, relative=1e-6)
    above = -(2 * np.pi * 1e5 * 0.75 + 3e4)
    test.near("loads.section", results.column("section_cut_n")[-1], above, relative=2e-4)  # 5e-5 m of the faces pass the cut


def disc(test):
    """A rigid disc on a column goes down by its load over E pi R^2."""
    results = test.run(written(test, COLUMN % (0.0, DISC))).results
    test.near("disc.reaction", abs(results.column("reaction_disc_y")[-1]), 1e5, relative=1e-6)
    test.near("disc.settlement", 1.2 - results.column("position_disc_y")[-1], 1e5 / (np.pi * 1e9), relative=1e-3)


PARTS = (plug, drag, shrink, loads, disc)
if __name__ == "__main__":
    with Test() as test:
        for part in PARTS:
            part(test)
