#!/usr/bin/env python3
"""Forces and moments in cuts against equilibrium, and stress along lines.

A cantilever bends far: V is its load and M the load times its arm in the deformed state, at any plane, with every shape,
with and without ghost penalty and F-bar. In 3D a plane at any angle carries what loads the end, in total and shared by
two bodies, on any number of ranks. Along a line a linear stress comes out as it is, and the pressure under a strip adds
up to its load. In a light bar from which a weight swings N is the reaction, with each implicit method. A run that goes on from a checkpoint leaves the same files; a scene pays for nothing that it does not ask for.
"""
import sys
from pathlib import Path

import h5py
import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import ROOT, Test, call, difference, example  # noqa: E402

BRACKET = ROOT / "tests" / "verification" / "sections.yaml"
LOAD, TIP_X = 10e3, 10.0 - 0.25 / 12.0  # N/m at a tenth of the run, m
TIP = np.array([1e3, -4e3, 2e3])  # N
SWING = """
mpm:
  dim: 2
  grid: {lower: "-0.0625,0", upper: "1.5,0.0625", cells: "25,1"}
  materials: spring,lead
  material_spring: {type: hencky, density: 1e-6, E: 1e6, nu: 0.3}
  material_lead: {type: hencky, density: 1000, E: 1e7, nu: 0.3}
  bodies: bar,weight
  body_bar: {region: box, lower: "0,0", upper: "0.5,0.0625", points_per_cell: "2,2", material: spring}
  body_weight: {region: box, lower: "0.5,0", upper: "1,0.0625", points_per_cell: "2,2", material: lead}
  bcs: root,roll
  bc_root: {region: box, lower: "0,0", upper: "0,0.0625", components: "x"}
  bc_roll: {region: box, lower: "-0.0625,0", upper: "1.5,0.0625", components: "y"}
  loads: end
  load_end: {type: force, region: box, lower: "0.9,0", upper: "1,0.0625", value: "1500,0", ramp: "0:0,0.02:1,0.04:-0.5"}
  sections: root
  section_root: {point: "0.2,0", normal: "1,0"}
  time: {end: 0.1, step: 0.004}
  output: {prefix: bar, every: 0}
"""
THROWN = """
mpm:
  dim: 2
  grid: {lower: "0,0", upper: "3,1.5", cells: "24,12"}
  materials: rubber
  material_rubber: {type: neo_hookean, density: 1100, E: 4e5, nu: 0.3}
  bodies: bar
  body_bar: {region: box, lower: "0,0.5", upper: "2,1", points_per_cell: "2,2", material: rubber}
  bcs: root
  bc_root: {region: box, lower: "0,0", upper: "0,1.5", components: "x,y"}
  loads: weight
  load_weight: {type: gravity, value: "0,-9.81", ramp: "0:1"}
  sections: root,row
  section_root: {point: "0.3,0.5", normal: "1,0"}
  section_row: {point: "0,0.75", end: "2,0.75", count: 5}
  profiles: up
  profile_up: {from: "0.8,0.3", to: "0.8,1.2", count: 7}
  tracks: tip
  track_tip: {at: "2,0.75", nearest: 2}
  time: {integrator: explicit, step: 0.002, end: 0.16}
  output: {prefix: thrown, every: 8, grid: true}
"""
CUTS = {"mpm_sections": "one,row", "mpm_section_one_point": "5.07,0", "mpm_section_one_normal": "-2,0",
        "mpm_section_row_point": "0,9.5", "mpm_section_row_end": "8,9.5", "mpm_section_row_count": 9,
        "mpm_section_row_body": "beam"}


def columns(results, name, parts):
    return np.array([results.column(f"section_{name}_{part}")[-1] for part in parts])


def cantilever(test, label, **options):
    """The beam of the example, a tenth of its load: plane cuts at places that are no nodes."""
    run = test.run(example("cantilever"), mpm_time_end=0.1, mpm_output_every=5, mpm_quiet=None, **CUTS, **options)
    results = run.results
    arm = TIP_X + results.column("track_tip_ux")[-1]
    n, v, m = columns(results, "one", "nvm")  # the normal points to the root: V is along -y there, M about z
    test.check(f"{label}.n", abs(n) / LOAD, None, 1e-6)
    test.near(f"{label}.v", v, -LOAD, relative=1e-6)
    test.near(f"{label}.m", m, LOAD * (arm - 5.07), relative=1e-4)
    rows = results.table("section", "row")
    last = {name: values[-9:] for name, values in rows.items()}
    test.check(f"{label}.row", len(rows["s"]) % 9, 0, 0)
    test.near(f"{label}.row_x", last["x"][0], 0.125, absolute=1e-9)  # half a cell inside
    test.check(f"{label}.row_v", np.max(np.abs(last["v"][:-1] + LOAD)) / LOAD, None, 1e-6)
    test.check(f"{label}.row_m", np.max(np.abs(last["m"][:-1] + LOAD * (arm - last["x"][:-1]))) / (LOAD * arm), None, 1e-4)
    return results


