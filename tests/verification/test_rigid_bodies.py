#!/usr/bin/env python3
"""Rigid bodies under force and moment: they come to rest where the forces of their contacts are in balance with what
pushes them, whatever solver, ranks or restart; an augmented Lagrangian leaves no depth; and where nothing can hold them, or they make no sense, a line says so.

Quick.
"""
import shutil
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import Test, example  # noqa: E402

BALANCE = 1e-10  # of the load
SOLVERS = {"boomeramg": {"mpm_solver": "boomeramg"}, "matfree": {"mpm_jacobian": "matfree"},
           "baij": {"mpm_mat_type": "baij", "pc_type": "lu"}}
SAME = 1e-7  # of the radius, between solvers that iterate to a tolerance
RANKS = 1e-9

# A lid on a block, under a force beside its middle and a moment: what acts at its pivot, and where it has none to turn.
LID = """
mpm:
  dim: 3
  grid: {lower: "0,0,0", upper: "2,2,1.5", cells: "4,4,3"}
  materials: soil
  material_soil: {type: hencky, E: 1e6, nu: 0.3, density: 1000}
  bodies: block
  body_block: {region: box, lower: "0,0,0", upper: "2,2,1", points_per_cell: "2,2,2", material: soil}
  bcs: base
  bc_base: {region: box, lower: "0,0,0", upper: "2,2,0", components: "x,y,z"}
  boundaries: lid
  boundary_lid: {type: plane, point: "1,1,1.1", normal: "0,0,-1", pivot: "1.1,0.9,1.1", friction: stick,
                 free: "x,y,z,rx,ry,rz", load: "100,50,-10e3", moment: "300,-500,100"}
  time: {end: 1, step: 0.5}
  output: {prefix: lid, every: 0}
"""
# The same force at an eccentricity: that of the moment. Smooth, and free to sink and to turn.
PLATE = """
mpm:
  dim: 2
  grid: {lower: "0,0", upper: "3,3", cells: "12,12"}
  materials: soil
  material_soil: {type: linear_elastic, E: 1e7, nu: 0, density: 1000}
  bodies: block
  body_block: {region: box, lower: "0,0", upper: "2,2", points_per_cell: "2,2", material: soil}
  bcs: base
  bc_base: {region: box, lower: "0,0", upper: "2,0", components: "x,y"}
  boundaries: plate
  boundary_plate: {type: box, lower: "-0.5,2", upper: "2.5,2.5", pivot: "1,2", free: "y,rz", load: "0,-10e3",
                   moment: "1e3", load_ramp: "0:0,1:1"}
  time: {end: 1, step: 0.5}
  output: {prefix: plate, every: 0}
"""

# A box on ground that is wider, pressed and then slid along it.
SLED = """
mpm:
  dim: 2
  grid: {lower: "0,0", upper: "4,2", cells: "16,8"}
  materials: soil
  material_soil: {type: hencky, E: 1e7, nu: 0.3, density: 1000}
  bodies: block
  body_block: {region: box, lower: "0,0", upper: "4,1", points_per_cell: "2,2", material: soil}
  bcs: base,side
  bc_base: {region: box, lower: "0,0", upper: "4,0", components: "x,y"}
  bc_side: {region: box, lower: "0,0", upper: "0,2", components: "x"}
  boundaries: sled
  boundary_sled: {type: box, lower: "1,1", upper: "2,1.5", friction: 0.3, method: augmented, free: "y", load: "0,-2e4",
                  load_ramp: "0:0,0.25:1", motion: "0.3,0", ramp: "0.25:0,1:1"}
  time: {end: 1, step: 0.05}
  output: {prefix: sled, every: 0}
"""

