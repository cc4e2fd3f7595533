#!/usr/bin/env python3
"""Stages: the stress of ground at rest, bodies that come and go, other materials, loads that join; points from files."""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import Test, difference  # noqa: E402

FOLDER = Path(__file__).resolve().parent
K0, HEIGHT = 0.6, {"level": 5.0, "level3d": 3.0, "slope": 10.0}
LAWS = {"hencky": {}, "linear_elastic": {}, "j2": {"mpm_material_soil_yield_stress": 1e6},
        "drucker_prager": {"mpm_material_soil_cohesion": 1e4, "mpm_material_soil_friction": 30},
        "mohr_coulomb": {"mpm_material_soil_cohesion": 1e4, "mpm_material_soil_friction": 30}}
STEP = "0,0,20,0,20,10,11,10,11,5,0,5"


def overloaded(test):
    """A body that comes with a stage and that soft clay does not bear: the last line names it."""
    run = test.run(FOLDER / "level.yaml", status=3, mpm_bodies="ground,bed,fill", mpm_body_fill_region="box", mpm_body_fill_lower="0,5",
                   mpm_body_fill_upper="1.5,6", mpm_body_fill_material="rock", mpm_stage_hold_bodies="fill",
                   mpm_stage_hold_time_step_min=0.25, mpm_material_soil_type="j2", mpm_material_soil_yield_stress=1e3,
                   mpm_stage_rest_geostatic_k0=1)
    test.check("overloaded", "all of body fill weighs from the first step of stage hold on" in run.errors, 1)


def law(name):
    return {"mpm_material_soil_type": name, **LAWS[name]}


def at_rest(test, label, run, scene):
    """Nothing has moved in the stage after the geostatic one, and the mass is that of the bodies as they stand."""
    state = run.results.state("last")
    moved = np.linalg.norm(state["displacement"], axis=1).max() / HEIGHT[scene]
    test.check(f"{label}.displacement_over_height", moved, None, 1e-6)
    first = run.results.state("first")
    test.near(f"{label}.mass", state["mass"].sum(), first["mass"].sum(), relative=1e-12)
    test.near(f"{label}.volume", state["volume"].sum(), first["volume"].sum(), relative=1e-8)


def ratio(test, label, run, scene, k0):
    """At rest, with the same ratio at every point."""
    at_rest(test, label, run, scene)
    state = run.results.state("last")
    stress, up = state["stress"], state.dim - 1
    for axis in range(up):
        test.check(f"{label}.k0_error_{'xy'[axis]}", np.abs(stress[:, axis] / stress[:, up] - k0).max(), None, 1e-9)
    return state


def level(test, scene, name, shape, count=1):
    """K0 at every point, and the weight above it."""
    label = f"{scene}_{name}_{shape}_{count}"
    options = law(name)
    if (name, shape) == ("drucker_prager", "bspline3"):
        # with F-bar the balance of layers with other points a cell moves the vertical stress by 22 %, and points yield
        options["mpm_stabilization_fbar"] = "false"
    run = test.run(FOLDER / f"{scene}.yaml", ranks=count, mpm_shape=shape, mpm_quiet=None, **options)
    state = ratio(test, label, run, scene, K0)
    dim, stress = state.dim, state["stress"]
    if "bspline" in shape:  # what balances the weight is not its integral there
        return
    height = state["position"][:, -1]
    below = np.maximum(1.0 - height, 0.0) if scene == "level" else 0.0  # in the bed of rock
    weight = 2e4 * (HEIGHT[scene] - height - below) + 2.6e4 * below
    # a small-strain law's stress is that of the undeformed area: as far from the weight as the sides have moved
    reach = np.abs(state["F"][:, 0] - 1.0).max() * 1.01 if name == "linear_elastic" else 1e-6
    test.check(f"{label}.weight_error", np.abs(-stress[:, dim - 1] / weight - 1.0).max(), None, reach)


