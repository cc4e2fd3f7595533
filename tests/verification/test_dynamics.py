#!/usr/bin/env python3
"""Implicit dynamics: orders in time, what transfers keep, free flight, blocks that slide and fall, restart and ranks.

Quick.
"""
import sys
from pathlib import Path

import numpy as np

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))
from talus_test import Test, difference, example  # noqa: E402

BAR = {"mpm_grid_upper": "12.5,1", "mpm_grid_cells": "40,1", "mpm_shape": "gimp_bspline2", "mpm_time_transfer": "flip",
       "mpm_load_weight_ramp": "0:0,4:1", "mpm_output_every": 0, "mpm_quiet": None}


def orders(test):
    """Backward Euler's error goes with the step, those of the others with its square; the reference has steps of its own."""
    for name, expected in (("backward_euler", 1), ("newmark", 2), ("generalized_alpha", 2)):
        tips = {}
        for step in (0.04, 0.02, 0.005):
            run = test.run(scene(test, name != "generalized_alpha"), mpm_time_integrator=name, mpm_time_end=4,
                           mpm_time_step=step, **BAR)
            tips[step] = run.results.column("track_tip_ux")[round(0.04 / step) - 1::round(0.04 / step)]
        ratio = np.abs(tips[0.04] - tips[0.005]).max() / np.abs(tips[0.02] - tips[0.005]).max()
        exact = (0.04**expected - 0.005**expected) / (0.02**expected - 0.005**expected)
        test.near(f"{name}.ratio_of_errors", ratio, exact, relative=0.15)


def scene(test, leave_out):
    """The bar's scene without some of its time options."""
    text = example("vibrating_bar").read_text(encoding="utf-8")
    if leave_out:
        text = text.replace("rho_inf: 1, ", "")
    path = test.folder() / "bar.yaml"
    path.write_text(text, encoding="utf-8")
    return path


def bar(test):
    run = test.run(example("vibrating_bar"), mpm_output_every=0, mpm_time_end=8.2, mpm_quiet=None)
    test.check_example("bar", run, "vibrating_bar")


def chosen(test):
    """Steps by their error: as many as it takes on any number of ranks and after a restart, and no more for what points do not feel."""
    text = scene(test, False).read_text(encoding="utf-8").replace("step: 0.01", "step: 0.01, step_max: 0.5, error: 1e-4")
    path = test.folder() / "chosen.yaml"
    path.write_text(text, encoding="utf-8")
    options = {**BAR, "mpm_load_weight_ramp": "0:1", "mpm_time_end": 4}
    exact = test.run(scene(test, False), mpm_time_step=0.004, **options).results
    run = test.run(path, mpm_checkpoint_every=100, mpm_checkpoint_keep=9, **options)
    time, tip, length = (run.results.column(name) for name in ("time", "track_tip_ux", "dt"))
    reference = np.interp(time, exact.column("time"), exact.column("track_tip_ux"))
    test.check("chosen.steps", time.size, 100, 800)
    test.check("chosen.error", np.abs(tip - reference).max() / np.abs(reference).max(), None, 2e-3)
    begun = f"{run.prefix}_checkpoint_000100.h5"
    for name, ranks, more in (("ranks", 3, {}), ("restart", 1, {"mpm_restart": begun}), ("restart_2", 2, {"mpm_restart": begun})):
        other = test.run(path, ranks=ranks, **options, **more).results
        test.check(f"chosen.{name}.lengths", difference(other.column("dt"), length[-other.column("dt").size:]), None, 0.0)
        test.check(f"chosen.{name}.tip", abs(other.column("track_tip_ux")[-1] - tip[-1]) / np.abs(tip).max(), None, 1e-9)


def beam(test):
    """On any number of ranks, and with a stop on the way, the same."""
    options = {"mpm_grid_cells": "12,16", "mpm_time_end": 1.4, "mpm_time_step": 0.02, "mpm_output_every": 70,
               "mpm_quiet": None}
    one = test.run(example("vibrating_beam"), **options)
    test.check_example("beam", one, "vibrating_beam")
    tip = one.results.column("track_tip_uy")
    for ranks in (2, 3):
        other = test.run(example("vibrating_beam"), ranks=ranks, **options)
        test.check(f"beam.ranks_{ranks}", difference(other.results.column("track_tip_uy"), tip), None, 1e-8)
    begun = test.run(example("vibrating_beam"), ranks=2, mpm_checkpoint_every=30, **{**options, "mpm_time_end": 0.6})
    on = test.run(example("vibrating_beam"), mpm_restart=f"{begun.prefix}_checkpoint.h5", **options)
    for column in ("track_tip_uy", "track_tip_vy", "energy_kinetic", "energy_external", "energy_balance"):
        end = one.results.column(column)[-1]
        test.check(f"beam.restart.{column}", abs(on.results.column(column)[-1] - end) / np.abs(one.results.column(column)).max(),
                   None, 1e-8)


def fall(test):
    """A block that falls stays as it is, with every shape: its weight is where its mass is."""
    for shape in ("gimp", "bspline2", "gimp_bspline2"):
        for mass in ("consistent", "lumped"):
            run = test.run(HERE / "free_fall.yaml", mpm_shape=shape, mpm_time_mass=mass, mpm_quiet=None)
            speed = run.table("velocity")[:, 1]
            test.check(f"fall.{shape}.{mass}", np.abs(speed + 9.81 * 0.4).max(), None, 1e-10)