# A box that lands above a block, tilted: few of the faces beneath it stay in touch.
TILTED = """
mpm:
  dim: 3
  grid: {lower: "0,0,0", upper: "2,2,1.5", cells: "6,6,4"}
  materials: soil
  material_soil: {type: hencky, E: 1e6, nu: 0.3, density: 2000}
  bodies: block
  body_block: {region: box, lower: "0,0,0", upper: "2,2,1", points_per_cell: "2,2,2", material: soil}
  bcs: base
  bc_base: {region: box, lower: "0,0,0", upper: "2,2,0", components: "x,y,z"}
  boundaries: box
  boundary_box: {type: box, lower: "0.4,0.5,1.05", upper: "1.6,1.5,1.3", free: "z,rx,ry", load: "0,0,-1e4", moment: "300,-200,0",
                 method: augmented}
  time: {end: 0.5, step: 0.25}
  output: {prefix: tilted, every: 0}
"""

# A smooth disc that rests, and a body beside it that is blown out of the grid: the line tells of that.
BESIDE = """
mpm:
  dim: 2
  grid: {lower: "0,0", upper: "6,6", cells: "12,12"}
  materials: soil,jelly
  material_soil: {type: linear_elastic, E: 1e6, nu: 0, density: 1000}
  material_jelly: {type: linear_elastic, E: 1, nu: 0, density: 1}
  bodies: block,other
  body_block: {region: box, lower: "0,0", upper: "3,2", points_per_cell: "2,2", material: soil}
  body_other: {region: box, lower: "4.5,0", upper: "5.5,2", points_per_cell: "2,2", material: jelly}
  bcs: base
  bc_base: {region: box, lower: "0,0", upper: "6,0", components: "x,y"}
  boundaries: disc
  boundary_disc: {type: sphere, center: "1.5,2.9", radius: 1, free: "y,rz", load: "0,-100"}
  loads: wind
  load_wind: {type: gravity, value: "0,40"}
  time: {step: 1, step_min: 0.1}
  output: {prefix: beside, every: 0}
"""


def column(run, names):
    return np.array([run.results.column(name) for name in names])


def near_balance(test, label, run, body, load, moment, axes, turns):
    """Every step: the reaction on the material is the load, and its moment about the pivot the moment."""
    force = column(run, [f"reaction_{body}_{axis}" for axis in axes])
    about = column(run, [f"moment_{body}_{axis}" for axis in turns])
    factor = run.results.column("time")
    size = np.linalg.norm(load)
    test.check(f"{label}.force", np.max(np.abs(force - np.outer(load, factor))) / size, None, BALANCE)
    test.check(f"{label}.moment", np.max(np.abs(about - np.outer(moment, factor))) / size, None, BALANCE)


def lid(test):
    scene = test.folder() / "lid.yaml"
    scene.write_text(LID, encoding="utf-8")
    alone = test.run(scene, mpm_quiet=None)
    near_balance(test, "lid", alone, "lid", np.array([100.0, 50.0, -1e4]), np.array([300.0, -500.0, 100.0]), "xyz", "xyz")
    test.check("lid.sinks", alone.results.column("position_lid_z")[-1], None, 1.0)
    test.check("lid.newton", np.mean(alone.newton), None, 8)  # two long steps: 5 and 7
    # two of three rotations: the moment that holds the third is no part of their balance
    part = test.run(scene, mpm_quiet=None, mpm_boundary_lid_free="x,z,rx,rz", mpm_boundary_lid_load="500,0,-3e4",
                    mpm_boundary_lid_moment="3e3,0,2e3")
    for axis, moment in (("x", 3e3), ("z", 2e3)):
        off = part.results.column(f"moment_lid_{axis}") - moment * part.results.column("time")
        test.check(f"lid_in_part.{axis}", np.max(np.abs(off)) / 3e4, None, BALANCE)
    for ranks in (2, 3):
        other = test.run(scene, ranks=ranks, mpm_quiet=None)
        for name in ("position_lid_z", "rotation_lid_x", "rotation_lid_z", "depth_lid"):
            one, two = alone.results.column(name), other.results.column(name)
            test.check(f"lid_on_{ranks}.{name}", np.max(np.abs(one - two)) / np.max(np.abs(one)), None, 10 * RANKS)


