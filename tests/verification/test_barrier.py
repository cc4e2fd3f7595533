#!/usr/bin/env python3
"""Flow in three dimensions over a bed and against a wall: contact of material that flows, in explicit steps.

Water runs down a slope and over its foot: no point is lost or goes through the bed, and contact adds no energy. In a
tank whose bed and wall cut the cells the wall carries rho g h^2/2. Friction is by a law of the bed, too. Ranks agree. A layer
stops by its viscosity, and splashes gain no energy.

Quick.
"""
import shutil
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import EXAMPLES, Test, call, difference  # noqa: E402
from maps import write_ascii  # noqa: E402

G = 9.81
SLIDE = """mpm:
  dim: 3
  grid: {lower: "0,0,5.5", upper: "24,0.5,10", cells: "48,1,9"}
  materials: water
  material_water: {type: newtonian, density: 1000, sound_speed: 60}
  bodies: water
  body_water: {region: columns, depth: depth.asc, columns_per_cell: "4,4", spacing: 0.25, material: water}
  boundaries: ground
  boundary_ground: {type: terrain}
  terrain: {file: bed.asc}
  bcs: sides
  bc_sides: {region: all, components: "y"}
  loads: weight
  load_weight: {type: gravity, value: "0,0,-9.81", ramp: "0:1"}
  time: {integrator: explicit, cfl: 0.5, end: 2.2}
  output: {every: 10000}
  quiet: true
"""
TANK = """mpm:
  dim: 3
  bed: "0.1,0,0"
  grid: {lower: "0,0,0", upper: "2.5,0.25,1.5", cells: "10,1,6"}
  materials: water
  material_water: {type: newtonian, density: 1000, sound_speed: 60}
  bodies: water
  body_water: {region: columns, depth: depth.asc, columns_per_cell: "2,2", spacing: 0.125, material: water}
  boundaries: ground,wall
  boundary_ground: {type: terrain}
  boundary_wall: {type: box, lower: "2.03,-1,-1", upper: "4,2,4", face: true}
  bcs: sides,left
  bc_sides: {region: all, components: "y"}
  bc_left: {region: box, lower: "0,0,0", upper: "0,1,2", components: "x"}
  loads: weight
  load_weight: {type: gravity, value: "0,0,-9.81", ramp: "0:1"}
  time: {integrator: explicit, cfl: 0.5, end: 1.5}
  output: {every: 10000}
  quiet: true
"""

BRAKE = """mpm:
  dim: 3
  bed: "0.1,0,0"
  grid: {{lower: "0,0,0", upper: "12,0.5,2", cells: "24,1,4"}}
  materials: water
  material_water: {{type: newtonian, density: 1000, sound_speed: 60}}{mud}
  bodies: water
  body_water: {{region: columns, depth: 0.25, velocity_x: 5, columns_per_cell: "2,2", spacing: 0.25, upper: "10,0.5", material: water}}
  boundaries: ground
  boundary_ground: {{type: terrain, {friction}}}
  bcs: sides
  bc_sides: {{region: all, components: "y"}}
  loads: weight
  load_weight: {{type: gravity, value: "0,0,-9.81", ramp: "0:1"}}
  time: {{integrator: {integrator}, end: {end}}}
  output: {{every: 10000}}
  quiet: true
"""
SHEAR = """mpm:
  dim: 2
  grid: {lower: "0,0", upper: "0.25,1.25", cells: "4,20"}
  materials: oil
  material_oil: {type: newtonian, density: 1000, sound_speed: 10, viscosity: 50}
  bodies: oil
  body_oil: {region: box, lower: "0.0625,0", upper: "0.1875,1", points_per_cell: "2,2", material: oil, velocity: "0.01,0"}
  bcs: level,floor
  bc_level: {region: all, components: "y"}
  bc_floor: {region: box, lower: "0,0", upper: "1,0", components: "x"}
  stabilization: {fbar: true}
  time: {integrator: explicit, end: 2}
  output: {every: 100000}
  quiet: true
"""
MUD = "\n  material_mud: {{type: {}, density: 1000}}"


