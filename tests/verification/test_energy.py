#!/usr/bin/env python3
"""The account of energy: kinetic, elastic, dissipated and external energy of moving bodies, and what is missing.

A bar falls into its support and swings: what is missing falls with the step, by the order of the method, and elastic steps dissipate
nothing. A base that shakes does its work, a block that slides loses what friction takes, a plastic bar that strikes a wall what flow
takes, on any number of ranks, implicit and explicit; a restart goes on with the account. Scenes without inertia have no such columns.
"""
import sys
from pathlib import Path

import numpy as np

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))
from talus_test import Test, difference  # noqa: E402

BAR = """
mpm:
  dim: 2
  grid: {lower: "0,0", upper: "1.5,0.0625", cells: "24,1"}
  shape: gimp
  materials: steel
  material_steel: {type: %s, density: 1000, %s}
  bodies: bar
  body_bar: {region: box, lower: "0,0", upper: "1,0.0625", points_per_cell: "2,2", material: steel}
  bcs: root,roll
  bc_root: {region: box, lower: "0,0", upper: "0,0.0625", components: "x"}
  bc_roll: {region: box, lower: "0,0", upper: "1.5,0.0625", components: "y"}
  loads: pull
  load_pull: {type: gravity, value: "%s,0", ramp: "0:1"}
  tracks: tip
  track_tip: {at: "1,0.03", nearest: 2}
  stabilization: {ghost: "off", fbar: false}
  time: {integrator: newmark, end: 0.12, step: 0.0024, transfer: flip}
  output: {prefix: bar, every: 0}
"""
BLOCK = """
mpm:
  dim: 2
  grid: {lower: "0,0", upper: "8,2", cells: "32,8"}
  shape: gimp
  materials: block
  material_block: {type: hencky, E: 50e6, nu: 0, density: 2000}
  bodies: block
  body_block: {region: box, lower: "1,0.5", upper: "3,1.5", points_per_cell: "2,2", material: block, velocity: "3,0"}
  boundaries: floor
  boundary_floor: {type: plane, point: "0,0.5", normal: "0,1", friction: 0.3, penalty: 20%s}
  loads: weight
  load_weight: {type: gravity, value: "0,-10", ramp: "0:1"}
  tracks: block
  track_block: {region: box, lower: "1,0.5", upper: "3,1.5"}
  time: {integrator: generalized_alpha, rho_inf: 0.5, end: 0.4, step: 0.01}
  output: {prefix: block, every: 0}
"""
IMPACT = """
mpm:
  dim: 2
  grid: {lower: "0,0", upper: "1.5,0.5", cells: "24,8"}
  shape: gimp
  materials: steel
  material_steel: {type: j2, E: 1e6, nu: 0.3, density: 1000, yield_stress: 4e3, hardening: 1e4}
  bodies: bar
  body_bar: {region: box, lower: "0.125,0", upper: "1.125,0.25", points_per_cell: "2,2", material: steel, velocity: "-0.5,0"}
  boundaries: wall
  boundary_wall: {type: plane, point: "0.0625,0", normal: "1,0", penalty: 10}
  bcs: roll
  bc_roll: {region: box, lower: "0,0", upper: "1.5,0", components: "y"}
  time: {integrator: newmark, end: 0.3, step: 0.002}
  output: {prefix: impact, every: 0}
"""
PUSHED = """
mpm:
  dim: 2
  grid: {lower: "0,0", upper: "6,2", cells: "12,4"}
  materials: m
  material_m: {type: linear_elastic, E: 1e5, nu: 0, density: 1000}
  bodies: bar
  body_bar: {region: box, lower: "0,0", upper: "4,1", points_per_cell: "2,2", material: m}
  bcs: wall
  bc_wall: {region: box, lower: "0,0", upper: "0,1", components: "x,y"}
  surfaces: end
  surface_end: {body: bar, side: "+x", traction: "100,0", ramp: "0:0,0.2:1"}
  time: {transfer: flip, end: 0.2, step: 0.02}
  output: {prefix: pushed, every: 0}
"""
NAMES = ("kinetic", "elastic", "dissipated", "external", "balance")
ELASTIC = {  # law, further parameters, pull, m/s2: strains up to 0.1
    "linear_elastic": ("E: 1e6, nu: 0", 3), "hencky": ("E: 1e6, nu: 0.3", 60), "neo_hookean": ("E: 1e6, nu: 0.3, volumetric: quadratic", 60),
    "ogden": ('terms: "-2:-0.5e5,2:3e5", nu: 0.3', 60)}


