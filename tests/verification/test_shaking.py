#!/usr/bin/env python3
"""Conditions that shake, damping, and absorbing conditions, by closed forms.

A base moves as the exact integral of its acceleration, from a table or a ramp, with the exact velocity, and the bar on it as theory
says: of order 2 in the step. Rayleigh's damping takes from a bar's slowest oscillation what its ratio says. A wave that comes in
through an absorbing base has its amplitude, and leaves nothing behind as it goes out, by all shapes; at 45 degrees what theory says.
"""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import Test, difference  # noqa: E402

SHAPES = ("linear", "gimp", "bspline2", "bspline3", "gimp_bspline2")
BAR = """
mpm:
  dim: 2
  grid: {lower: "0,0", upper: "%g,%g", cells: "%d,1"}
  shape: gimp
  materials: soil
  material_soil: {type: linear_elastic, E: 1e5, nu: 0, density: 1000}
  bodies: bar
  body_bar: {region: box, lower: "0,0", upper: "%g,%g", points_per_cell: "2,2", material: soil}
  bcs: root,roll
  bc_root: {region: box, lower: "0,0", upper: "0,1", %s}
  bc_roll: {region: box, lower: "0,0", upper: "20,1", components: "%s"}
  tracks: root,tip,middle
  track_root: {region: box, lower: "0,0", upper: "0.08,1"}
  track_tip: {region: box, lower: "9.9,0", upper: "10,1"}
  track_middle: {region: box, lower: "4.9,0", upper: "5.1,1"}
  stabilization: {ghost: "off", fbar: false}
  time: {integrator: newmark, end: 2, step: 0.02}
  output: {prefix: bar, every: 0}
"""
PULSE = ",".join(f"{0.6 * k / 24:.4f}:{np.sin(np.pi * k / 24) ** 2:.8f}" for k in range(25))
SPEED, LENGTH = 10.0, 10.0  # m/s, m
SPACE = """
mpm:
  dim: 3
  grid: {lower: "0,0,0", upper: "0.25,0.25,12", cells: "1,1,48"}
  shape: gimp
  materials: soil
  material_soil: {type: linear_elastic, E: 1e5, nu: 0, density: 1000}
  bodies: bar
  body_bar: {region: box, lower: "0,0,0", upper: "0.25,0.25,12", points_per_cell: "2,2,2", material: soil}
  bcs: root,x
  bc_root: {region: box, lower: "0,0,0", upper: "1,1,0", components: "z", absorbing: true, value: "0.01", ramp: "PULSE"}
  bc_x: {region: box, lower: "0,0,0", upper: "1,1,20", components: "x,y"}
  tracks: middle
  track_middle: {region: box, lower: "0,0,5.9", upper: "1,1,6.1"}
  stabilization: {ghost: "off", fbar: false}
  time: {integrator: newmark, end: 4, step: 0.01}
  output: {prefix: bar, every: 0}
"""
OBLIQUE = """
mpm:
  dim: 2
  grid: {lower: "0,-%(depth)d", upper: "%(right)d,%(top)d", cells: "%(right)d,%(cells)d"}
  shape: gimp
  materials: soil
  material_soil: {type: linear_elastic, E: 0.8333333333333, nu: 0.25, density: 1}
  bodies: soil
  body_soil: {region: polygon, vertices: "%(body)s", points_per_cell: "2,2", material: soil}
  bcs: base
  bc_base: {region: box, lower: "0,-%(depth)d", upper: "%(right)d,-%(depth)d", absorbing: true}
  tracks: foot
  track_foot: {at: "%(foot)d,4", nearest: 4}
  loads: %(names)s
%(loads)s
  stabilization: {ghost: "off", fbar: false}
  time: {integrator: explicit, end: %(end)g, step: 0.25}
  output: {prefix: oblique, every: 0}
"""
FORMS = """
mpm:
  dim: 2
  grid: {lower: "0,0", upper: "3,2", cells: "6,4"}
  shape: %s
  materials: soil
  material_soil: {type: hencky, E: 1e6, nu: 0.3, density: 1000}
  bodies: block
  body_block: {region: box, lower: "0,0", upper: "2.5,1.6", points_per_cell: "2,2", material: soil, velocity: "-2,1"}
  bcs: base,side,roller
  bc_base: {region: box, lower: "0,0", upper: "3,0", absorbing: true, components: "y"}
  bc_side: {region: box, lower: "0,0", upper: "0,2", components: "x"}
  bc_roller: {region: box, lower: "2.5,0", upper: "2.5,2", normal: "1,0.4", quantity: velocity, value: -0.2}
  time: {integrator: generalized_alpha, end: 0.04, step: 0.01, damping_mass: 3, damping_stiffness: 2e-3, viscosity_linear: 0.06,
         viscosity_quadratic: 1.5%s}
  solver: direct
  output: {prefix: block, every: 4}
"""