def bracket(test):
    """Forces about the origin are those beyond the plane, whatever its angle; the weight comes in a second run."""
    runs = [test.run(BRACKET, ranks=ranks, mpm_quiet=None) for ranks in (1, 2, 3, 4)]
    results = runs[0].results
    place = np.array([3.75, 1.5, 1.5]) + [results.column(f"track_tip_u{axis}")[-1] for axis in "xyz"]
    moment = np.cross(place, TIP)
    slanted = np.array([1.0, 0.4, -0.3]) / np.linalg.norm([1.0, 0.4, -0.3])
    across = np.array([0.0, 1.0, 0.0]) - slanted[1] * slanted
    across /= np.linalg.norm(across)
    for name, axes in (("mid", np.eye(3)), ("oblique", np.array([slanted, across, np.cross(slanted, across)]))):
        values = columns(results, name, ("n", "v1", "v2", "t", "m1", "m2"))
        test.check(f"bracket.{name}_force", difference(axes @ TIP, values[:3]), None, 1e-6)
        test.check(f"bracket.{name}_moment", difference(axes @ moment, values[3:]), None, 1e-6)
    parts = ("n", "v1", "v2", "t", "m1", "m2")
    both = columns(results, "low", parts) + columns(results, "top", parts)
    test.check("bracket.bodies_add_up", difference(columns(results, "mid", parts), both), None, 1e-9)
    for run in runs[1:]:
        label = f"bracket.{runs.index(run) + 1}_ranks"
        for name in [name for name in results.history if name.startswith(("section", "profile"))]:
            scale = max(abs(results.column(name)).max(), 1.0)
            test.check(f"{label}.{name}", np.max(np.abs(results.column(name) - run.results.column(name))) / scale, None, 1e-9)
        for kind, name in (("section", "row"), ("profile", "up")):
            one, other = results.table(kind, name), run.results.table(kind, name)
            worst = max(np.nanmax(np.abs(one[key] - other[key])) / max(np.nanmax(np.abs(one[key])), 1.0) for key in one)
            test.check(f"{label}.{name}", worst, None, 1e-9)
            test.check(f"{label}.{name}_gaps", float(np.isnan(one["x"]).sum()), 0, 0)
    heavy = test.run(BRACKET, mpm_quiet=None, mpm_load_weight_ramp="0:0,1:1").results
    test.near("bracket.weight", heavy.column("section_mid_v2")[-1], TIP[2] - 2.0 * 1000.0 * (4.0 - 2.13), absolute=1.0)


