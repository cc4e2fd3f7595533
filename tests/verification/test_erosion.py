#!/usr/bin/env python3
"""Flow over terrain that takes up its bed and leaves material: growth by shear and by distance, deposits, and balances.

Uniform flow on a slope with erosion by shear has an ordinary differential equation, growth by distance a closed form: mass
goes with exp(rate * path), Hungr (1995), doi:10.1139/t95-063. Mass, momentum and energy close with their columns.

Quick.
"""
import math
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import ENVIRONMENT, Test  # noqa: E402

ENVIRONMENT["TALUS_GDAL"] = "none"  # maps as text
G, DEGREES, DEPTH, MU, XI, DENSITY = 9.81, 20.0, 1.5, 0.1, 400.0, 1500.0
C, S = math.cos(math.radians(DEGREES)), math.sin(math.radians(DEGREES))
STRIP = """mpm:
  dim: 2
  physics: depth_averaged
  bed: "0,{bed!r},0"
  grid: {{lower: "0,0", upper: "2000,20", cells: "100,1"}}
  materials: mud
  material_mud: {{type: voellmy, mu: {mu}, xi: {xi}, density: {density}}}
  bodies: flow
  body_flow: {{region: box, lower: "100,0", upper: "1500,20", points_per_cell: "4,4", material: mud, depth: {depth!r}}}
  bcs: sides
  bc_sides: {{region: box, lower: "0,0", upper: "2000,20", components: "y"}}
  {blocks}
  time: {{integrator: explicit, cfl: {cfl}, end: 10}}
  output: {{every: 0, history: 1}}
  quiet: true
"""
SLIDE = """mpm:
  dim: 2
  physics: depth_averaged
  bed: "0,-0.4,0.1"
  grid: {lower: "0,0", upper: "300,120", cells: "75,30"}
  materials: mud
  material_mud: {type: voellmy, mu: 0.1, xi: 500, density: 1300}
  bodies: flow
  body_flow: {region: sphere, center: "60,60", radius: 24, points_per_cell: "3,3", material: mud, depth: 2}
  erosion: {depth: soil.asc, strength: 1500, rate: 3e-5, density: 1700}
  deposition: {speed: 3, rate: 0.05}
  maps: {every: 0}
  time: {integrator: explicit, end: 6}
  output: {every: 0, history: 1}
  quiet: true
"""
POND = """mpm:
  dim: 2
  physics: depth_averaged
  terrain: {{file: {bed}}}
  grid: {{lower: "120,40", upper: "156,76", cells: "12,12"}}
  materials: water
  material_water: {{type: coulomb, mu: 0, density: 1000}}
  bodies: pond
  body_pond: {{region: box, lower: "120,40", upper: "156,76", points_per_cell: "3,3", material: water, level: -38}}
  bcs: south,north,west,east
  bc_south: {{region: box, lower: "120,40", upper: "156,40", components: "y"}}
  bc_north: {{region: box, lower: "120,76", upper: "156,76", components: "y"}}
  bc_west: {{region: box, lower: "120,40", upper: "120,76", components: "x"}}
  bc_east: {{region: box, lower: "156,40", upper: "156,76", components: "x"}}
  time: {{integrator: explicit, end: 6}}
  output: {{every: 0}}
  quiet: true
"""


CHANNEL = """mpm:
  dim: 2
  physics: depth_averaged
  slope: {slope}
  bed: "0,{bed!r},0"
  grid: {{lower: "0,0", upper: "{length},4", cells: "{cells},2", outflow: true}}
  materials: water
  material_water: {{{law}, density: 1000}}
  bodies: river
  body_river: {{region: hydrograph, line: "0,0,0,4", table: q.csv, {inlet}, points_per_cell: "3,3", material: water}}
  bcs: south,north
  bc_south: {{region: box, lower: "0,0", upper: "{length},0", components: "y"}}
  bc_north: {{region: box, lower: "0,4", upper: "{length},4", components: "y"}}
  time: {{integrator: explicit, end: {end}}}
  output: {{every: 0, history: 1}}
  quiet: true
"""


def strip(test, blocks, cfl=0.4):
    """A long layer on a slope that starts at rest: the run, and depth, velocity and path along the bed of points in its middle."""
    path = test.folder() / "strip.yaml"
    path.write_text(STRIP.format(bed=-S / C, mu=MU, xi=XI, density=DENSITY, depth=DEPTH / C, blocks=blocks, cfl=cfl))
    run = test.run(path)
    state = run.results.state("last")
    middle = np.argsort(abs(state["position"][:, 0] - 800.0))[:64]
    return run, state["depth"].ravel()[middle], state["velocity"][middle, 0] / C, state["displacement"][middle, 0] / C


