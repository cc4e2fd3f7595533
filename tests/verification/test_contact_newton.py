#!/usr/bin/env python3
"""Newton's method with moving boundaries: few iterations a step and no cuts, with stiff contact and in plastic flow. Until a block
touches a rough floor, its Jacobian is solved as the symmetric one that it is. A block that nothing but little friction holds comes to rest.

Quick. Coarse forms of examples.
"""
import math
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import EXAMPLES, Test, example  # noqa: E402

FALL = """
mpm:
  dim: 2
  grid: {lower: "0,0", upper: "3,2", cells: "12,8"}
  materials: r
  material_r: {type: hencky, E: 1e7, nu: 0.2, density: 2000}
  bodies: b
  body_b: {region: box, lower: "0.5,0.5", upper: "1,1", points_per_cell: "2,2", material: r, velocity: "1,-1"}
  boundaries: floor
  boundary_floor: {type: plane, point: "0,0.3", normal: "0,1", friction: 0.3}
  loads: g
  load_g: {type: gravity, value: "0,-10", ramp: "0:1"}
  tracks: m
  track_m: {region: all}
  time: {end: 0.3, integrator: generalized_alpha, rho_inf: 0.8, step: 0.01}
  output: {prefix: fall}
"""
LEVEL = """
mpm:
  dim: 2
  grid: {lower: "0,0", upper: "8,4", cells: "32,16"}
  materials: r
  material_r: {type: hencky, E: 50e6, nu: 0.3, density: 2000}
  bodies: block%s
  body_block: {region: box, lower: "1,0.5", upper: "3,1.5", points_per_cell: "2,2", material: r}
%s
  loads: weight,side
  load_weight: {type: gravity, value: "0,-10", ramp: "0:0,0.2:1"}
  load_side: {type: gravity, value: "1,0", ramp: "0:0,0.2:0,1.2:1"}
  tracks: block
  track_block: {region: box, lower: "1,0.5", upper: "3,1.5"}
  time: {end: %g, step: 0.05, step_min: 0.0005}
  output: {prefix: level}
"""
FLOOR = '  boundaries: floor\n  boundary_floor: {type: plane, point: "0,0.5", normal: "0,1", friction: %g}'
BASE = """  body_base: {region: box, lower: "0,0", upper: "8,0.5", points_per_cell: "2,2", material: r}
  bcs: base
  bc_base: {region: box, lower: "0,0", upper: "8,0", components: "x,y"}
  contacts: ab
  contact_ab: {bodies: "block,base", friction: %g}"""
SILO = """
mpm:
  dim: 2
  grid: {lower: "0,0", upper: "0.75,2.25", cells: "6,18"}
  materials: sand,wall
  material_sand: {type: mohr_coulomb, E: 2e6, nu: 0.3, density: 1600, cohesion: 0, friction: 30, dilation: 0}
  material_wall: {type: hencky, E: 2e7, nu: 0, density: 0.1}
  bodies: %s
  body_sand: {region: box, lower: "0,0", upper: "0.5,2", points_per_cell: "2,2", material: sand}
  bcs: base,left%s
  bc_base: {region: box, lower: "0,0", upper: "0.75,0", components: "y"}
  bc_left: {region: box, lower: "0,0", upper: "0,2.25", components: "x"}
%s
  loads: weight
  load_weight: {type: gravity, value: "0,-10", ramp: "0:0,1:1"}
  time: {end: 1, step: %g}
  output: {prefix: silo}
"""
WALL = '  boundaries: wall\n  boundary_wall: {type: plane, point: "0.5,0", normal: "-1,0", friction: %g}'
BLOCK = """  body_wall: {region: box, lower: "0.5,0", upper: "0.75,2.25", points_per_cell: "2,2", material: wall}
  bc_back: {region: box, lower: "0.75,0", upper: "0.75,2.25", components: "x,y"}
  contacts: rough
  contact_rough: {bodies: "sand,wall", friction: %g}"""
SHORT = {"mpm_output_every": 0, "mpm_quiet": None}


def few(test, name, run, most, cuts=0):
    """No more than `most` iterations a step on average, and no cut, or few."""
    test.check(f"{name}.newton_a_step", run.results.column("newton").mean(), None, most)
    test.check(f"{name}.cuts", run.results.column("cuts").sum(), None, cuts)


def fall(test):
    """The block flies, and then slides; with and without the solver of free flight it does so alike."""
    scene = test.folder() / "fall.yaml"
    scene.write_text(FALL, encoding="utf-8")
    run = test.run(scene, ksp_view=None, **SHORT)
    test.check("fall.symmetric", int("band Cholesky" in run.output), 1, 1)
    test.check("fall.unsymmetric", int("type: lu" in run.output), 1, 1)
    lu = test.run(scene, pc_type="lu", **SHORT)
    multigrid = test.run(scene, ranks=2, mpm_solver="amg", ksp_rtol=1e-12, **SHORT)
    for axis in "xy":
        name = f"track_m_u{axis}"
        test.near(f"lu.{name}", lu.results.column(name)[-1], run.results.column(name)[-1], relative=1e-9)
        test.near(f"multigrid.{name}", multigrid.results.column(name)[-1], run.results.column(name)[-1], relative=1e-6)


