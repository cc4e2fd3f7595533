#!/usr/bin/env python3
"""Columns of a depth-averaged flow become points in three dimensions, and columns again.

Mass, volume, momentum and centre of mass are the columns'; a column's points fill it. The seed of numbers is the volume
of depth 10 - sin 2x cos y over a square of 5 m, 250.88176517 m3. A window leaves mass outside, and with inflow columns
come in at the times of later states; ranks and a restart change nothing.

Quick.
"""
import json
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import Test, difference  # noqa: E402

WAVES = """mpm:
  dim: {dim}
  bed: "0,0.1,-0.2"
  grid: {{lower: "{lower}", upper: "{upper}", cells: "{cells}"}}
  materials: mud
  material_mud: {{{material}}}
  bodies: flow
  body_flow: {{region: columns, depth: depth.asc, velocity_x: 2.001, columns_per_cell: "4,4", material: mud{more}}}
  loads: weight
  load_weight: {{type: gravity, value: "0,0,-9.81", ramp: "0:1"}}
  time: {{integrator: explicit, end: 1e-3}}
  output: {{every: 1}}
  quiet: true
"""
SLIDE = """mpm:
  dim: 2
  physics: depth_averaged
  slope: vertical
  bed: "0,-0.5,0.1"
  grid: {lower: "0,0", upper: "400,160", cells: "50,20"}
  materials: mud
  material_mud: {type: voellmy, mu: 0.155, xi: 1750, density: 1300}
  bodies: flow
  body_flow: {region: sphere, center: "60,80", radius: 20, points_per_cell: "3,3", material: mud, depth: 2}
  time: {integrator: explicit, end: 5}
  output: {every: 2}
  quiet: true
"""
ON = """mpm:
  dim: 3
  grid: {{lower: "0,0,-180", upper: "240,160,40", cells: "24,16,22"}}
  materials: mud
  material_mud: {{type: newtonian, density: 1300, sound_speed: 50}}
  bodies: flow
  body_flow: {{region: columns, file: {file}, step: {step}, spacing: 0.5, material: mud}}
  loads: weight
  load_weight: {{type: gravity, value: "0,0,-9.81", ramp: "0:1"}}
  boundaries: ground
  boundary_ground: {{type: terrain, friction: 0.2}}
  bed: "0,-0.5,0.1"
  time: {{integrator: explicit, end: {end}}}
  output: {{every: 1000}}
  quiet: true
"""
BACK = """mpm:
  dim: 2
  physics: depth_averaged
  bed: "0,-0.5,0.1"
  grid: {{lower: "0,0", upper: "400,160", cells: "50,20"}}
  materials: mud
  material_mud: {{type: voellmy, mu: 0.155, xi: 1750, density: 1300}}
  bodies: flow
  body_flow: {{region: depth, file: {file}, step: 0, columns_per_cell: "{per}", material: mud}}
  time: {{integrator: explicit, end: 0.1}}
  output: {{every: 1000}}
  quiet: true
"""


def waves(test, **options):
    """Points of columns from a map of depth, in the first state."""
    folder = test.folder()
    xs = np.arange(-0.0125, 5.03, 0.025)
    depth = 10 - np.outer(np.cos(xs), np.sin(2 * xs))
    with open(folder / "depth.asc", "w", encoding="utf-8") as file:
        file.write(f"ncols {len(xs)}\nnrows {len(xs)}\nxllcenter {xs[0]!r}\nyllcenter {xs[0]!r}\ncellsize 0.025\n")
        np.savetxt(file, depth[::-1], fmt="%.17g")
    path = folder / "waves.yaml"
    path.write_text(WAVES.format(dim=3, lower="0,0,-2", upper="6,5,14", cells="12,10,16", more=', spacing: 0.9, lower: "0,0", upper: "5,5"',
                                 material="type: newtonian, density: 1000, sound_speed: 100"))
    run = test.run(path, **options)
    return run, run.results.state("first")