def uniform(rate, strength, ground, end=10.0, steps=2000):
    """Depth, vertical, and velocity along the bed by Runge and Kutta's method of order 4."""
    def change(y):
        stress = MU * DENSITY * G * y[0] * C * C + DENSITY * G * y[1] ** 2 / XI
        growth = ground / DENSITY * rate * max(stress - strength, 0.0) / C
        return np.array([growth, G * S - stress / (C * DENSITY * y[0]) - growth * y[1] / y[0]])
    y, dt = np.array([DEPTH / C, 0.0]), end / steps
    for _ in range(steps):
        a = change(y)
        b = change(y + dt / 2 * a)
        c = change(y + dt / 2 * b)
        y = y + dt / 6 * (a + 2 * b + 2 * c + change(y + dt * c))
    return y


def balances(test, label, run, energy):
    """What the columns of the history leave of mass, momentum and energy, since the first row."""
    history = run.results.history
    change = {name: history[name][-1] - history[name][0] for name in history}
    test.check(f"{label}.mass", abs(change["mass"] - change["mass_in"] + change["mass_out"] - change["mass_eroded"]
                                    + change["mass_deposited"]) / history["mass"].max(), 0, 1e-12)
    scale = max(abs(history[f"impulse_friction_{a}"][-1]) for a in "xy")
    for a in "xy":
        left = change[f"momentum_{a}"] - sum(change[f"impulse_{part}_{a}"] for part in ("bed", "friction", "carried"))
        test.check(f"{label}.momentum_{a}", abs(left) / scale, 0, 1e-12)
    test.check(f"{label}.energy", abs(change["energy_balance"]) / change["energy_external"], 0, energy)
    test.check(f"{label}.energy_left", abs(change["energy_balance"] + change["energy_transfer"]) / change["energy_external"], 0, 1e-3)


def slide(test):
    """A heap on a slope with erosion by maps and deposits: ranks, restart, maps, balances, and a pond on the bed that is left."""
    folder = test.folder()
    rows = [" ".join(f"{max(0.3 * math.sin(0.02 * x + 0.03 * y), 0.0):.6f}" for x in range(-6, 307, 6)) for y in range(126, -7, -6)]
    (folder / "soil.asc").write_text(f"ncols 53\nnrows 23\nxllcenter -6\nyllcenter -6\ncellsize 6\n" + "\n".join(rows) + "\n")
    (folder / "slide.yaml").write_text(SLIDE)
    run = test.run(folder / "slide.yaml", mpm_checkpoint_every=8, mpm_checkpoint_keep=9)
    balances(test, "slide", run, 1e-3)
    history, state = run.results.history, run.results.state("last")
    test.check("slide.eroded", history["mass_eroded"][-1] / history["mass"][0], 0.02, 1.0)
    test.check("slide.deposited", history["mass_deposited"][-1] / history["mass"][0], 1e-4, 1.0)
    again = [test.run(folder / "slide.yaml", ranks=3)]
    again.append(test.run(folder / "slide.yaml", mpm_restart=sorted(run.folder.glob("*checkpoint_*.h5"))[1]))
    for label, other in zip(("ranks", "restart"), again):
        one, two = state, other.results.state("last")
        a, b = (s["id"].ravel().argsort() for s in (one, two))
        for name in ("position", "velocity", "depth", "bed"):
            test.check(f"slide.{label}.{name}", float(abs(one[name][a] - two[name][b]).max() / abs(one[name]).max()), 0, 1e-10)
        for name in ("mass_eroded", "mass_deposited", "impulse_friction_x", "energy_exchange", "energy_transfer"):
            test.near(f"slide.{label}.{name}", float(other.results.history[name][-1]), float(history[name][-1]), relative=1e-11)
    bed, gone = (Path(f"{run.prefix}_peak_{name}.asc") for name in ("bed", "bed_change"))
    values = np.loadtxt(gone, skiprows=6)
    test.check("slide.lowest", float(values.min()), -0.3, -0.05)
    test.check("slide.highest", float(values.max()), 1e-3, 0.3)
    (folder / "pond.yaml").write_text(POND.format(bed=bed))
    still = test.run(folder / "pond.yaml").results.state("last")["velocity"]
    test.check("slide.pond", float(abs(still).max()) / math.sqrt(G), 0, 1e-12)