def level(test):
    """A block that its weight spreads is held up to nearly its friction; nothing else holds it."""
    for name, more, holds in (("floor", "", FLOOR), ("base", ",base", BASE)):
        for friction in (0.04, 0.05):
            scene = test.folder() / "level.yaml"
            scene.write_text(LEVEL % (more, holds % friction, 0.2 + 9.6 * friction), encoding="utf-8")
            results = test.run(scene, **SHORT).results
            test.check(f"level.{name}_{friction}", results.column("track_block_ux")[-1], 0.0, 1e-4)
            test.check(f"level.{name}_{friction}.cuts", results.column("cuts").sum(), None, 0)


def held(test):
    """A soft block on a slope just below its angle: it is not thrown down the slope, to come back in many iterations."""
    slope = math.atan(0.15) - math.radians(0.3)
    scene = test.folder() / "held.yaml"
    scene.write_text(LEVEL % ("", FLOOR % 0.15, 1), encoding="utf-8")
    run = test.run(scene, mpm_load_weight_ramp="0:0,1:1", mpm_load_weight_value=f"0,{-10 * math.cos(slope)}",
                   mpm_load_side_ramp="0:0,1:1", mpm_load_side_value=f"{-10 * math.sin(slope)},0", mpm_material_r_E=1e5,
                   mpm_body_block_points_per_cell="3,3", mpm_body_block_lower="1,0.625", mpm_body_block_upper="2,1.125",
                   mpm_boundary_floor_point="0,0.625", mpm_time_step=0.25, **SHORT)
    few(test, "held", run, 12)


def let_go(test):
    """Pushed by more, it slides off: the run ends where friction does, and says so."""
    for name, more, holds in (("floor", "", FLOOR), ("base", ",base", BASE)):
        scene = test.folder() / "off.yaml"
        scene.write_text(LEVEL % (more, holds % 0.08, 1.24), encoding="utf-8")
        run = test.run(scene, status=3, **SHORT)
        test.check(f"let_go.{name}.says", int("nothing but friction holds body block against translation in x (Newton" in run.errors), 1, 1)
        test.near(f"let_go.{name}.at", run.results.column("time")[-1], 1.0, absolute=2e-3)
        test.check(f"let_go.{name}.way", run.results.column("track_block_ux")[-1], 0.0, 2e-4)


def spread(test):
    """Its weight has all of a soft block slide, to both sides: what holds it in its place is no rounding error."""
    scene = test.folder() / "spread.yaml"
    scene.write_text(LEVEL % ("", FLOOR % 0.04, 0.4), encoding="utf-8")
    soft = {"mpm_material_r_E": 5e6, "mpm_material_r_nu": 0.45, "mpm_shape": "gimp_bspline2",
            "mpm_body_block_points_per_cell": "3,3", **SHORT}
    runs = [test.run(scene, ranks=ranks, **soft) for ranks in (1, 3)]
    one, other = (run.results.column("track_block_ux") for run in runs)
    test.check("spread.start", abs(one[3]), None, 1e-9)
    test.check("spread.ranks", abs(one - other).max(), None, 1e-9)


def silo(test):
    """Sand without cohesion fills a silo: all of it slides down its wall, whatever the step, and the wall carries friction's part."""
    scene = test.folder() / "silo.yaml"
    base = {}
    for friction, step, ranks in ((0.01, 1.0, 1), (0.2, 1.0, 1), (0.2, 0.25, 3)):
        scene.write_text(SILO % ("sand", "", WALL % friction, step), encoding="utf-8")
        run = test.run(scene, ranks=ranks, **SHORT)
        normal, along, base[friction, step] = (-run.results.column("reaction_wall_x")[-1], run.results.column("reaction_wall_y")[-1],
                                               run.results.column("reaction_base_y")[-1])
        few(test, f"silo.{friction}.{step}", run, 12)
        test.near(f"silo.{friction}.{step}.slides", along / normal, friction, relative=1e-6)
        test.near(f"silo.{friction}.{step}.weight", along + base[friction, step], 16e3, relative=1e-6)
    test.near("silo.step", base[0.2, 0.25], base[0.2, 1.0], relative=1e-3)
    scene.write_text(SILO % ("sand,wall", ",back", BLOCK % 0.2, 1.0), encoding="utf-8")
    run = test.run(scene, **SHORT)
    few(test, "silo.block", run, 12)
    part = abs(run.results.column("force_rough_y")[-1] / run.results.column("force_rough_x")[-1])
    test.check("silo.block.slides", part, 0.18, 0.2)  # at the base it sticks


with Test() as check:
    fall(check)
    silo(check)
    level(check)
    held(check)
    let_go(check)
    spread(check)
    stiff = check.run(example("shallow_ironing"), mpm_grid_cells="48,18", mpm_time_end=1.6, mpm_boundary_die_penalty=500,
                      mpm_boundary_die_motion_table=EXAMPLES / "shallow_ironing" / "motion.csv", **SHORT)
    few(check, "stiff", stiff, 5.0, cuts=2)  # as without stabilisation: the die turns aside at once, and lies under a row of nodes
    few(check, "pipe", check.run(example("pipe"), mpm_grid_cells="28,12", mpm_time_step=0.02, **SHORT), 3.8)
    few(check, "hertz", check.run(example("hertz"), mpm_grid_cells="44,44", **SHORT), 2.5)
