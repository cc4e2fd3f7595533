#!/usr/bin/env python3
"""Axial symmetry, dynamics: a ring that vibrates, waves along and across a rod, energy and momentum, a rod that bounces, ranks,
restart. Quick.

Ring: omega^2 = E/(rho R^2), Timoshenko, Young, Weaver (1974), Vibration problems in engineering, section 5.14.
Cylinder in plane strain: omega a/c_p = z, z J_0(z) = (1 - 2 nu)/(1 - nu) J_1(z), Love (1927), A treatise on the
mathematical theory of elasticity, article 199.
"""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import Test, difference  # noqa: E402

SCENE = """
mpm:
  dim: 2
  kinematics: axisymmetric
  grid: {lower: "%s", upper: "%s", cells: "%s"}
  shape: gimp
  materials: steel
  material_steel: {type: neo_hookean, E: 1e6, nu: %g, density: 1000}
  bodies: body
  body_body: {%s, material: steel}
  tracks: body
  track_body: {region: box, lower: "%s", upper: "%s"}
  time: {end: %g, step: %g}
  output: {prefix: body, every: 0}
"""
METHODS = ("explicit", "newmark", "generalized_alpha")


def box(lower, upper):
    """A body between two corners."""
    return f'region: box, lower: "{lower}", upper: "{upper}", points_per_cell: "2,2"'


def written(test, grid, nu, body, track, time):
    """A scene of one body as a file."""
    scene = test.folder() / "case.yaml"
    scene.write_text(SCENE % (*grid, nu, body, *track, *time))
    return scene


def bessel(x):
    """J_1 by its series."""
    term = total = x / 2
    for k in range(1, 20):
        term = -term * (x / 2) ** 2 / (k * (k + 1))
        total = total + term
    return total


def frequency(time, value):
    """Circular frequency by the first and the last crossing of zero; radians a second."""
    k = np.flatnonzero(np.diff(np.sign(value)))
    cross = time[k] - value[k] * np.diff(time)[k] / np.diff(value)[k]
    return np.pi * (len(cross) - 1) / (cross[-1] - cross[0])


def ring(test):
    """A thin ring that is set off along the radius; its energy stays, and its motion along the axis."""
    radius = 10.0
    exact = np.sqrt(1e6 / 1000) / radius
    end = 3.1 * 2 * np.pi / exact
    scene = written(test, ("9,0", "11,1", "20,10"), 0.3, box("9.9,0.4", "10.1,0.6"), ("9.9,0.4", "10.1,0.6"), (end, end / 300))
    for method in METHODS:
        more = {"mpm_time_step": 1e-3} if method == "explicit" else {}
        run = test.run(scene, mpm_time_integrator=method, mpm_body_body_velocity="0.01,0.002", **more)
        results = run.results
        found = frequency(results.column("time"), results.column("track_body_ux"))
        test.near(f"ring.{method}.frequency", found, exact, relative=2e-3)
        kinetic = 0.5 * 1000 * 2 * np.pi * radius * 0.2**2 * (0.01**2 + 0.002**2)
        balance = np.abs(results.column("energy_balance")).max() / kinetic
        test.check(f"ring.{method}.energy", balance, None, 3e-3 if method == "explicit" else 1e-4)
        along = results.column("momentum_y") / (1000 * 2 * np.pi * radius * 0.2**2 * 0.002)
        test.check(f"ring.{method}.momentum", np.abs(along - 1).max(), None, 1e-9)


def restart(test):
    """A ring goes on from a checkpoint as if it had not stopped."""
    scene = written(test, ("9,0", "11,1", "20,10"), 0.3, box("9.9,0.4", "10.1,0.6"), ("9.9,0.4", "10.1,0.6"), (0.1, 2e-3))
    for method in METHODS:
        options = {"mpm_time_integrator": method, "mpm_body_body_velocity": "0.01,0.002", "mpm_checkpoint_every": 25}
        whole = test.run(scene, **options)
        rest = test.run(scene, mpm_restart=whole.folder / "body_checkpoint_000025.h5", **options).results
        columns = [results.column("track_body_ux")[-25:] for results in (whole.results, rest)]
        test.check(f"restart.{method}", difference(*columns), None, 1e-9)