def bar(root, along="x", cells=64):
    h = LENGTH / cells
    return BAR % (LENGTH + h, h, cells + 1, LENGTH, h, root, "y" if along == "x" else "x")


def write(test, text, **files):
    folder = test.folder()
    for name, content in files.items():
        (folder / f"{name}.csv").write_text(content, encoding="utf-8")
    (folder / "scene.yaml").write_text(text.replace("TABLE", str(folder / "table.csv")), encoding="utf-8")
    return folder / "scene.yaml"


def table(function, step, count):
    return "time,value\n" + "".join(f"{k * step!r},{float(function(k * step))!r}\n" for k in range(count))


def integrals(function, step, count, times):
    """Velocity and displacement of a piecewise linear acceleration, by fine sums."""
    fine = np.linspace(0.0, times[-1], 200001)
    a = np.interp(fine, step * np.arange(count), function(step * np.arange(count)), right=0.0)
    v = np.concatenate([[0.0], np.cumsum(0.5 * (a[1:] + a[:-1]) * np.diff(fine))])
    u = np.concatenate([[0.0], np.cumsum(0.5 * (v[1:] + v[:-1]) * np.diff(fine))])
    return np.interp(times, fine, v), np.interp(times, fine, u)


def check_base(test):
    """A stiff, short bar moves as its base does; all three quantities and both ways to give them."""
    stiff = bar('components: "x", quantity: acceleration, table: TABLE').replace("E: 1e5", "E: 1e11")
    signal = lambda t: 0.3 * np.sin(7.0 * t) * (1.0 - t / 1.17)  # noqa: E731
    scene = write(test, stiff, table=table(signal, 0.03, 40))
    for integrator in ("newmark", "generalized_alpha", "backward_euler"):
        run = test.run(scene, mpm_quiet=None, mpm_time_integrator=integrator)
        time = run.results.column("time")
        v, u = integrals(signal, 0.03, 40, time)
        test.check(f"base.way.{integrator}", difference(u, run.results.column("track_root_ux")), None, 1e-6)
        test.check(f"base.velocity.{integrator}", difference(v, run.results.column("track_root_vx")), None,
                   0.02 if integrator == "backward_euler" else 1e-3)
    for name, root, way in (("velocity", 'components: "x", quantity: velocity, value: 0.02, ramp: "0:0,1:1"', 0.03),
                            ("acceleration", 'components: "x", quantity: acceleration, value: 0.02, ramp: "0:1,1:1,1:0"', 0.03),
                            ("displacement", 'components: "x", value: 0.03, ramp: "0:0,1:0.4,2:1"', 0.03),
                            ("normal", 'normal: "2,0", quantity: velocity, value: 0.015', 0.03)):
        run = test.run(write(test, bar(root).replace("E: 1e5", "E: 1e11")), mpm_quiet=None)
        test.near(f"way_by.{name}", run.results.column("track_root_ux")[-1], way, 1e-5)


def check_order(test):
    """The tip of a bar whose root has the acceleration a sin(w t), from rest: by modes, and of order 2 in the step."""
    w, modes = 3.0, np.pi * (np.arange(400) + 0.5) * SPEED / LENGTH
    root = 'components: "x", quantity: acceleration, value: 0.05, table: TABLE'
    scene = write(test, bar(root), table=table(lambda t: np.sin(w * t), 0.002, 1001))
    t = np.arange(1, 26)[:, None] * 0.08
    share = -2.0 / (np.pi * (np.arange(400) + 0.5)) * (-1.0) ** np.arange(400)  # of each mode at the tip
    tip = np.sum(share * (np.sin(w * t) - w / modes * np.sin(modes * t)) / (modes**2 - w**2), axis=1)
    tip = 0.05 * (tip + t[:, 0] / w - np.sin(w * t[:, 0]) / w**2)
    for integrator in ("newmark", "generalized_alpha"):
        way = []
        for count in (1, 2, 4):
            run = test.run(scene, mpm_quiet=None, mpm_time_integrator=integrator, mpm_time_step=0.08 / count)
            way.append(run.results.column("track_tip_ux")[count - 1::count])
        test.check(f"tip.{integrator}", difference(tip, way[2]), None, 6e-3)
        test.check(f"tip_order.{integrator}", np.log2(difference(way[2], way[0]) / difference(way[2], way[1])) - np.log2(5 / 4), 1.5)