def initial_history(test):
    """History by height: on a lattice and beside a file's columns, which win; ground with it rests."""
    profile, expected = "0:0.01,3:0.04,3:0.1,5:0.2", lambda y: np.interp(y, [0, 3 - 1e-9, 3, 5], [0.01, 0.04, 0.1, 0.2])
    options = {**law("j2"), "mpm_body_ground_initial_equivalent_plastic_strain": profile, "mpm_quiet": None}
    for count in (1, 2):
        run = test.run(FOLDER / "level.yaml", ranks=count, **options)
        state = ratio(test, f"initial_{count}", run, "level", K0)
        ground = state["material"] == 0
        wanted = expected(run.results.state("first")["position"][ground, 1])
        for name, step in (("first", "first"), ("last", "last")):
            values = run.results.state(step)["equivalent_plastic_strain"][ground]
            test.check(f"initial_{count}.{name}", np.abs(values - wanted).max(), None, 1e-10)
    table = test.folder() / "points.csv"
    first = run.results.state("first")
    ground = first["material"] == 0
    rows = np.column_stack([first["position"][ground], first["volume"][ground]])
    for column, value in ((None, None), ("equivalent_plastic_strain", 0.5)):
        data = rows if column is None else np.column_stack([rows, np.full(len(rows), value)])
        np.savetxt(table, data, fmt="%.17g", delimiter=",", comments="", header="x,y,volume" + (f",{column}" if column else ""))
        lines = (FOLDER / "level.yaml").read_text(encoding="utf-8").splitlines()
        scene = test.folder() / "table.yaml"
        scene.write_text("\n".join(f"  body_ground: {{region: file, file: \"{table}\", material: soil}}"
                                   if "body_ground:" in line else line for line in lines), encoding="utf-8")
        run = test.run(scene, **options)
        start = run.results.state("first")
        ground = start["material"] == 0
        wanted = expected(start["position"][ground, 1]) if column is None else value
        test.check(f"initial_from_{column or 'profile'}", np.abs(start["equivalent_plastic_strain"][ground] - wanted).max(), None, 1e-10)


def ratios(test, shape, text, soil, rock, **options):
    """Another k0 in each layer, by body, by material, or by the law; level ground rests, with its ratio at every point."""
    label = f"ratios_{shape}_{text}"
    run = test.run(FOLDER / "level.yaml", mpm_shape=shape, mpm_quiet=None, mpm_stage_rest_geostatic_k0=text, **options)
    at_rest(test, label, run, "level")
    state = run.results.state("last")
    wanted = np.where(state["position"][:, 1] > 1.0, soil, rock)
    test.check(f"{label}.error", np.abs(state["stress"][:, 0] / state["stress"][:, 1] - wanted).max(), None, 1e-9)


SINE = 3 * 1.2 / (6 + 1.2)  # of the friction that M = 1.2 has in triaxial compression
CLAY = "type: modified_cam_clay, kappa: 0.02, lambda: 0.1, M: 1.2, G: 4e6, density: 2000"
SAND = ("type: nor_sand, kappa: 0.01, lambda: 0.02, M: 1.2, N: 0.3, G: 20e6, v_c0: 1.9, h: 100, specific_volume: 1.7, "
        "reference_pressure: 100e3, density: 2000")


def clay_size(pressure, shear):
    """Preconsolidation of the ellipse through a stress."""
    return pressure + shear**2 / (1.44 * pressure)


def sand_size(pressure, shear):
    """Image pressure of Nor-Sand's yield surface through a stress."""
    return pressure * ((1 - 0.3 * shear / pressure / 1.2) / 0.7) ** (-0.7 / 0.3)