def check_waves(test):
    run, state = waves(test)
    mass, volume = state["mass"].ravel(), state["volume"].ravel()
    x, half = state["position"], state["half_length"]
    test.near("waves.volume", float(volume.sum()), 250.88176517, relative=2e-4)
    test.near("waves.momentum", float((mass * state["velocity"][:, 0]).sum()), 2.001 * float(mass.sum()), relative=1e-13)
    test.check("waves.rise", float(abs(state["velocity"][:, 2] - 0.1 * 2.001).max()), 0, 1e-14)
    keys, column = np.unique(np.round(x[:, :2], 6), axis=0, return_inverse=True)
    column = column.ravel()
    total = np.bincount(column, mass)
    count = np.bincount(column)
    centre = np.bincount(column, mass * x[:, 2]) / total
    bed = 0.1 * keys[:, 0] - 0.2 * keys[:, 1]
    deep = np.bincount(column, volume) / (5 / 40) ** 2
    test.check("waves.columns", len(keys), 1600, 1600)
    test.check("waves.count", int(abs(count - np.maximum(1, np.round(deep / 0.9))).max()), 0, 0)
    test.check("waves.centre", float(abs(centre - bed - deep / 2).max()), 0, 1e-12)
    second = np.bincount(column, mass * (x[:, 2] - centre[column]) ** 2) / total / deep ** 2
    test.check("waves.second", float(abs(second - (1 - 1 / count ** 2) / 12).max()), 0, 1e-12)
    test.check("waves.fill", float(abs(volume - 8 * half.prod(axis=1)).max()), 0, 1e-12 + 1e-4)
    above = bed[column] + deep[column] - x[:, 2]
    test.check("waves.stress", difference(1000 * 9.81 * above / (1 + 0.1 ** 2 + 0.2 ** 2), -state["stress"][:, 2]), 0, 1e-6)
    other = waves(test, ranks=3, mpm_load_weight_value="0,0,-1.62")[1]
    test.check("waves.ranks", difference(x, other["position"]), 0, 1e-14)
    test.check("waves.gravity", difference(1.62 / 9.81 * state["stress"], other["stress"]), 0, 1e-6)
    summary = json.loads(Path(run.prefix + "_summary.json").read_text(encoding="utf-8"))["handover"]["flow"]
    test.near("waves.summary", summary["mass"], float(mass.sum()), relative=1e-13)
    test.check("waves.outside", summary["mass_outside"] / summary["mass"], 0.1, 0.3)


def there_and_back(test, flow):
    """A state of columns, its points, and their columns, which are the first."""
    folder = test.folder()
    for name, step, per in (("start", 0, "3,3"), ("later", "latest", "24,24")):
        (folder / f"{name}.yaml").write_text(ON.format(file=flow.prefix + ".h5", step=step, end=1e-3))
        up = test.run(folder / f"{name}.yaml")
        (folder / "back.yaml").write_text(BACK.format(file=up.prefix + ".h5", per=per))
        down = test.run(folder / "back.yaml", ranks=3).results.state("first")
        first, points = flow.results.state("first" if step == 0 else "last"), up.results.state("first")
        for state, label in ((points, "points"), (down, "columns")):
            mass = state["mass"].ravel()
            test.near(f"{name}.{label}.mass", float(mass.sum()), float(first["mass"].sum()), relative=1e-13)
            for axis in (0, 1):
                reference = float((first["mass"].ravel() * first["velocity"][:, axis]).sum())
                test.near(f"{name}.{label}.momentum{axis}", float((mass * state["velocity"][:, axis]).sum()), reference,
                          relative=1e-12, absolute=1e-9)
        order, back = (np.lexsort(np.round(state["position"], 6).T) for state in (first, down))
        test.check(f"{name}.places", difference(first["position"][order], down["position"][back]), 0, 1e-12)
        test.check(f"{name}.depth", difference(first["depth"].ravel()[order], down["depth"].ravel()[back]), 0, 1e-10)
        gradient = up.results.state("first")
        test.check(f"{name}.rise", float(abs(gradient["velocity"] @ np.array([-0.5, 0.1, -1.0])).max()), 0, 1e-12)