def bed(x):
    return np.maximum(10 - x / 3, 10 - 10 / 3)


def slide(test):
    """Over a kink of the bed, in cells of four times the depth there: the energy falls, and no point leaves the bed."""
    folder = test.folder()
    (folder / "slide.yaml").write_text(SLIDE)
    x, y = np.arange(-0.5, 24.3, 0.25), np.arange(-0.5, 1.1, 0.25)
    write_ascii(folder / "bed.asc", x, y, np.tile(bed(x), (len(y), 1)))
    x, y = np.arange(0.03125, 12.5, 0.0625), np.arange(0.03125, 0.5, 0.0625)
    write_ascii(folder / "depth.asc", x, y, np.tile(np.where((x > 1.5) & (x < 5), 9.5 - bed(x), -1.0), (len(y), 1)))
    run = test.run(folder / "slide.yaml")
    state, history = run.results.state("last"), run.results.column
    mass, x = state["mass"].ravel(), state["position"]
    low = x[:, 2] - bed(x[:, 0])
    test.check("slide.points", len(mass), 272, 272)
    test.check("slide.depth", -float(low.min()), None, 0.01)
    test.check("slide.height", float(low.max()), 0, 0.3)
    test.check("slide.energy", float(history("energy_balance").max()) / float(history("energy_external").max()), None, 1e-3)
    test.check("slide.taken", -float(history("energy_dissipated").min()) / float(history("energy_external").max()), None, 3e-3)
    test.check("slide.speed", float(mass @ state["velocity"][:, 0]) / mass.sum(), 5.4, 5.8)
    momentum, force, dt = history("momentum_x"), history("reaction_ground_x"), history("dt")
    test.near("slide.momentum", float((force * dt)[1:].sum()), float(momentum[-1] - momentum[0]), relative=5e-3)
    three = test.run(folder / "slide.yaml", ranks=3, mpm_time_end=0.3).results.state("last")
    one = test.run(folder / "slide.yaml", mpm_time_end=0.3).results.state("last")
    test.check("slide.ranks", difference(one["position"], three["position"]), 0, 1e-9)


def tank(test):
    """Water at rest, to both sides: its depth is its volume over the floor."""
    folder = test.folder()
    (folder / "tank.yaml").write_text(TANK)
    x, y = np.arange(-0.03125, 3.0, 0.0625), np.arange(-0.03125, 0.4, 0.0625)
    write_ascii(folder / "depth.asc", x, y, np.tile(np.where(x < 2.03, 1.0, -9.0), (len(y), 1)))
    run = test.run(folder / "tank.yaml")
    depth = 2.0 / 2.03
    late = run.results.column("time") > 0.5
    dt = run.results.column("dt")[late]
    mean = {name: float((run.results.column(name)[late] * dt).sum() / dt.sum()) for name in ("reaction_wall_x", "reaction_ground_z")}
    test.near("tank.wall", mean["reaction_wall_x"], -0.5 * 1000 * G * (2.0 / 2.03) ** 2 * 0.25, relative=0.02)
    face = {name: float((run.results.column(name)[late] * dt).sum() / dt.sum()) for name in ("pressure_max_wall", "runup_wall")}
    test.near("tank.pressure", face["pressure_max_wall"], 1000 * G * (depth - 0.075), relative=0.05)  # middle of the lowest patch
    test.near("tank.runup", face["runup_wall"], depth, relative=0.03)
    test.check("tank.unasked", "runup_ground" in run.results.history, 0, 0)
    one, three = (test.run(folder / "tank.yaml", ranks=ranks, mpm_time_end=0.1).results.column for ranks in (1, 3))
    for name in ("pressure_max_wall", "runup_wall"):
        test.check(f"tank.ranks.{name}", difference(one(name), three(name)), 0, 1e-9)
    test.near("tank.floor", mean["reaction_ground_z"], 1000 * G * 2.0 * 0.25, relative=0.01)