def discs(test):
    """Momentum with every integrator, angular momentum where it is kept exactly."""
    for name, step in (("explicit", None), ("newmark", 0.02), ("generalized_alpha", 0.02), ("backward_euler", 0.02)):
        text = example("discs").read_text(encoding="utf-8").replace("cfl: 0.5, ", "")
        path = test.folder() / "discs.yaml"
        path.write_text(text, encoding="utf-8")
        options = {"mpm_time_step": step} if step else {}
        run = test.run(path, mpm_grid_cells="32,16", mpm_time_integrator=name, mpm_output_every=50, mpm_quiet=None, **options)
        test.check_example(f"discs.{name}", run, "discs")


def block(test):
    """On a slope of 45 degrees with a friction of 0.3, for a second."""
    text = example("incline_slide").read_text(encoding="utf-8")
    for name in ("generalized_alpha", "backward_euler", "explicit"):
        path = test.folder() / "slide.yaml"
        path.write_text(text.replace("generalized_alpha", name).replace(", step: 0.01" if name == "explicit" else "?", ""),
                        encoding="utf-8")
        test.check_example(f"block.{name}", test.run(path, mpm_output_every=50, mpm_quiet=None), "incline_slide")


def impacts(test):
    """Contact gives no energy: a block that falls between planes, and one onto another."""
    path = test.folder() / "falls.yaml"
    for label, ground, options in (("planes", FLOOR, {}), ("planes_flip", FLOOR, {"mpm_time_transfer": "flip"}),
                                   ("planes_damped", FLOOR, {"mpm_time_beta": 0.3025, "mpm_time_gamma": 0.6}), ("bodies", GROUND, {})):
        path.write_text(FALLS + ground, encoding="utf-8")
        run = test.run(path, mpm_quiet=None, **options)
        column = run.results.column
        had = column("energy_kinetic") + column("energy_elastic") - column("energy_external")
        test.check(f"impacts.{label}.gained", had.max() / column("energy_kinetic").max(), None, 1e-6)
        test.check(f"impacts.{label}.balance", column("energy_balance").max() / column("energy_kinetic").max(), None, 0.02)
        test.check(f"impacts.{label}.rests", column("energy_kinetic")[-1] / column("energy_kinetic").max(), None, 0.3)


FALLS = """
mpm:
  dim: 2
  grid: {lower: "0,0", upper: "3,3", cells: "12,12"}
  materials: stone
  material_stone: {type: neo_hookean, E: 1e7, nu: 0.3, density: 2000}
  body_block: {region: box, lower: "0.5,0.6", upper: "2.5,2.1", points_per_cell: "2,2", material: stone}
  boundary_west: {type: plane, point: "0.5,0", normal: "1,0"}
  boundary_east: {type: plane, point: "2.5,0", normal: "-1,0"}
  loads: weight
  load_weight: {type: gravity, value: "0,-10", ramp: "0:1"}
  time: {integrator: newmark, end: 1, step: 0.02}
  output: {prefix: falls, every: 0}
"""
FLOOR = """
  bodies: block
  boundaries: floor,west,east
  boundary_floor: {type: plane, point: "0,0.5", normal: "0,1"}
"""
GROUND = """
  bodies: block,low
  body_low: {region: box, lower: "0.5,0", upper: "2.5,0.5", points_per_cell: "3,3", material: stone}
  contacts: both
  contact_both: {bodies: "block,low"}
  boundaries: west,east
  bcs: base
  bc_base: {region: box, lower: "0,0", upper: "3,0", components: "x,y"}
"""


def supports(test):
    """What inclined conditions bear of a body that comes to rest: its weight, each along its own normal."""
    path = test.folder() / "supports.yaml"
    path.write_text(SUPPORTS, encoding="utf-8")
    results = test.run(path, mpm_quiet=None).results
    for name, normal in (("one", (0.6, 0.8)), ("two", (-0.8, 0.6))):
        for axis, component in zip("xy", normal):
            test.near(f"supports.{name}_{axis}", results.column(f"reaction_{name}_{axis}")[-1], 4000 * normal[1] * component,
                      absolute=0.1)


SUPPORTS = """
mpm:
  dim: 2
  grid: {lower: "0,0", upper: "4,4", cells: "8,8"}
  materials: soil
  material_soil: {type: hencky, E: 1e6, nu: 0.3, density: 1000}
  bodies: block
  body_block: {region: box, lower: "0,0", upper: "2,2", points_per_cell: "2,2", material: soil}
  bcs: one,two
  bc_one: {region: box, lower: "0,0", upper: "4,0", normal: "0.6,0.8"}
  bc_two: {region: box, lower: "0,0", upper: "4,0", normal: "-0.8,0.6"}
  loads: weight
  load_weight: {type: gravity, value: "0,-1", ramp: "0:0,1:1"}
  time: {integrator: backward_euler, end: 20, step: 0.2}
  output: {prefix: supports, every: 0}
"""


with Test() as check:
    orders(check)
    bar(check)
    chosen(check)
    beam(check)
    fall(check)
    discs(check)
    block(check)
    impacts(check)
    supports(check)