def overconsolidated(test, label, law_text, state_name, size, ocr=None, pop=None):
    """Ground whose preconsolidation follows from the stress, and the ratio k0 from that: it rests."""
    scene = test.folder() / "ground.yaml"
    lines = (FOLDER / "level.yaml").read_text(encoding="utf-8").splitlines()
    scene.write_text("\n".join(f"  material_soil: {{{law_text}}}" if "material_soil:" in line else line for line in lines),
                     encoding="utf-8")
    run = test.run(scene, mpm_quiet=None, mpm_stage_rest_geostatic_k0="soil:ocr,rock:0.8",
                   **({"mpm_material_soil_ocr": ocr} if ocr else {"mpm_material_soil_pop": pop}))
    at_rest(test, label, run, "level")
    state = run.results.state("last")
    ground = state["material"] == 0
    stress = state["stress"][ground] * np.linalg.det(state["F"][ground].reshape(-1, 3, 3))[:, None]
    tip = 1.0 if size is clay_size else 0.7 ** (-0.7 / 0.3)  # preconsolidation over the state variable
    weight, jaky = -stress[:, 1], 1 - SINE
    grown = ocr or 1 + pop / (tip * size(weight * (1 + 2 * jaky) / 3, weight * SINE))
    test.check(f"{label}.k0_error", np.abs(stress[:, 0] / stress[:, 1] / (jaky * grown**SINE) - 1.0).max(), None, 1e-9)
    expected = size(-stress[:, :3].mean(axis=1), np.abs(stress[:, 0] - stress[:, 1]))
    expected = expected * ocr if ocr else expected + pop / tip
    test.check(f"{label}.{state_name}", np.abs(state[state_name][ground] / expected - 1.0).max(), None, 1e-9)


def gaps(test, shape, k0):
    """Layers that meet inside a cell, where their points leave a gap; also a ratio for which no elasticity is fit."""
    run = test.run(FOLDER / "level.yaml", mpm_shape=shape, mpm_quiet=None, mpm_body_ground_lower="0,1.3",
                   mpm_body_bed_upper="3,1.3", mpm_stage_rest_geostatic_k0=k0)
    ratio(test, f"gaps_{shape}_{k0:g}", run, "level", k0)


WIDE = {"mpm_grid_upper": "30,6", "mpm_grid_cells": "30,6", "mpm_body_ground_upper": "30,5", "mpm_body_bed_upper": "30,1",
        "mpm_bc_east_lower": "30,0", "mpm_bc_east_upper": "30,6", "mpm_bc_base_upper": "30,0"}


def grids(test):
    """The same layers over wider and finer grids, with other solvers, and with the volume change averaged over cells."""
    for label, shape, k0, count, options in (
            ("wide", "bspline2", 0.5, 1, WIDE), ("wide_amg", "bspline3", 1.5, 2, WIDE | {"mpm_solver": "amg"}),
            ("fine", "bspline3", 0.01, 1, {"mpm_grid_cells": "12,24"}),
            ("odd", "bspline2", 0.5, 3, {"mpm_grid_cells": "7,13", "mpm_material_soil_type": "linear_elastic"}),
            ("fbar", "bspline2", 0.5, 2, {"mpm_stabilization_fbar": "true"})):
        run = test.run(FOLDER / "level.yaml", ranks=count, mpm_shape=shape, mpm_quiet=None,
                       mpm_stage_rest_geostatic_k0=k0, **options)
        ratio(test, f"{label}_{shape}", run, "level", k0)


BED = {"mpm_bodies": "ground,bed", "mpm_body_ground_lower": "0,0,1", "mpm_body_bed_region": "box",
       "mpm_body_bed_lower": "0,0,0", "mpm_body_bed_upper": "3,2,1", "mpm_body_bed_points_per_cell": "3,3,3",
       "mpm_body_bed_material": "soil"}


def layers3d(test):
    """Two layers with other points a cell, summed by splines."""
    run = test.run(FOLDER / "level3d.yaml", ranks=2, mpm_shape="bspline2", mpm_quiet=None, **BED)
    ratio(test, "layers3d", run, "level3d", K0)