def write(test, text):
    path = test.folder() / "scene.yaml"
    path.write_text(text, encoding="utf-8")
    return path


def account(run):
    return {name: run.results.column(f"energy_{name}") for name in NAMES}


def missing(run):
    energy = account(run)
    return np.max(np.abs(energy["balance"])) / max(np.max(energy["kinetic"]), np.max(energy["elastic"]))


def check_order(test):
    """The missing part falls with the step; FLIP and trapezoidal steps lose least."""
    scene = write(test, BAR % ("hencky", "E: 1e6, nu: 0", 3))
    for name, bounds, options in (("newmark", (4e-3, 1e-3), {}), ("backward_euler", (0.4, 0.12), {}),
                                  ("generalized_alpha", (2e-3, 1e-3), {"mpm_time_rho_inf": 1})):
        lost = [missing(test.run(scene, mpm_quiet=None, mpm_time_integrator=name, mpm_time_step=step, **options))
                for step in (0.0048, 0.0012)]
        for value, bound, step in zip(lost, bounds, ("4.8e-3", "1.2e-3")):
            test.check(f"missing.{name}.{step}", value, None, bound)
        test.check(f"missing_falls.{name}", lost[1] / lost[0], None, 0.75)
    for transfer in ("apic", "flip"):
        run = test.run(scene, mpm_quiet=None, mpm_time_integrator="explicit", mpm_time_step=6e-4, mpm_time_transfer=transfer)
        test.check(f"missing.explicit.{transfer}", missing(run), None, 0.02)


def check_elastic(test):
    """Elastic laws store all of their stresses' work; the tip's velocity is the derivative of its way."""
    for law, (parameters, pull) in ELASTIC.items():
        run = test.run(write(test, BAR % (law, parameters, pull)), mpm_quiet=None, mpm_time_step=0.0012)
        energy = account(run)
        test.check(f"dissipated.{law}", np.max(np.abs(energy["dissipated"])) / np.max(energy["elastic"]), None, 2e-4)
        test.check(f"missing.{law}", missing(run), None, 0.02)
    time, way, velocity = (run.results.column(name) for name in ("time", "track_tip_ux", "track_tip_vx"))
    rate = np.gradient(way, time)
    test.check("track_velocity", np.max(np.abs(rate - velocity)[2:-2]) / np.max(np.abs(velocity)), None, 0.05)
    mass = 1000 * 0.0625
    test.check("momentum", np.max(np.abs(run.results.column("momentum_x"))) / (mass * np.max(np.abs(velocity))), 0.4, 0.8)


def check_base(test):
    """The base that shakes a bar does its work by the mean of its force."""
    scene = write(test, (BAR % ("hencky", "E: 1e6, nu: 0", 0)).replace(
        'bc_root: {', 'bc_root: {value: 5, quantity: acceleration, ramp: "0:0,0.03:1,0.06:0,0.09:-1,0.12:0", '))
    for name, bound, options in (("newmark", 8e-3, {}), ("generalized_alpha", 8e-3, {}), ("explicit", 0.02, {"mpm_time_step": 6e-4})):
        run = test.run(scene, mpm_quiet=None, mpm_time_integrator=name, **options)
        test.check(f"base.missing.{name}", missing(run), None, bound)
        test.check(f"base.work.{name}", np.max(account(run)["external"]), 0.1)