def brake(test):
    """A thin layer on its bed: Coulomb's law of the bed is friction, and Voellmy's has its turbulent part."""
    folder = test.folder()

    def run(label, friction, mud="", end=0.1, integrator="explicit, cfl: 0.5", **options):
        (folder / f"{label}.yaml").write_text(BRAKE.format(friction=friction, mud=MUD.format(mud) if mud else "", end=end,
                                                           integrator=integrator))
        return test.run(folder / f"{label}.yaml", **options)

    coulomb = run("coulomb", "basal: mud", "coulomb, mu: 0.2").results.column("momentum_x")
    friction = run("friction", "friction: 0.2").results.column("momentum_x")
    test.check("brake.coulomb", difference(coulomb, friction), 0, 1e-12)
    voellmy = run("voellmy", "basal: mud", "voellmy, mu: 0.2, xi: 200", end=0.02).results
    force = -(voellmy.column("reaction_ground_x") * voellmy.column("dt")).sum() / voellmy.column("dt").sum()
    speed = float(voellmy.column("momentum_x").mean()) / (1000 * 0.25 * 5)
    test.near("brake.voellmy", float(force), 1000 * G * 5 * (0.2 * 0.25 + speed**2 / 200), relative=0.05)
    for label, friction, words, integrator in (
            ("both", "basal: mud, friction: 0.2", "not with friction or adhesion", "explicit, cfl: 0.5"),
            ("viscosity", "basal: mud}\n  terrain: {viscosity: 10", "is an option of -mpm_physics depth_averaged", "explicit, cfl: 0.5"),
            ("implicit", "basal: mud", "needs explicit steps", "newmark, step: 0.1")):
        refused = run(label, friction, "coulomb, mu: 0.2", integrator=integrator, status=2)
        test.check(f"{label}.line", words in refused.errors and refused.errors.count("\n") == 1, 1, 1)
        test.check(f"{label}.files", len(refused.files), 0, 0)


def shear(test):
    """A layer that stops on its floor by viscosity (Stokes), with F-bar and with each update of the stress."""
    folder = test.folder()
    (folder / "shear.yaml").write_text(SHEAR)
    odd = (2 * np.arange(50) + 1) * np.pi / 2
    share = float((2 / odd**2 * np.exp(-(odd**2) * 0.05 * 2)).sum())
    for update in ("musl", "usf"):
        history = test.run(folder / "shear.yaml", mpm_time_update=update).results.column
        test.near(f"shear.{update}", float(history("momentum_x")[-1]), 1000 * 0.125 * 0.01 * share, relative=0.01)
        test.check(f"shear.{update}.energy", abs(float(history("energy_balance")[-1])) / 6.25e-3, None, 0.05)


def example_runs(test, name, scenes):
    """An example's depth-averaged run, and the scenes in 3D after it: options by file; `on` is the body that goes on."""
    folder = test.folder()
    test.check(f"{name}.made", call([sys.executable, EXAMPLES / name / "make.py", folder / "out"], folder).returncode, 0, 0)
    flow = None
    for scene, options in scenes.items():
        shutil.copy(EXAMPLES / name / f"{scene}.yaml", folder)
        body = options.pop("on", None)
        if body:
            options[f"mpm_body_{body}_file"] = flow.prefix + ".h5"
        run = test.run(folder / f"{scene}.yaml", **options)
        flow = flow or run
        test.check_example(f"{name}.{scene}", run, name)
        if body:
            gain = np.maximum(np.diff(run.results.column("energy_balance")), 0).sum()
            test.check(f"{name}.{scene}.gain", float(gain / run.results.column("energy_kinetic").max()), None, 0.02)


if __name__ == "__main__":
    with Test() as test:
        slide(test)
        tank(test)
        brake(test)
        shear(test)
        example_runs(test, "sliding_to_wall", {"case": {}, "wall": {"on": "water"}, "pond": {}})
        example_runs(test, "mudflow_barrier", {"case": {}, "barrier": {"on": "flow", "mpm_time_end": 6}})