def plate(test):
    """A block of no lateral strain under a rigid plate: its stiffness K = E B/H, and E B^3/(12 H) against rotation."""
    scene = test.folder() / "plate.yaml"
    scene.write_text(PLATE, encoding="utf-8")
    run = test.run(scene, mpm_quiet=None)
    eccentric = test.run(scene, mpm_quiet=None, mpm_boundary_plate_pivot="1.1,2", mpm_boundary_plate_moment=0)
    near_balance(test, "plate", run, "plate", np.array([-1e4]), np.array([1e3]), "y", "z")
    sink = 2.0 - run.results.column("position_plate_y")[-1]
    test.near("plate.sinks", sink, 1e4 * 2.0 / (1e7 * 2.0), relative=0.05)
    # a force at +0.1 m turns the other way round than a moment of as much about the middle
    for name in ("rotation_plate_z",):
        one, two = run.results.column(name)[-1], eccentric.results.column(name)[-1]
        test.near(f"plate.{name}", two, -one, relative=1e-3)
    test.check("plate.turns", run.results.column("rotation_plate_z")[-1], 1e-3, None)


def rubs(test):
    """A plate that touches as it is drawn, free to slide: friction holds it against the force along it."""
    scene = test.folder() / "plate.yaml"
    scene.write_text(PLATE, encoding="utf-8")
    run = test.run(scene, mpm_quiet=None, mpm_boundary_plate_free="x,y,rz", mpm_boundary_plate_friction=0.4,
                   mpm_boundary_plate_load="1e3,-10e3")
    near_balance(test, "rubs", run, "plate", np.array([1e3, -1e4]), np.array([1e3]), "xy", "z")
    test.check("rubs.newton", np.mean(run.newton), None, 8)


def augmented(test):
    """No depth is left, whatever the penalty and the solver; and a restart goes on with the pressures."""
    scene = test.folder() / "plate.yaml"
    scene.write_text(PLATE, encoding="utf-8")
    size = np.hypot(1.5, 0.25)
    places, options = [], {"mpm_quiet": None, "mpm_boundary_plate_method": "augmented"}
    for label, more in (("default", {"mpm_checkpoint_every": 1}), ("soft", {"mpm_boundary_plate_penalty": 0.5}),
                        ("amg", {"mpm_solver": "amg"}), ("ranks", {"ranks": 2})):
        run = test.run(scene, **options, **more)
        test.check(f"augmented_{label}.depth", np.max(run.results.column("depth_plate")) / size, None, 1e-8)
        near_balance(test, f"augmented_{label}", run, "plate", np.array([-1e4]), np.array([1e3]), "y", "z")
        places.append(run.results.column("position_plate_y")[-1])
        if label == "default":
            first = run
    test.check("augmented.places_differ", np.ptp(places), None, 3e-8)
    half = test.folder() / "half.h5"
    shutil.copy(f"{first.prefix}_checkpoint_000001.h5", half)
    again = test.run(scene, mpm_restart=half, mpm_output_prefix="again", **options)
    for name in ("position_plate_y", "rotation_plate_z"):
        test.near(f"augmented_restart.{name}", again.results.column(name)[-1], first.results.column(name)[-1])


def tilted(test):
    """Stiffness is raised no further than multigrid goes, and no depth is left."""
    scene = test.folder() / "tilted.yaml"
    scene.write_text(TILTED, encoding="utf-8")
    size, places = 0.5 * np.linalg.norm([1.2, 1.0, 0.25]), []
    for solver in ("direct", "amg"):
        run = test.run(scene, mpm_solver=solver, mpm_quiet=None)
        test.check(f"tilted_{solver}.depth", np.max(run.results.column("depth_box")) / size, None, 1e-8)
        test.check(f"tilted_{solver}.cuts", run.results.column("cuts").sum(), None, 0)
        places.append(column(run, ["position_box_z", "rotation_box_x", "rotation_box_y"])[-1])
    test.check("tilted.places_differ", np.ptp(places, axis=0).max(), None, 3e-8)