def uneven(test, name, method, vertices, shape):
    label = f"{'step' if vertices else 'slope'}_{name}_{method}_{shape}"
    options = {"mpm_shape": shape, "mpm_stage_rest_geostatic_method": method, "mpm_quiet": None, **law(name)}
    if name == "j2":
        options["mpm_material_soil_yield_stress"] = 6e4  # a part of the ground flows
    if vertices:
        options["mpm_body_ground_vertices"] = vertices
    run = test.run(FOLDER / "slope.yaml", **options)
    at_rest(test, label, run, "slope")
    weight = run.results.state("first")["mass"].sum() * 10.0
    test.near(f"{label}.base", run.results.column("reaction_base_y")[-1], weight, relative=1e-7)
    return run, options


def ranks(test):
    one, options = uneven(test, "drucker_prager", "k0", STEP, "gimp")
    run = test.run(FOLDER / "slope.yaml", ranks=3, **options)
    for field in ("id", "stress", "F", "elastic_left_cauchy_green"):
        test.check(f"ranks_3.{field}", difference(one.table(field), run.table(field)), None, 1e-9)


def digging(test):
    """Bodies that go and come in a column: the tops of what is left move by weight times height over the modulus. Without
    ghost penalty, whose force in one step the next one gives back: a thousandth of the movement."""
    run = test.run(FOLDER / "dig.yaml", mpm_quiet=None, mpm_stabilization_ghost="off")
    soil, hard = 1e9 * 0.7 / (1.3 * 0.4), 2e9 * 0.8 / (1.2 * 0.6)  # constrained moduli
    reach = 4.0 - 0.125  # the tracked points stand half a point below the top
    row = {stage: np.flatnonzero(run.results.column("stage") == stage)[-1] for stage in range(1, 6)}
    top, base = run.results.column("track_top_uy"), run.results.column("reaction_base_y")
    for name, stage, expected in (("dig", 2, 2e4 * reach / soil), ("fill", 3, -1e4 * reach / soil),
                                  ("load", 5, -1e4 * reach / hard)):
        test.near(f"dig.{name}_over_theory", top[row[stage]] / expected, 1.0, absolute=0.001)
    test.check("dig.rest_moves", abs(top[row[1]]), None, 1e-12)
    test.check("dig.swap_moves", abs(top[row[4]]), None, 1e-9)
    for stage, weight in ((1, 2e5), (2, 1.6e5), (3, 1.8e5), (4, 1.8e5), (5, 2e5)):
        test.near(f"dig.base_of_stage_{stage}", base[row[stage]], weight, relative=1e-4)
    ids = run.results.state("last")["id"]
    test.check("dig.points", ids.size, 144, 144)
    test.check("dig.ids_are_kept", np.count_nonzero(np.diff(ids) > 1), 1, 1)
    test.check("dig.last_id", ids[-1], 175, 175)
    other = test.run(FOLDER / "dig.yaml", ranks=3, mpm_quiet=None, mpm_stabilization_ghost="off")
    for field in ("id", "position", "stress"):
        test.check(f"dig.ranks_3.{field}", difference(run.table(field), other.table(field)), None, 1e-9)
    test.check("dig.ranks_3.track", difference(top, other.results.column("track_top_uy")), None, 1e-7)


PIT = {"mpm_bodies": "ground,pit", "mpm_body_pit_region": "box", "mpm_body_pit_lower": "8,3",
       "mpm_body_pit_upper": "12,5", "mpm_body_pit_points_per_cell": "2,2", "mpm_body_pit_material": "soil",
       "mpm_body_ground_vertices": "0,0,20,0,20,5,12,5,12,3,8,3,8,5,0,5", "mpm_body_ground_points_per_cell": "2,2",
       "mpm_stage_hold_remove": "pit"}


