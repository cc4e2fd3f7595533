#!/usr/bin/env python3
"""Ground under water and with its table within: water at rest stays at rest while the ground slides over the grid, stresses of a
geostatic stage are effective ones, and a table that is lowered leaves what theory says. On any number of ranks.

Quick.
"""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import Test, difference, example  # noqa: E402

LEVEL = Path(__file__).resolve().parent / "level_water.yaml"
TOP, WATER, GROUND = 3.0, 1e4, 2e4  # m; weights, N/m3


def hydrostatic(y, level):
    return WATER * np.maximum(level - y, 0.0)


def effective(y, level):
    """Vertical: the weight above with that of the water over the ground, less the pressure; tension positive."""
    return hydrostatic(y, level) - GROUND * (TOP - y) - WATER * max(level - TOP, 0.0)


def at_rest(test, label, run, level, bound=1e-9, balance=1e-9):
    """Pressures, Darcy's velocity and stresses of ground at rest, relative to what gravity alone would drive."""
    y = run.table("position")[:, 1]
    largest, fall = np.max(np.abs(effective(y, level))), 1e-11 / 1e-3 * WATER
    test.check(f"{label}.pressure", np.max(np.abs(run.table("pressure") - hydrostatic(y, level))) / (WATER * level), None, bound)
    test.check(f"{label}.flux", np.max(np.abs(run.table("flux"))) / fall, None, bound)
    stress = run.table("stress")
    test.check(f"{label}.vertical", np.max(np.abs(stress[:, 1] - effective(y, level))) / largest, None, balance)
    test.check(f"{label}.ratio", np.max(np.abs(stress[:, 0] - 0.5 * effective(y, level))) / largest, None, balance)


def slides(test):
    """A hundred steps of 0.37 cells."""
    for name, options in {"deep": {}, "table": {"mpm_water_level": 2}, "surface": {"mpm_water_level": 3},
                          "in_a_cell": {"mpm_water_level": 2.9},
                          "suction": {"mpm_water_level": 3, "mpm_water_above": "suction"},
                          "second": {"mpm_water_level": 2, "mpm_time_scheme": "second", "mpm_stage_slide_time_step": 2}}.items():
        level = float(options.get("mpm_water_level", 3.5))
        run = test.run(LEVEL, snes_rtol=1e-12, **options)
        test.near(f"{name}.way", np.mean(run.table("displacement")[:, 0]), 18.5, 1e-12)
        at_rest(test, name, run, level)
    for level in (3.5, 3.0):  # the geostatic stage finds stresses to 1e-5
        run = test.run(LEVEL, ranks=2, mpm_water_level=level, mpm_shape="gimp_bspline2", mpm_time_end=20)
        at_rest(test, f"splines_{level}", run, level, balance=1e-4)
    several = test.run(LEVEL, ranks=3, mpm_water_level=2, snes_rtol=1e-12, mpm_time_end=20)
    at_rest(test, "on_3", several, 2.0)
    small = test.run(LEVEL, snes_rtol=1e-12, mpm_material_sand_type="linear_elastic", mpm_time_end=20)
    at_rest(test, "small_strain", small, 3.5, balance=1e-2)  # of a small-strain law: relative to the strain


def rises(test):
    """Steady flow upward: where strain may vary within a cell and at both ends, the stress of every single point is theory's."""
    for ranks, options in ((1, {}), (2, {"mpm_material_sand_type": "drucker_prager", "mpm_surface_bottom_ramp": "0:0,3600:1,7200:1.8"})):
        run = test.run(example("seepage"), ranks=ranks, mpm_shape="gimp_bspline2", mpm_shape_edge="open",
                       mpm_stabilization_fbar="false", **options)
        test.check_example(f"rises_on_{ranks}", run, "seepage")


def still(test, stages):
    """The scene with other stages, in which nothing slides."""
    text = LEVEL.read_text(encoding="utf-8")
    kept = [line for line in text.splitlines() if not any(word in line for word in ("bc_slide", "stage_slide", "stages:"))]
    scene = test.folder() / "still.yaml"
    scene.write_text("\n".join(kept + stages).replace("base,still,slide", "base,still") + "\n", encoding="utf-8")
    return scene


def gravity(test):
    """Loads that grow from nothing find the same pressures, and forces that hold the weight."""
    for level in (3.5, 2.0):
        run = test.run(LEVEL, mpm_water_level=level, mpm_stage_rest_geostatic_method="gravity")
        y = run.table("position")[:, 1]
        test.check(f"gravity_{level}.pressure", np.max(np.abs(run.table("pressure") - hydrostatic(y, level))), None, 1e-6)
        weight = 4.0 * (GROUND * TOP + WATER * max(level - TOP, 0.0))
        test.near(f"gravity_{level}.force", run.results.column("reaction_base_y")[-1], weight, 1e-8)