def sled(test):
    """Faces come in at one edge and go at the other, and still no depth is left; its sliding is over restarts and ranks the same."""
    scene = test.folder() / "sled.yaml"
    scene.write_text(SLED, encoding="utf-8")
    run = test.run(scene, mpm_quiet=None, mpm_checkpoint_every=9, mpm_checkpoint_keep=9)
    size = np.hypot(0.5, 0.25)
    test.check("sled.depth", np.max(run.results.column("depth_sled")) / size, None, 1e-8)
    test.check("sled.newton", np.mean(run.newton), None, 10)
    test.check("sled.cuts", run.results.column("cuts").sum(), None, 0)
    test.check("sled.balance", np.max(np.abs(run.results.column("reaction_sled_y")[5:] / 2e4 + 1)), None, BALANCE)
    half = test.folder() / "half.h5"
    shutil.copy(f"{run.prefix}_checkpoint_000009.h5", half)
    for label, ranks, more in (("ranks", 3, {}), ("restart", 2, {"mpm_restart": half, "mpm_output_prefix": "again"})):
        other = test.run(scene, ranks=ranks, mpm_quiet=None, **more)
        for name in ("position_sled_y", "reaction_sled_x"):
            test.near(f"sled_{label}.{name}", other.results.column(name)[-1], run.results.column(name)[-1], relative=RANKS)


def disc(test):
    path = example("two_supports")
    alone = test.run(path, mpm_quiet=None, mpm_output_every=0, mpm_checkpoint_every=1)
    test.check_example("two_supports", alone, "two_supports")
    place = column(alone, ["position_disc_x", "position_disc_y"])
    for ranks in (4,):
        other = test.run(path, ranks=ranks, mpm_quiet=None, mpm_output_every=0)
        test.check(f"disc_on_{ranks}.place", np.max(np.abs(column(other, ["position_disc_x", "position_disc_y"]) - place)),
                   None, 10 * RANKS)
    for name, options in SOLVERS.items():
        other = test.run(path, mpm_quiet=None, mpm_output_every=0, **options)
        test.check(f"disc_by_{name}.place", np.max(np.abs(column(other, ["position_disc_x", "position_disc_y"]) - place)),
                   None, SAME)
    half = test.folder() / "half.h5"
    shutil.copy(f"{alone.prefix}_checkpoint_000003.h5", half)
    for ranks in (1, 3):
        other = test.run(path, ranks=ranks, mpm_quiet=None, mpm_output_every=0, mpm_restart=half, mpm_output_prefix="again")
        for axis in "xy":
            name = f"position_disc_{axis}"
            test.near(f"disc_restart_on_{ranks}.{name}", other.results.column(name)[-1], alone.results.column(name)[-1],
                      absolute=0.0 if ranks == 1 else 1e-8)


def mass(test):
    """A plate let go on a column swings as a mass on a spring; above it a disc flies and turns as in a book; and the account of energy closes."""
    scene, options = Path(__file__).resolve().parent / "rigid_mass.yaml", {"mpm_quiet": None}
    names = ("position_plate_y", "position_disc_x", "position_disc_y", "rotation_disc_z")
    first = test.run(scene, mpm_checkpoint_every=50, mpm_checkpoint_keep=3, **options)
    for label, run in (("newmark", first), ("consistent", test.run(scene, mpm_time_mass="consistent", **options)),
                       ("alpha", test.run(scene, mpm_time_integrator="generalized_alpha", **options))):
        time, sunk = run.results.column("time"), 1.25 - run.results.column("position_plate_y")
        test.near(f"mass_{label}.depth", sunk.max(), 0.02, relative=2e-3)
        test.check(f"mass_{label}.back", abs(np.interp(2e-1 * np.pi * np.sqrt(0.1), time, sunk)), None, 5e-4 * 0.02)
        test.near(f"mass_{label}.force", np.max(-run.results.column("reaction_plate_y")), 2e4, relative=2e-3)
        test.near(f"mass_{label}.turn", run.results.column("rotation_disc_z")[-1], np.degrees(0.75 * 0.04), relative=1e-6)
        for name, value in (("x", 0.6), ("y", 4.8)):
            test.near(f"mass_{label}.disc_{name}", run.results.column(f"position_disc_{name}")[-1], value, relative=1e-12)
        test.check(f"mass_{label}.balance", np.max(np.abs(run.results.column("energy_balance"))), None, 0.5)
    for scheme in ("newmark", "generalized_alpha"):  # a moment that grows: an angle of moment t^3/(6 inertia)
        run = test.run(scene, mpm_time_integrator=scheme, mpm_time_step=0.01, mpm_boundary_disc_load_ramp="0:0,0.2:1",
                       mpm_boundary_disc_moment=300, **options)
        test.near(f"ramp_{scheme}.turn", run.results.column("rotation_disc_z")[-1], np.degrees(300.0 / 2.0 / 0.2 * 0.2**3 / 6.0), relative=2e-3)
        work = run.results.column("energy_external")
        test.check(f"ramp_{scheme}.balance", np.abs(run.results.column("energy_balance")[-1] / work[-1]), None, 2e-4)
    half = test.folder() / "half.h5"
    shutil.copy(f"{first.prefix}_checkpoint_000050.h5", half)
    for label, ranks, more in (("ranks", 3, {}), ("restart", 2, {"mpm_restart": half, "mpm_output_prefix": "again"})):
        run = test.run(scene, ranks=ranks, **options, **more)
        for name in names:
            test.near(f"mass_{label}.{name}", run.results.column(name)[-1], first.results.column(name)[-1], relative=1e-11)