def check_friction(test):
    """Friction takes mu m g times the way; a floor that carries the block along works on it."""
    mass = 2 * 2000
    run = test.run(write(test, BLOCK % ""), mpm_quiet=None)
    energy, way = account(run), run.results.column("track_block_ux")[-1]
    test.near("friction.dissipated", energy["dissipated"][-1], 0.3 * 10 * mass * way, 0.03)
    test.check("friction.missing", missing(run), None, 8e-3)
    moving = (BLOCK % ', motion: "4,0", ramp: "0:0,1:1"').replace(', velocity: "3,0"', "")
    run = test.run(write(test, moving), mpm_quiet=None)
    energy, way = account(run), run.results.column("track_block_ux")[-1]
    test.near("carried.external", energy["external"][-1], 0.3 * 10 * mass * 4 * 0.4, 0.05)
    test.near("carried.dissipated", energy["dissipated"][-1], 0.3 * 10 * mass * (4 * 0.4 - way), 0.05)
    test.check("carried.missing", np.abs(energy["balance"][-1]) / energy["external"][-1], None, 0.01)


def check_contact(test):
    """In explicit steps contact does its work by the mean of the velocities before and after a kick."""
    run = test.run(HERE / "explicit_balls.yaml", mpm_time_transfer="flip")
    test.check("balls.missing", missing(run), None, 0.06)
    scene = write(test, (BLOCK % "").replace("generalized_alpha, rho_inf: 0.5", "explicit").replace(", step: 0.01", ""))
    run = test.run(scene, mpm_quiet=None)
    test.check("friction.explicit.missing", missing(run), None, 6e-3)


def check_impact(test):
    """Plastic flow in a bar that strikes a wall, on 1 to 3 ranks; nothing of it depends on them."""
    scene, first = write(test, IMPACT), None
    for ranks in (1, 2, 3):
        run = test.run(scene, ranks, mpm_quiet=None)
        energy = account(run)
        first = first or energy
        test.check(f"impact.ranks_{ranks}", max(difference(first[name], energy[name]) for name in NAMES[:3]), None, 1e-7)
    start = 0.5 * 1000 * 0.25 * 0.5**2
    test.check("impact.missing", np.max(np.abs(first["balance"])) / start, None, 0.08)
    test.check("impact.dissipated", first["dissipated"][-1] / start, 0.6, 1.05)
    test.check("impact.flow_only_grows", np.min(np.diff(first["dissipated"])) / start, -0.02)


def check_restart(test):
    """A run that is taken up again has the columns of the one that was not interrupted."""
    scene = write(test, IMPACT)
    whole = test.run(scene, mpm_quiet=None, mpm_time_end=0.2, mpm_checkpoint_every=70, mpm_checkpoint_keep=9)
    rows = {name: whole.results.column(f"energy_{name}") for name in NAMES}
    checkpoint = whole.folder / "impact_checkpoint_000070.h5"
    for ranks, bound in ((1, 1e-14), (2, 1e-7)):
        again = test.run(scene, ranks, mpm_quiet=None, mpm_time_end=0.2, mpm_restart=checkpoint)
        found = {name: again.results.column(f"energy_{name}") for name in NAMES}
        short = len(rows["kinetic"]) - len(found["kinetic"])
        test.check(f"restart.rows_{ranks}", len(found["kinetic"]), 30, 30)
        test.check(f"restart.ranks_{ranks}", max(difference(rows[name][short:], found[name]) for name in NAMES[:3]), None, bound)


def check_surface(test):
    """A load on a surface grows in few steps: its work is that of the step's mean, by the value at the end 7 % too much."""
    scene = write(test, PUSHED)
    for integrator in ("newmark", "generalized_alpha"):
        run = test.run(scene, mpm_quiet=None, mpm_time_integrator=integrator)
        test.check(f"surface.{integrator}", abs(account(run)["balance"][-1] / account(run)["external"][-1]), None, 2e-3)


def check_quasistatic(test):
    scene = (BAR % ("hencky", "E: 1e6, nu: 0", 3)).replace("integrator: newmark, ", "").replace(", transfer: flip", "")
    run = test.run(write(test, scene), mpm_quiet=None)
    names = Path(f"{run.prefix}_history.csv").read_text(encoding="utf-8").splitlines()[0]
    test.check("no_columns_without_inertia", names.count("energy") + names.count("momentum") + names.count("_vx"), 0, 0)


with Test() as test:
    for check in (check_order, check_elastic, check_base, check_friction, check_contact, check_impact, check_restart, check_surface, check_quasistatic):
        check(test)