def strip(test):
    """Elastic ground under a strip: pressure along a level adds up to the load, and along one next to the edge of a block under
    its own weight it is linear."""
    options = {"mpm_dim": 2, "mpm_grid_lower": "0,0", "mpm_grid_upper": "4,3", "mpm_grid_cells": "16,12", "mpm_materials": "soil",
               "mpm_material_soil_type": "hencky", "mpm_material_soil_E": 1e9, "mpm_material_soil_nu": 0.3,
               "mpm_material_soil_density": 2000, "mpm_bodies": "ground", "mpm_body_ground_region": "box",
               "mpm_body_ground_lower": "0,0", "mpm_body_ground_upper": "4,2", "mpm_body_ground_material": "soil",
               "mpm_bcs": "sides,base", "mpm_bc_sides_region": "all", "mpm_bc_sides_components": "x",
               "mpm_bc_base_region": "box", "mpm_bc_base_lower": "0,0", "mpm_bc_base_upper": "4,0",
               "mpm_bc_base_components": "x,y", "mpm_loads": "load", "mpm_time_end": 1, "mpm_time_step": 1,
               "mpm_profiles": "level,depth", "mpm_profile_level_from": "0,1.4", "mpm_profile_level_to": "4,1.4",
               "mpm_profile_level_count": 161, "mpm_profile_depth_from": "1.3,0", "mpm_profile_depth_to": "1.3,2.5",
               "mpm_profile_depth_normal": "0,1", "mpm_profile_depth_count": 26, "mpm_quiet": None}
    scene = test.folder() / "empty.yaml"
    scene.write_text("mpm: {}\n")
    weight = test.run(scene, mpm_load_load_type="gravity", mpm_load_load_value="0,-10", mpm_stages="rest",
                      mpm_stage_rest_type="geostatic", mpm_stage_rest_geostatic_method="k0",
                      mpm_stage_rest_geostatic_k0=0.5, **options).results
    rows = weight.table("profile", "depth")
    last = {name: values[-26:] for name, values in rows.items()}
    inside = last["y"] <= 2.0
    theory = -2000.0 * 10.0 * (2.0 - last["y"])
    test.check("weight.linear", np.max(np.abs(last["n"] - theory)[inside]) / 40e3, None, 1e-6)
    test.check("weight.at_top", abs(last["n"][20]) / 40e3, None, 1e-6)
    test.check("weight.beyond", float(np.isfinite(last["n"][last["y"] > 2.3]).sum()), 0, 0)
    test.near("weight.yy_is_n", np.max(np.abs(last["yy"] - last["n"])[inside]), 0.0)
    options["mpm_bc_sides_region"] = "box"
    options.update(mpm_bc_sides_lower="0,0", mpm_bc_sides_upper="0,3")
    load = test.run(scene, mpm_load_load_type="traction", mpm_load_load_value="0,-1e5", mpm_load_load_region="box",
                    mpm_load_load_lower="0,2", mpm_load_load_upper="1,2", mpm_load_load_face="+y", **options).results
    level = load.table("profile", "level")
    pressure, s = -level["n"][-161:], level["s"][-161:]
    total = float(np.sum(0.5 * (pressure[1:] + pressure[:-1]) * np.diff(s)))
    test.near("strip.integral", total, 1e5, relative=1e-2)
    test.near("strip.mean", -load.column("profile_level_n")[-1] * 4.0, 1e5, relative=1e-2)


def swing(test):
    """What has no mass passes on the root's reaction, whatever the part of the step's start in the balance."""
    scene = test.folder() / "scene.yaml"
    scene.write_text(SWING)
    for method, fbar in (("backward_euler", "false"), ("newmark", "false"), ("generalized_alpha", "false"), ("generalized_alpha", "true")):
        results = test.run(scene, mpm_time_integrator=method, mpm_stabilization_fbar=fbar, mpm_quiet=None).results
        n, reaction = results.column("section_root_n"), results.column("reaction_root_x")
        test.check(f"swing.{method}_fbar_{fbar}", np.max(np.abs(n + reaction)) / np.max(np.abs(reaction)), None, 1e-8)
        test.check(f"swing.{method}_fbar_{fbar}_size", np.max(np.abs(n)) / 1500.0, 0.5)


def unused(test):
    """The points move as if nobody had looked, to the last digit."""
    plain = test.run(example("cantilever"), mpm_time_end=0.1, mpm_quiet=None, mpm_output_every=5).results
    seen = test.run(example("cantilever"), mpm_time_end=0.1, mpm_quiet=None, mpm_output_every=5, **CUTS).results
    for name in plain.history:
        test.check(f"unused.{name}", float(np.array_equal(plain.column(name), seen.column(name))), 1, 1)


def restart(test):
    """Stopped half way and continued, the files are the same, to the last byte."""
    whole = test.run(BRACKET, mpm_quiet=None, mpm_checkpoint_every=2)
    parts = test.run(BRACKET, mpm_quiet=None, mpm_checkpoint_every=2, mpm_time_end=0.5, mpm_checkpoint_keep=2)
    process = call(parts.command[:-2] + ["-mpm_checkpoint_keep", "2", "-mpm_time_end", "1",
                                                                 "-mpm_restart", "latest"], parts.folder)
    test.check("restart.status", process.returncode, 0, 0)
    for name in ("sections_section_row.csv", "sections_profile_up.csv"):
        test.check(f"restart.{name}", (whole.folder / name).read_bytes() == (parts.folder / name).read_bytes(), 1, 1)
    one, other = whole.results, parts.results
    for name in [name for name in one.history if name.startswith("section")]:
        test.check(f"restart.{name}", difference(one.column(name), other.column(name)), None, 1e-10)