def channel(test, inlet, table, end, law="type: manning, n: 0.03", slope="vertical", bed=-0.02, length=60):
    """Scene of a channel into which water comes from the left."""
    folder = test.folder()
    (folder / "q.csv").write_text("time,discharge\n" + table)
    (folder / "channel.yaml").write_text(CHANNEL.format(slope=slope, bed=bed, law=law, inlet=inlet, end=end, length=length, cells=length // 2))
    return folder / "channel.yaml"


def near(state, x):
    """Mean depth and velocity of the points about a place."""
    there = abs(state["position"][:, 0] - x) < 3.0
    return float(state["depth"].ravel()[there].mean()), float(state["velocity"][there, 0].mean())


def inflow(test):
    """Steady uniform flow behind an inlet, by a given depth and by a velocity that is not that of the flow; a flood."""
    q = 2.0
    h = (q * 0.03 / math.sqrt(0.02)) ** 0.6
    run = test.run(channel(test, f"speed: {q / h!r}", "0,8\n100,8\n", 40))
    for name, value, exact in zip(("depth", "speed"), near(run.results.state("last"), 30.0), (h, q / h)):
        test.near(f"manning.{name}", value, exact, relative=1e-4)
    balances(test, "manning", run, 5e-3)  # flow falls off at the open end within a cell
    sine = 0.15 / math.hypot(1.0, 0.15)
    h = (q * q / (300.0 * (sine - 0.05 * sine / 0.15))) ** (1 / 3)
    c = sine / 0.15
    run = test.run(channel(test, f"flow_depth: {0.8 * h / c!r}", "0,8\n100,8\n", 25, "type: voellmy, mu: 0.05, xi: 300", "normal", -0.15, 80))
    for name, value, exact in zip(("depth", "speed"), near(run.results.state("last"), 50.0), (h / c, q / h * c)):
        test.near(f"voellmy.{name}", value, exact, relative=5e-3)
    scene = channel(test, "flow_depth: 0.4", "0,0\n4,12\n16,0\n", 18)
    scene.write_text(scene.read_text().replace('line: "0,0,0,4"', "file: line.geojson"))
    (scene.parent / "line.geojson").write_text('{"type": "LineString", "coordinates": [[0, 0], [0, 4]]}')
    run = test.run(scene, mpm_checkpoint_every=30, mpm_checkpoint_keep=9)
    history, state = run.results.history, run.results.state("last")
    test.near("flood.mass", float(history["mass_in"][-1]), 96000.0, relative=1e-12)
    balances(test, "flood", run, 1e-2)  # with a bore
    for label, other in (("ranks", test.run(scene, ranks=3)), ("restart", test.run(scene, mpm_restart=sorted(run.folder.glob("*checkpoint_*.h5"))[0]))):
        last = other.results.state("last")
        a, b = (s["id"].ravel().argsort() for s in (state, last))
        for name in ("position", "velocity", "depth"):
            test.check(f"flood.{label}.{name}", float(abs(state[name][a] - last[name][b]).max()), 0, 1e-10)
        test.near(f"flood.{label}.mass_in", float(other.results.history["mass_in"][-1]), float(history["mass_in"][-1]), relative=1e-13)
    for label, words, options in (("both", "one of them must be given", {"mpm_body_river_speed": "2"}),
                                  ("line", "-mpm_body_river_file: one of them must be given", {"mpm_body_river_line": "0,0,0,5"}),
                                  ("table", "cannot be read", {"mpm_body_river_table": scene.parent / "nowhere.csv"}),
                                  ("rate", "-mpm_erosion_rate", {"mpm_erosion_depth": "1"})):
        wrong = test.run(scene, status=2, **options)
        test.check(f"wrong.{label}", words in wrong.errors and wrong.errors.count("\n") == 1, 1, 1)
        if words not in wrong.errors:
            print(wrong.errors)


def main():
    with Test() as test:
        run, depth, speed, _ = strip(test, "erosion: {rate: 2e-5, strength: 2000, density: 1800}", 0.05)
        exact = uniform(2e-5, 2000.0, 1800.0)
        test.near("shear.depth", float(np.median(depth)), exact[0], relative=3e-3)
        test.near("shear.speed", float(np.median(speed)), exact[1], relative=5e-3)
        balances(test, "shear", run, 1e-3)
        _, _, speed, _ = strip(test, "forests: wood\n  forest_wood: {stems: 0.2, diameter: 0.3, drag: 1.1}", 0.1)
        drive, resist = G * (S - MU * C), G / (XI * DEPTH) + 0.5 * 1.1 * 0.2 * 0.3 * C ** 3  # of the square of the speed along the bed
        test.near("forest.speed", float(np.median(speed)), math.sqrt(drive / resist) * math.tanh(10 * math.sqrt(drive * resist)), relative=1e-3)
        run, depth, _, path = strip(test, "erosion: {by: distance, rate: 2e-3}")
        test.check("distance.depth", float(abs(depth / (DEPTH / C * np.exp(2e-3 * path)) - 1.0).max()), 0, 1e-12)
        balances(test, "distance", run, 1e-3)
        _, depth, _, _ = strip(test, "erosion: {by: distance, rate: 2e-3, depth: 0.2}")
        test.near("distance.least", float(np.median(depth)), DEPTH / C + 0.2, relative=1e-12)
        run, _, _, _ = strip(test, "deposition: {speed: 100, rate: 0.2}")
        test.check("deposited.points", len(run.results.state("last")["depth"]), 0, 0)
        test.near("deposited.mass", float(run.results.history["mass_deposited"][-1]), DENSITY * 1400 * 20 * DEPTH / C, relative=1e-11)
        slide(test)
        inflow(test)


if __name__ == "__main__":
    main()