def window(test, flow):
    """Half of a flow at first, and the rest as it comes in: mass, ranks, restart."""
    folder = test.folder()
    path = folder / "window.yaml"
    path.write_text(ON.format(file=flow.prefix + ".h5", step=0, end=5.2))
    options = {"mpm_body_flow_lower": "60,0", "mpm_body_flow_upper": "240,160", "mpm_body_flow_spacing": 1}
    whole = float(flow.results.state("first")["mass"].sum())
    x = flow.results.state("first")["position"][:, 0]
    runs = {}
    for label, inflow, ranks in (("closed", "false", 1), ("open", "true", 1), ("ranks", "true", 3)):
        runs[label] = test.run(path, ranks=ranks, mpm_body_flow_inflow=inflow, mpm_checkpoint_every=10, **options)
    told = {label: json.loads(Path(run.prefix + "_summary.json").read_text(encoding="utf-8"))["handover"]["flow"]
            for label, run in runs.items()}
    outside = float(flow.results.state("first")["mass"].ravel()[x < 60].sum())
    for label, account in told.items():
        test.near(f"window.{label}.outside", account["mass_outside"], outside, relative=1e-12)
        test.near(f"window.{label}.whole", account["mass"] + account["mass_outside"], whole, relative=1e-12)
    first, last = (runs["open"].results.state(step) for step in ("first", "last"))
    test.near("window.first", float(first["mass"].sum()), told["open"]["mass"], relative=1e-12)
    test.near("window.last", float(last["mass"].sum()), told["open"]["mass"] + told["open"]["mass_later"], relative=1e-12)
    test.near("window.later", told["open"]["mass_later"], outside, relative=1e-12)
    test.near("window.closed.last", float(runs["closed"].results.state("last")["mass"].sum()), told["closed"]["mass"],
              relative=1e-12)
    alike = runs["ranks"].results.state("last")
    order, other = (np.lexsort(np.round(state["position"], 5).T) for state in (last, alike))
    test.check("window.ranks", difference(last["position"][order], alike["position"][other]), 0, 1e-8)
    checkpoint = sorted(runs["open"].folder.glob("*checkpoint_*.h5"))[0]
    again = test.run(path, mpm_body_flow_inflow="true", mpm_restart=checkpoint, **options).results.state("last")
    test.check("window.restart", difference(last["position"], again["position"]), 0, 1e-12)


def refuse(test, path, label, words, **options):
    run = test.run(path, status=2, **options)
    test.check(f"{label}.line", words in run.errors and run.errors.count("\n") == 1, 1, 1)
    test.check(f"{label}.files", len(run.files), 0, 0)


with Test() as test:
    check_waves(test)
    path = test.folder() / "slide.yaml"
    path.write_text(SLIDE)
    flow = test.run(path)
    there_and_back(test, flow)
    window(test, flow)

    path = test.folder() / "on.yaml"
    path.write_text(ON.format(file=flow.prefix + ".h5", step=0, end=1e-3))
    refuse(test, path, "bed", "its bed differs", mpm_bed="0.2,-0.5,0.1")
    refuse(test, path, "step", "has no step 77", mpm_body_flow_step=77)
    refuse(test, path, "spacing", "must be > 0", mpm_body_flow_spacing=0)
    refuse(test, path, "window", "must be > ", mpm_body_flow_lower="50,50", mpm_body_flow_upper="50,60")
    refuse(test, path, "empty", "there is no point in it", mpm_body_flow_lower="200,150", mpm_body_flow_upper="210,160")
    refuse(test, path, "inflow", "has no state after step", mpm_body_flow_inflow="true", mpm_body_flow_step="latest")