def explicit(test):
    """An explicit run that has ended, at a step for which output is due or at another, and goes on to a later time leaves what one in a piece does."""
    scene = test.folder() / "scene.yaml"
    scene.write_text(THROWN)
    options = {"mpm_quiet": None, "mpm_checkpoint_every": 1000}
    whole = test.run(scene, **options)
    for name, steps in (("due", 40), ("between", 37)):
        parts = test.run(scene, mpm_time_end=0.002 * steps, **options)
        test.check(f"explicit.{name}.half", parts.results.column("step")[-1], steps, steps)
        process = call(parts.command + ["-mpm_time_end", "0.16", "-mpm_restart", "latest"], parts.folder)
        test.check(f"explicit.{name}.status", process.returncode, 0, 0)
        for file in ("history.csv", "section_row.csv", "profile_up.csv"):
            one, other = ((run.folder / f"thrown_{file}").read_bytes() for run in (whole, parts))
            test.check(f"explicit.{name}.{file}", float(one == other and len(one) > 0), 1, 1)
        with h5py.File(f"{whole.prefix}.h5") as one, h5py.File(f"{parts.prefix}.h5") as other:
            test.check(f"explicit.{name}.states", len(one["points"]), 11, 11)
            test.check(f"explicit.{name}.same_states", float(content(one) == content(other)), 1, 1)


def content(file):
    """All that a results file holds: numbers by name, to the bit."""
    found = {}

    def visit(name, item):
        found[name] = sorted((key, np.asarray(value).tobytes()) for key, value in item.attrs.items())
        if isinstance(item, h5py.Dataset):
            found[name].append(item[()].tobytes())

    file.visititems(visit)
    return found


def refused(test):
    """One line that names the option, exit status 2."""
    for label, options, words in (
            ("body", {"mpm_section_one_body": "wall"}, "-mpm_section_one_body wall: must be one of beam"),
            ("normal", {"mpm_section_one_normal": "0,0"}, "-mpm_section_one_normal: must not be zero"),
            ("end", {"mpm_section_row_end": "0,9.5"}, "-mpm_section_row_end: must not be -mpm_section_row_point"),
            ("count", {"mpm_section_row_count": 1}, "-mpm_section_row_count 1"),
            ("region", {"mpm_section_one_region": "sphere", "mpm_section_one_center": "1,1", "mpm_section_one_radius": 0.5},
             "-mpm_section_one_region: there is no point to be cut"),
            ("outside", {"mpm_section_one_point": "15.01,0"}, "-mpm_section_one_point: no plane of it meets the grid"),
            ("row_outside", {"mpm_section_row_point": "-2,0", "mpm_section_row_end": "-0.1,0"},
             "-mpm_section_row_point: no plane of it meets the grid"),
            ("profile_outside", {"mpm_profiles": "p", "mpm_profile_p_from": "1,-3", "mpm_profile_p_to": "9,-0.1"},
             "-mpm_profile_p_from: no place of the line is in the grid"),
            ("no_normal", {"mpm_sections": "a", "mpm_section_a_point": "1,1"}, "-mpm_section_a_normal is missing"),
            ("profile", {"mpm_profiles": "p", "mpm_profile_p_from": "1,1", "mpm_profile_p_to": "1,1"},
             "-mpm_profile_p_to: must not be -mpm_profile_p_from"),
            ("profile_body", {"mpm_profiles": "p", "mpm_profile_p_from": "1,1", "mpm_profile_p_to": "2,1", "mpm_profile_p_body": "x"},
             "-mpm_profile_p_body x: must be one of beam")):
        cuts = {} if label == "no_normal" else CUTS
        run = test.run(example("cantilever"), status=2, mpm_quiet=None, **{**cuts, **options})
        test.check(f"refused.{label}", words in run.errors and len(run.errors.splitlines()) == 1, 1, 1)
        if words not in run.errors:
            print(run.errors)


with Test() as test:
    for shape in ("linear", "gimp", "bspline2", "bspline3", "gimp_bspline2"):
        cantilever(test, shape, mpm_shape=shape)
    cantilever(test, "without_penalty", mpm_stabilization_ghost="off")
    cantilever(test, "fbar", mpm_stabilization_fbar="true")
    cantilever(test, "plastic", mpm_material_beam_type="j2", mpm_material_beam_yield_stress=300e3, mpm_material_beam_nu=0.45)
    bracket(test)
    strip(test)
    swing(test)
    unused(test)
    restart(test)
    explicit(test)
    refused(test)