def pit(test):
    """A strip dug out in the middle: the answer is symmetric, its floor rises, its sides come in."""
    run = test.run(FOLDER / "slope.yaml", mpm_quiet=None, mpm_shape="linear", **PIT)
    state, start = run.results.state("last"), run.results.state("first")
    moved = state["displacement"]
    place = {(round(x, 6), round(y, 6)): i for i, (x, y) in enumerate(state["position"] - moved)}
    mirror = [place[(round(20.0 - x, 6), round(y, 6))] for x, y in state["position"] - moved]
    largest = np.abs(moved).max()
    test.check("pit.points", start["id"].size - state["id"].size, 32, 32)
    test.check("pit.asymmetry_x", np.abs(moved[:, 0] + moved[mirror, 0]).max() / largest, None, 1e-8)
    test.check("pit.asymmetry_y", np.abs(moved[:, 1] - moved[mirror, 1]).max() / largest, None, 1e-8)
    test.check("pit.floor", moved[place[(9.75, 2.75)], 1], 1e-4, 1e-2)
    test.check("pit.side", moved[place[(7.75, 4.25)], 0], 1e-5, 1e-2)
    weight = state["mass"].sum() * 10.0
    test.near("pit.base", run.results.column("reaction_base_y")[-1], weight, relative=1e-6)


def strength(test):
    """Less strength: the state stays, and the next step's return brings it to the smaller yield surface."""
    weak = {"mpm_materials": "soil,weak", "mpm_material_weak_type": "j2", "mpm_material_weak_E": 20e6,
            "mpm_material_weak_nu": 0.3, "mpm_material_weak_density": 2000, "mpm_material_weak_yield_stress": 5e4,
            "mpm_material_weak_hardening": 1e6, "mpm_stage_hold_materials": "ground:weak"}
    run = test.run(FOLDER / "slope.yaml", mpm_quiet=None, **law("j2"), **weak)
    state = run.results.state("last")
    settled = np.abs(state["displacement"]).max()
    test.check("strength.moves", settled, 1e-3, 0.5)
    test.check("strength.flows", state["equivalent_plastic_strain"].max(), 1e-4, 0.2)
    test.check("strength.material", state["material"].min(), 1, 1)
    size = np.linalg.det(state["F"].reshape(-1, 3, 3))
    s = state["stress"] * size[:, None]
    mises = np.sqrt(0.5 * ((s[:, 0] - s[:, 1]) ** 2 + (s[:, 1] - s[:, 2]) ** 2 + (s[:, 2] - s[:, 0]) ** 2)
                    + 3.0 * s[:, 3] ** 2)
    limit = 5e4 + 1e6 * state["equivalent_plastic_strain"]
    test.check("strength.excess", (mises / limit).max(), None, 1.0 + 1e-8)


def carried(test):
    """A load and a prescribed displacement that act in the next stage too go on; those that join count from there."""
    options = {"mpm_stages": "one,two,three", "mpm_stage_one_time_end": 2, "mpm_stage_two_loads": "weight,push",
               "mpm_stage_three_loads": "push", "mpm_loads": "weight", "mpm_load_push_type": "force",
               "mpm_load_push_value": "0,-3e4", "mpm_load_push_region": "box", "mpm_load_push_lower": "0,4",
               "mpm_load_push_upper": "3,5"}
    lines = (FOLDER / "level.yaml").read_text(encoding="utf-8").splitlines()
    scene = test.folder() / "carried.yaml"
    scene.write_text("\n".join(line for line in lines if "stage" not in line), encoding="utf-8")
    run = test.run(scene, mpm_quiet=None, **options)
    time, base = run.results.column("time"), run.results.column("reaction_base_y")
    weight = run.results.state("first")["mass"].sum() * 10.0
    expected = {0.5: 0.5 * weight, 2.0: weight, 2.5: weight + 1.5e4, 3.0: weight + 3e4, 3.5: 3e4, 4.0: 3e4}
    for at, force in expected.items():
        test.near(f"carried.base_at_{at:g}", base[np.isclose(time, at)][0], force, relative=1e-6)
    test.near("carried.load_column", run.results.column("load")[np.isclose(time, 3.0)][0], 1.0, absolute=1e-12)