def excess(test):
    """It drains, and leaves water at rest."""
    scene = still(test, ["  time: {end: 1e6, step: 100, step_max: 1e5}"])
    scene.write_text("\n".join(line for line in scene.read_text(encoding="utf-8").splitlines() if "stage_rest" not in line),
                     encoding="utf-8")
    run = test.run(scene, mpm_body_sand_initial_pressure=5e3, mpm_load_weight_ramp="0:1", mpm_output_every=1)
    y = run.results.initial["position0"][:, 1]
    start = run.results.state(0)["pressure"]
    test.check("excess.start", difference(hydrostatic(y, 3.5) + 5e3, start), None, 1e-12)
    y = run.table("position")[:, 1]
    test.check("excess.end", np.max(np.abs(run.table("pressure") - hydrostatic(y, 3.5))) / (WATER * 3.5), None, 1e-3)


def plate(test):
    """A plate that lets water through lies on the ground: water at rest stays at rest, and the plate feels none of it. One that leads
    water away at no pressure draws the level down to itself."""
    scene = test.folder() / "plate.yaml"
    text = LEVEL.read_text(encoding="utf-8").replace("surfaces: top", "boundaries: plate")
    lines = ['  boundary_plate: {type: box, lower: "-1,3", upper: "30,3.9", drained: true}' if "surface_top" in line else line
             for line in text.splitlines()]
    scene.write_text("\n".join(lines) + "\n", encoding="utf-8")
    for level in (3.5, 2.0):
        run = test.run(scene, snes_rtol=1e-12, mpm_water_level=level, mpm_stage_slide_time_step=4)
        at_rest(test, f"plate_{level}", run, level)
        test.check(f"plate_{level}.reaction", np.max(np.abs(run.results.column("reaction_plate_y"))), None, 1e-3)
    scene.write_text(scene.read_text(encoding="utf-8").replace("drained: true", "pressure: 0"), encoding="utf-8")
    run = test.run(scene, mpm_stage_slide_time_end=2000, mpm_bc_slide_value="0", mpm_stage_slide_time_step=10,
                   mpm_stage_slide_time_step_max=200)
    y = run.table("position")[:, 1]
    test.check("drain.pressure", np.max(np.abs(run.table("pressure") - hydrostatic(y, 3.0))) / (WATER * 3), None, 2e-3)


def lowered(test):
    """From the surface to a metre below: the ground above is dry, and all below bears 10 kPa more."""
    scene = still(test, ["  stages: rest,drain", "  stage_drain: {time: {end: 1e6, step: 100, step_max: 1e5}}"])
    run = test.run(scene, mpm_water_level=3, mpm_water_ramp="1:1,1001:0.66666666666666663")
    test.check("lowered.silent", "water" in run.errors, 0, 0)
    y = run.table("position")[:, 1]
    test.check("lowered.pressure", np.max(np.abs(run.table("pressure") - hydrostatic(y, 2.0))), None, 20.0)
    stress = run.table("stress")[:, 1]
    test.near("lowered.stress", np.mean(stress), np.mean(effective(y, 2.0)), 2e-3)
    modulus = 1e7 * 0.7 / (1.3 * 0.4)
    sunk = -np.min(run.table("displacement")[:, 1])
    test.near("lowered.settlement", sunk, (2.0 * WATER + 0.5 * WATER) / modulus, 0.02)


def lost(test):
    """Rain on dry ground has no effect, nor a level that moves in sealed ground with suction: a line, once a stage."""
    scene = still(test, ["  stages: rest,drain", "  stage_drain: {time: {end: 4, step: 1}}"])
    text = scene.read_text(encoding="utf-8").replace("loads: weight", "loads: weight,rain")
    scene.write_text(text + '  load_rain: {type: flux, region: box, lower: "0,2", upper: "4,3", value: 1e-6}\n', encoding="utf-8")
    run = test.run(scene, ranks=3, mpm_water_level=2.5, mpm_stage_rest_loads="weight")
    test.check("lost.part", "load rain: 50 % of its water goes into ground above the level" in run.errors, 1)
    test.check("lost.once", run.errors.count("load rain"), 1, 1)
    run = test.run(scene, mpm_water_level=2.5, mpm_water_above="suction", mpm_water_ramp="1:1,4:0.5", mpm_surfaces="",
                   mpm_stage_rest_loads="weight")
    test.check("lost.level", run.errors.count("moves at drained faces alone"), 1, 1)


def main():
    with Test() as test:
        slides(test)
        rises(test)
        gravity(test)
        excess(test)
        plate(test)
        lowered(test)
        lost(test)


if __name__ == "__main__":
    main()