def check_damping(test):
    """The bar under a load that comes at once: each peak of its tip is nearer to rest by exp(-pi xi/sqrt(1 - xi^2))."""
    omega = 0.5 * np.pi * SPEED / LENGTH
    load = bar('components: "x"', cells=32) + '  loads: pull\n  load_pull: {type: gravity, value: "0.1,0", ramp: "0:1"}\n'
    scene, rest = write(test, load), 1000 * 0.1 * LENGTH**2 / 2 / 1e5
    for name, options in (("mass", {"mpm_time_damping_mass": 0.1 * 2 * omega}),
                          ("stiffness", {"mpm_time_damping_stiffness": 0.1 * 2 / omega}),
                          ("both", {"mpm_time_damping_mass": 0.05 * 2 * omega, "mpm_time_damping_stiffness": 0.05 * 2 / omega})):
        for integrator, step in (("newmark", 0.02), ("generalized_alpha", 0.02), ("explicit", 4e-3)):
            if integrator == "explicit" and name != "mass":
                continue
            run = test.run(scene, mpm_quiet=None, mpm_time_integrator=integrator, mpm_time_step=step, mpm_time_end=7, **options)
            t, tip = run.results.column("time"), run.results.column("track_tip_ux") / rest
            first, second = np.max(tip[t < 4]) - 1, 1 - np.min(tip[(t > 3) & (t < 6)])
            test.near(f"damping.{name}.{integrator}", np.log(first / second) / np.pi, 0.1 / np.sqrt(1 - 0.01), 0.06)
            energy = {k: run.results.column(f"energy_{k}") for k in ("balance", "dissipated", "elastic")}
            test.check(f"damping.missing.{name}.{integrator}", np.max(np.abs(energy["balance"])) / np.max(energy["elastic"]),
                       None, 0.02)


def check_incoming(test):
    """A wave comes in through the root, is thrown back by the tip, and goes out again."""
    for along, kind in (("x", "pressure"), ("y", "shear")):
        speed = SPEED if along == "x" else SPEED / np.sqrt(2)
        root = f'absorbing: true, components: "{along}", value: "0.01", ramp: "{PULSE}"'
        scene = write(test, bar(root, along))
        for shape in SHAPES:
            run = test.run(scene, mpm_quiet=None, mpm_shape=shape, mpm_time_end=3.3 * LENGTH / speed, mpm_time_step=0.01)
            t, v = run.results.column("time"), run.results.column(f"track_middle_v{along}")
            inside = np.abs(v[t < 1.9 * LENGTH / speed])
            test.near(f"incoming.{kind}.{shape}", np.max(inside), 0.01, 0.03)
            test.check(f"reflected.{kind}.{shape}", np.max(np.abs(v[t > 2.6 * LENGTH / speed])) / 0.01, None, 0.01)
    run = test.run(write(test, bar(f'absorbing: true, components: "x", value: "0.01", ramp: "{PULSE}"')), mpm_quiet=None,
                   mpm_time_integrator="explicit", mpm_time_step=0.005, mpm_time_end=3.3)
    t, v = run.results.column("time"), run.results.column("track_middle_vx")
    test.near("incoming.explicit", np.max(np.abs(v[t < 1.9])), 0.01, 0.03)
    test.check("reflected.explicit", np.max(np.abs(v[t > 2.6])) / 0.01, None, 0.005)
    run = test.run(write(test, SPACE.replace("PULSE", PULSE)), mpm_quiet=None)
    t, v = run.results.column("time"), run.results.column("track_middle_vz")
    test.near("incoming.3d", np.max(np.abs(v)), 0.01, 0.08)
    test.check("reflected.3d", np.max(np.abs(v[t > 3.1])) / 0.01, None, 0.01)