def without_stages(path, body, folder):
    """The slope's scene in one piece, its points from a file, its weight in full from the start."""
    lines = [line for line in path.read_text(encoding="utf-8").splitlines() if "stage" not in line]
    lines = [f"  body_ground: {{region: file, file: \"{body}\", material: soil}}" if "body_ground:" in line else line
             for line in lines]
    scene = folder / "again.yaml"
    scene.write_text("\n".join(lines) + "\n  load_weight_ramp: \"0:1\"\n", encoding="utf-8")
    return scene


def write_csv(path, state):
    half = np.full((state["id"].size, 2), 1.0 / 6.0)
    rows = np.column_stack([state["position"], state["volume"], state["stress"][:, :4], half])
    names = "x,y,volume,stress_xx,stress_yy,stress_zz,stress_xy,half_length_x,half_length_y"
    np.savetxt(path, rows, fmt="%.17g", delimiter=",", header="# points at rest\n" + names, comments="")


def imported(test, name):
    """A run's points are another run's start: equilibrium; with the stress alone, F and history are searched again."""
    run = test.run(FOLDER / "slope.yaml", mpm_quiet=None, **law(name))
    last = run.results.state("last")
    folder = test.folder()
    write_csv(folder / "points.csv", last)
    for label, body, count in (("h5", run.prefix + ".h5", 1), ("h5", run.prefix + ".h5", 3),
                               ("csv", folder / "points.csv", 1), ("csv", folder / "points.csv", 2)):
        again = test.run(without_stages(FOLDER / "slope.yaml", body, folder), ranks=count, mpm_time_end=0.3,
                         mpm_quiet=None, **law(name))
        state, label = again.results.state("last"), f"imported_{name}_{label}_{count}"
        test.check(f"{label}.displacement_over_height", np.abs(state["displacement"]).max() / 10.0, None, 1e-6)
        test.check(f"{label}.stress", difference(last["stress"], state["stress"]), None, 1e-5)
        test.near(f"{label}.mass", state["mass"].sum(), last["mass"].sum(), relative=1e-9)


with Test() as test:
    for law_name in LAWS:
        for shape_name in ("gimp", "linear"):
            level(test, "level", law_name, shape_name)
    for law_name, shape_name, rank_count in (("hencky", "bspline2", 1), ("drucker_prager", "bspline3", 2),
                                             ("j2", "gimp_bspline2", 1), ("linear_elastic", "bspline3", 3)):
        level(test, "level", law_name, shape_name, rank_count)
    for shape_name, k0_value in (("gimp", 0.6), ("bspline2", 1.8), ("gimp_bspline2", 0.3)):
        gaps(test, shape_name, k0_value)
    grids(test)
    initial_history(test)
    ratios(test, "gimp", "ground:0.45,bed:0.8", 0.45, 0.8)
    ratios(test, "bspline2", "bed:0.3,ground:0.5", 0.5, 0.3, mpm_body_bed_material="soil")
    ratios(test, "gimp_bspline2", "soil:ocr,rock:0.25", 0.5, 0.25, **law("mohr_coulomb"))  # Jaky: 1 - sin(30 degrees)
    for label, law_text, name, size in (("clay", CLAY, "preconsolidation", clay_size), ("sand", SAND, "image_pressure", sand_size)):
        overconsolidated(test, label + "_ocr", law_text, name, size, ocr=2.0)
        overconsolidated(test, label + "_pop", law_text, name, size, pop=60e3)
    ratios(test, "gimp", "ground:ocr,bed:ocr", 0.5, 0.5, mpm_body_bed_material="soil", **law("drucker_prager"))
    level(test, "level3d", "hencky", "gimp")
    level(test, "level3d", "drucker_prager", "linear")
    layers3d(test)
    for law_name in LAWS:
        uneven(test, law_name, "k0", None, "gimp")
    uneven(test, "hencky", "k0", STEP, "linear")
    uneven(test, "j2", "k0", STEP, "gimp")
    uneven(test, "j2", "gravity", None, "gimp_bspline2")
    ranks(test)
    overloaded(test)
    digging(test)
    pit(test)
    strength(test)
    carried(test)
    imported(test, "hencky")
    imported(test, "drucker_prager")