def refusals(test):
    """Exit status 2 and one line that names the option; 3 where the run gives up."""
    path = example("two_supports")
    table = test.folder() / "table.csv"
    table.write_text("time,ux,uy,rz\n0,0,0,0\n1,0,0.1,5\n")
    for label, status, words, options in (
            ("component", 2, "free q", {"mpm_boundary_disc_free": "x,q"}),
            ("not_free", 2, "disc_load", {"mpm_boundary_disc_free": "x"}),
            ("moment", 2, "disc_moment", {"mpm_boundary_disc_moment": 5}),
            ("inside", 2, "behind it", {"mpm_boundary_disc_center": "1.2,1.5"}),
            ("no_inertia", 2, "disc_inertia: is missing", {"mpm_boundary_disc_free": "x,y,rz", "mpm_boundary_disc_mass": 2}),
            ("negative_mass", 2, "disc_mass -2", {"mpm_boundary_disc_mass": -2}),
            ("table_uy", 2, "disc_motion_table: column uy must be 0, for y is among", {"mpm_boundary_disc_motion_table": table}),
            ("table_rz", 2, "disc_motion_table: column rz must be 0, for rz is among",
             {"mpm_boundary_disc_free": "x,rz", "mpm_boundary_disc_load": "0,0", "mpm_boundary_disc_motion_table": table}),
            ("velocity", 2, "disc_velocity", {"mpm_boundary_disc_velocity": "1,0"}),
            ("adrift", 3, "nothing holds boundary disc against its load along y", {"mpm_boundary_disc_center": "5.5,2.5"}),
            ("hinge", 3, "boundary disc against its moment about z: it turns on",
             {"mpm_boundary_disc_free": "rz", "mpm_boundary_disc_load": "0,0", "mpm_boundary_disc_moment": 5,
              "mpm_boundary_disc_center": "5.5,2.5"}),
            ("turns", 3, "do not hold boundary disc against rotation about z",
             {"mpm_boundary_disc_free": "x,y,rz", "mpm_boundary_disc_moment": 500})):
        run = test.run(path, status=status, mpm_quiet=None, mpm_output_every=0, **options)
        lines = [line for line in run.errors.splitlines() if line.startswith("talus")]
        test.check(f"{label}.lines", len(lines), 1, 1)
        test.check(f"{label}.says", words in run.errors, 1, 1)


def beside(test):
    scene = test.folder() / "beside.yaml"
    scene.write_text(BESIDE, encoding="utf-8")
    for ranks in (1, 2):
        run = test.run(scene, ranks, status=3, mpm_quiet=None)
        said = "left the grid" in run.errors and "boundary disc" not in run.errors
        test.check(f"beside.{ranks}", int(said), 1, 1)


with Test() as check:
    disc(check)
    lid(check)
    plate(check)
    rubs(check)
    augmented(check)
    tilted(check)
    sled(check)
    mass(check)
    refusals(check)
    beside(check)