def points(test, size, count, velocity):
    """A table of the points of a cylinder: radius and height, points along them, and the velocity of each."""
    r, y = (arm.ravel() for arm in np.meshgrid(*((np.arange(n) + 0.5) * length / n for length, n in zip(size, count))))
    half = [np.full_like(r, 0.5 * length / n) for length, n in zip(size, count)]
    table = np.stack([r, y, 8 * np.pi * r * half[0] * half[1], *half, *velocity(r, y)], 1)
    path = test.folder() / "points.csv"
    np.savetxt(path, table, delimiter=",", comments="", header="x,y,volume,half_length_x,half_length_y,velocity_x,velocity_y")
    return f"region: file, file: {path}"


def rod(test):
    """First longitudinal vibration of a rod with one end fixed, its lateral inertia included (Love)."""
    a, length, wave = 0.4, 2.0, np.pi / 4.0
    exact = wave * np.sqrt(1e6 / 1000 / (1 + 0.5 * (0.3 * wave * a) ** 2))
    end = 1.1 * 2 * np.pi / exact
    base = {"mpm_bcs": "base", "mpm_bc_base_region": "box", "mpm_bc_base_lower": "0,0", "mpm_bc_base_upper": "1,0",
            "mpm_bc_base_components": "y"}
    start = points(test, (a, length), (16, 80), lambda r, y: (-0.3 * wave * r * np.cos(wave * y) * 1e-3, np.sin(wave * y) * 1e-3))
    scene = written(test, ("0,0", "0.5,2.25", "10,45"), 0.3, start, ("0,1.9", "0.4,2"), (end, end / 200))
    for ranks, method in ((1, "explicit"), (3, "explicit"), (1, "newmark")):
        more = {"mpm_time_step": 5e-4} if method == "explicit" else {}
        results = test.run(scene, ranks=ranks, mpm_time_integrator=method, **base, **more).results
        found = frequency(results.column("time"), results.column("track_body_uy"))
        test.near(f"rod.{method}_on_{ranks}", found, exact, relative=1e-3)


def cylinder(test):
    """First radial vibration of a solid cylinder in plane strain."""
    a, z = 1.0, 2.1257489
    exact = z * np.sqrt(1e6 * 0.7 / (1.3 * 0.4) / 1000) / a
    end = 3.1 * 2 * np.pi / exact
    start = points(test, (a, 0.2), (40, 8), lambda r, y: (1e-3 * bessel(z * r / a), 0 * r))
    both = {"mpm_bcs": "both", "mpm_bc_both_region": "all", "mpm_bc_both_components": "y"}
    scene = written(test, ("0,0", "1.25,0.2", "25,4"), 0.3, start, ("0.9,0", "1,0.2"), (end, end / 300))
    for method in METHODS:
        more = {"mpm_time_step": 2e-4} if method == "explicit" else {}
        results = test.run(scene, mpm_time_integrator=method, **both, **more).results
        found = frequency(results.column("time"), results.column("track_body_ux"))
        test.near(f"cylinder.{method}", found, exact, relative=3e-3)


def bounce(test):
    """A rod that hits a rigid plane: the force is rho c v A for as long as a wave runs to and fro, and the rod flies off as it came."""
    speed = np.sqrt(1e6 / 1000)
    plane = {"mpm_boundaries": "floor", "mpm_boundary_floor_type": "plane", "mpm_boundary_floor_point": "0,0",
             "mpm_boundary_floor_normal": "0,1", "mpm_boundary_floor_penalty": 20}
    scene = written(test, ("0,-0.2", "0.5,3", "5,32"), 0.0, box("0,0", "0.4,2"), ("0,0", "0.4,2"), (6 / speed, 1e-4))
    results = test.run(scene, mpm_time_integrator="explicit", mpm_body_body_velocity="0,-0.1", **plane).results
    area = np.pi * 0.4**2
    wave = results.column("time") * speed
    force = results.column("reaction_floor_y")[(wave > 1) & (wave < 3)].mean()
    test.near("bounce.force", force / (1000 * speed * 0.1 * area), 1.0, relative=5e-3)
    test.near("bounce.velocity", results.column("momentum_y")[-1] / (1000 * area * 2), 0.1, relative=0.06)


PARTS = (ring, restart, rod, cylinder, bounce)
if __name__ == "__main__":
    with Test() as test:
        for part in PARTS:
            part(test)