def beam(depth, wave=8, half=16, loads=8):
    """
    A beam of pressure waves on its way down at 45 degrees, 2 `half` cells wide, from forces across it; amplitudes fall to its sides as
    a squared cosine. The material is a strip along it, and ends at y = -depth; a wave goes a cell a second.
    """
    root = np.sqrt(0.5)
    way, back, side = round((half + 0.8 * wave) * root), round(wave / root), round((half + 2) / root)
    middle = round((half + wave) * root) + 3  # of the forces, at the height `way`
    foot, behind = middle + way, middle - way - back  # x - y behind the forces; on the axis x + y is `foot`
    signal = ",".join(f"{wave * k / 32}:{np.sin(np.pi * k / 32) ** 2 * np.sin(np.pi * k / 16):.8f}" for k in range(33))
    corners, blocks, width = ((-1, 0), (1, 0), (1, 1), (-1, 1)), [], 2 * half / loads
    for k in range(loads):
        across = [-half + width * (k + end) for end in (0, 1)]
        places = [(middle + (along + across[end]) * root, way + (across[end] - along) * root) for along, end in corners]
        push = 1e-4 * width * np.cos(np.pi * sum(across) / 4 / half) ** 2
        blocks.append(f'  load_l{k}: {{type: force, region: polygon, vertices: "{flat(places)}", value: "{push},{-push}", ramp: "{signal}"}}')
    body = [((foot + end * side + behind) / 2, (foot + end * side - behind) / 2) for end in (1, -1)]
    body += [(foot + end * side + depth, -depth) for end in (-1, 1)]
    top = int(body[0][1]) + 2
    return OBLIQUE % {"depth": depth, "right": foot + side + depth + 2, "top": top, "cells": top + depth, "body": flat(body), "foot": foot,
                      "names": ",".join(f"l{k}" for k in range(loads)), "loads": "\n".join(blocks), "end": way / root + wave + 14}


def flat(places):
    return ",".join(f"{number:.6f}" for place in places for number in place)


def check_oblique(test):
    """
    A beam of plane pressure waves meets the base at 45 degrees: what comes back, as the difference to ground that goes on below, over
    what comes in. Lysmer and Kuhlemeyer's dashpots send back a shear wave of 7.1 % and a pressure wave of 1.4 %, nu = 0.25; the
    beam's directions, some degrees about 45, add 2 % of pressure.
    """
    sines = np.sqrt(0.5) * np.array([1, 1 / np.sqrt(3)])  # of the reflected waves to the normal, pressure and shear
    parts = np.linalg.inv([[sines[0], np.sqrt(1 - sines[1] ** 2)], [sines[0], -sines[1]]])
    for label, options in (("explicit", {}), ("generalized_alpha", {"step": 0.8}), ("newmark", {"step": 0.8, "mass": "lumped"})):
        chosen = {f"mpm_time_{key}": value for key, value in {"integrator": label, **options}.items()}
        runs = [test.run(write(test, beam(depth)), mpm_quiet=None, **chosen).results for depth in (0, 9)]
        back, through = [np.array([run.column(f"track_foot_v{a}") for a in "xy"]) for run in runs]
        most = np.max(np.abs(parts @ (back - through)), axis=1) / np.max(np.linalg.norm(through, axis=0))
        test.check(f"reflected.45_degrees.shear.{label}", most[1], 0.055, 0.085)
        test.check(f"reflected.45_degrees.pressure.{label}", most[0], None, 0.065)


def check_forms(test):
    """All forms of the Jacobian, on any number of ranks, in few iterations, with lumped and consistent mass."""
    for shape, more in (("gimp", ""), ("bspline2", ", mass: consistent")):
        scene = write(test, FORMS % (shape, more))
        first = test.run(scene, mpm_quiet=None, mpm_jacobian="local", snes_rtol=1e-12)
        test.check(f"forms.newton.{shape}", np.max(first.newton), 1, 4)
        for form, ranks in (("coloring", 1), ("matfree", 1), ("dense", 1), ("local", 2), ("local", 3)):
            options = {"ksp_type": "gmres", "ksp_rtol": 1e-12, "pc_type": "jacobi"} if form == "matfree" else {}
            run = test.run(scene, ranks, mpm_quiet=None, mpm_jacobian=form, snes_rtol=1e-12, **options)
            test.check(f"forms.{shape}.{form}_{ranks}", difference(first.table("velocity"), run.table("velocity")), None, 1e-7)


with Test() as test:
    for check in (check_base, check_order, check_damping, check_incoming, check_oblique, check_forms):
        check(test)
