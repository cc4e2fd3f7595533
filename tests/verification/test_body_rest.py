#!/usr/bin/env python3
"""Bodies in contact in a geostatic stage: they find equilibrium in the shape in which they were drawn, and nothing moves after it."""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import Test, difference  # noqa: E402

HERE = Path(__file__).resolve().parent
BLOCK, INCLINED = (HERE / name for name in ("block_at_rest.yaml", "inclined_block.yaml"))
LEVEL = HERE / "level.yaml"
STAGES = {"mpm_stages": "rest,hold", "mpm_stage_rest_type": "geostatic", "mpm_stage_rest_time_end": 1, "mpm_stage_hold_time_end": 1,
          "mpm_stage_hold_time_step": 0.5, "mpm_load_weight_ramp": "0:1"}
WEIGHT, HEIGHT = 25e3, 3.0


def level(test):
    """A block on level ground presses by its weight; later steps move it by no more than the stage left."""
    runs = {}
    for label, options in (("gravity", {}), ("on_2", {"ranks": 2}), ("on_3", {"ranks": 3}), ("stick", {"mpm_contact_ab_friction": "stick"}),
                           ("k0", {"mpm_stage_rest_geostatic_method": "k0", "mpm_stage_rest_geostatic_k0": 0.5}),
                           ("augmented", {"mpm_contact_ab_method": "augmented"}), ("barrier", {"mpm_contact_ab_method": "barrier"}),
                           ("gimp_bspline2", {"mpm_shape": "gimp_bspline2"})):
        run = runs[label] = test.run(BLOCK, mpm_checkpoint_every=1, mpm_checkpoint_keep=3, **options)
        test.check(f"level_{label}.force", difference(run.results.column("force_ab_y"), WEIGHT), None, 1e-9)
        test.check(f"level_{label}.moved", np.max(np.abs(run.table("displacement"))) / HEIGHT, None, 2e-9)
        test.check(f"level_{label}.newton", np.max(run.newton[1:]), None, 1)
    run = test.run(BLOCK, mpm_contact_ab_method="barrier", mpm_stage_hold_bodies="block")  # joins without a gap
    test.check("level_joins.force", difference(run.results.column("force_ab_y")[-1], WEIGHT), None, 1e-9)
    run = test.run(BLOCK, mpm_contact_ab_friction="frictionless", status=3)
    test.check("level_slides.line", "nothing holds body block against translation in x" in run.errors, True, True)
    for label in ("on_2", "on_3"):
        test.check(f"level_{label}.same", difference(runs["gravity"].table("stress"), runs[label].table("stress")), None, 1e-9)
    for label, options in (("sticks", {}), ("k0_on_3", {"ranks": 3, "mpm_stage_rest_geostatic_method": "k0", "mpm_stage_rest_geostatic_k0": 0.5}),
                           ("augmented", {"mpm_contact_ab_method": "augmented"}),
                           ("stick", {"mpm_contact_ab_friction": "stick"})):  # explicit steps, whose penalties are soft
        run = test.run(BLOCK, mpm_stage_hold_time_integrator="explicit", mpm_stage_hold_time_end=0.05, mpm_stage_hold_time_step=5e-4,
                       mpm_material_rock_E=5e7, **options)
        test.check(f"explicit_{label}.force", difference(run.results.column("force_ab_y"), WEIGHT), None, 1e-9)
        test.check(f"explicit_{label}.moved", np.max(np.abs(run.table("displacement"))) / HEIGHT, None, 2e-9)
    for ranks, step in ((1, 1), (2, 1)):
        run = test.run(BLOCK, ranks=ranks, mpm_restart=runs["gravity"].folder / f"rest_checkpoint_{step:06d}.h5")
        test.check(f"level_again_on_{ranks}.same", difference(runs["gravity"].table("stress"), run.table("stress")), None, 1e-10)


def floor(test):
    """Ground on a rigid plane, whose penalty needs a depth for its pressure, stands as it was drawn, whatever comes next."""
    plane = {"mpm_boundaries": "floor", "mpm_boundary_floor_type": "plane", "mpm_boundary_floor_point": "0,0",
             "mpm_boundary_floor_normal": "0,1", "mpm_boundary_floor_friction": 0.3, "mpm_checkpoint_every": 1, "mpm_checkpoint_keep": 3}
    block, layers = {"mpm_bcs": "left,right", **plane}, {"mpm_bcs": "west,east", "mpm_output_every": 1, **plane}
    runs = {"gravity": test.run(BLOCK, **block),
            "k0_on_3": test.run(BLOCK, ranks=3, mpm_stage_rest_geostatic_method="k0", mpm_stage_rest_geostatic_k0=0.5, **block),
            "newmark": test.run(LEVEL, mpm_boundary_floor_contact="bilateral", mpm_stage_hold_time_integrator="newmark", **layers),
            "relaxation": test.run(LEVEL, mpm_stage_hold_type="relaxation", mpm_stage_hold_time_step=1e-4, mpm_material_rock_E=5e7, **layers)}
    runs["again"] = test.run(BLOCK, ranks=2, mpm_restart=runs["gravity"].folder / "rest_checkpoint_000001.h5", **block)
    for label, run in runs.items():
        force = run.results.column("reaction_floor_y")
        test.check(f"floor_{label}.force", difference(force[-1], force[0]), None, 1e-6)
        test.check(f"floor_{label}.moved", np.max(np.abs(run.table("displacement"))) / HEIGHT, None, 2e-9)
    run = test.run(LEVEL, mpm_stage_hold_time_integrator="explicit", mpm_stage_hold_time_end=0.1, mpm_stage_hold_time_step=1e-3, mpm_material_rock_E=5e7, **layers)
    test.check("floor_explicit.moved", np.max(np.abs(run.table("displacement"))) / HEIGHT, None, 2e-9)
    # a ramp of a displacement, given or not, begins behind the geostatic stage
    lifts = {"boundary": {"mpm_boundary_floor_motion": "0,1e-3", **layers},
             "ramp": {"mpm_boundary_floor_motion": "0,1e-3", "mpm_boundary_floor_ramp": "0:0,1:1", **layers},
             "condition": {"mpm_bc_base_value": "1e-3", "mpm_bc_base_ramp": "0:0,1:1"},
             "motion": {"mpm_bcs": "west,east", "mpm_motions": "lift", "mpm_motion_lift_body": "bed", "mpm_motion_lift_components": "y",
                        "mpm_motion_lift_value": "1e-3"}}
    for label, options in lifts.items():
        run = test.run(LEVEL, **{"mpm_output_every": 1, **options})
        test.near(f"floor_lifts.{label}", np.mean(run.table("displacement")[:, 1]), 1e-3,
                  relative=1e-5 if "floor" in options.get("mpm_boundaries", "") else 1e-4)  # nodes below lifted ground hold it


def layers(test):
    """Layers stand in motion, too, behind a geostatic stage so short that the default ramp of their weight would not end in it."""
    for shape, fbar in (("gimp", "auto"), ("gimp_bspline2", "auto"), ("bspline2", "true")):
        for integrator, step in (("newmark", 0.05), ("explicit", 5e-4)):
            run = test.run(LEVEL, mpm_output_every=1, mpm_shape=shape, mpm_stage_rest_time_end=0.2, mpm_stage_hold_time_integrator=integrator,
                           mpm_stage_hold_time_step=step, mpm_stage_hold_time_end=0.2, mpm_stabilization_fbar=fbar)
            test.check(f"layers_{shape}_{integrator}.moved", np.max(np.abs(run.table("displacement"))) / HEIGHT, None, 2e-9)
            test.near(f"layers_{shape}_{integrator}.weight", run.results.column("reaction_base_y")[-1], 318e3, relative=1e-9)


def plate(test):
    """A free plate on level ground stands still in the geostatic stage; its load's ramp begins behind it."""
    soil, rock = (E * (1 - nu) / ((1 + nu) * (1 - 2 * nu)) for E, nu in ((10e6, 0.3), (1e9, 0.2)))
    settled = 10e3 * (4 / soil + 1 / rock)
    load = {"mpm_boundaries": "plate", "mpm_boundary_plate_type": "box", "mpm_boundary_plate_lower": "0,5", "mpm_boundary_plate_upper": "3,5.5",
            "mpm_boundary_plate_free": "y", "mpm_boundary_plate_load": "0,-30e3", "mpm_boundary_plate_mass": 1, "mpm_grid_refine": 2}
    for label, options in (("k0", {}), ("gravity_on_3", {"ranks": 3, "mpm_stage_rest_geostatic_method": "gravity"})):
        place = test.run(LEVEL, **load, **options).results.column("position_plate_y")
        test.check(f"plate_{label}.rests", place[0], 5.25, 5.25)
        test.near(f"plate_{label}.settles", 5.25 - place[-1], settled, relative=1e-2)


def wall(test):
    """Sand without cohesion beside a smooth wall stands under k0, its surface on a row of nodes."""
    sand = {"mpm_material_soil_type": "mohr_coulomb", "mpm_material_soil_cohesion": 0, "mpm_material_soil_friction": 30,
            "mpm_bcs": "east,base", "mpm_boundaries": "wall", "mpm_boundary_wall_type": "plane", "mpm_boundary_wall_point": "1,0",
            "mpm_boundary_wall_normal": "1,0", "mpm_body_ground_lower": "1,1", "mpm_body_bed_lower": "1,0",
            "mpm_stage_rest_geostatic_k0": 0.5, "mpm_output_every": 1}
    push = 0.5 * (0.5 * 20e3 * 4**2 + 20e3 * 4 + 0.5 * 26e3)  # two layers
    for shape in ("gimp", "bspline2", "gimp_bspline2"):
        run = test.run(LEVEL, ranks=3 if shape == "bspline2" else 1, mpm_shape=shape, **sand)
        test.check(f"wall_{shape}.force", difference(run.results.column("reaction_wall_x"), push), None, 1e-7)
        test.check(f"wall_{shape}.moved", np.max(np.abs(run.table("displacement"))) / HEIGHT, None, 2e-9)
    run = test.run(LEVEL, mpm_shape="bspline3", status=3, **sand)
    test.check("wall_bspline3.line", "bspline3 with F-bar may need tension" in run.errors, True, True)
    motion = {"explicit": {"mpm_stage_hold_time_integrator": "explicit", "mpm_stage_hold_time_end": 0.05, "mpm_stage_hold_time_step": 5e-4},
              "relaxation": {"mpm_stage_hold_type": "relaxation", "mpm_stage_hold_time_step": 1e-4}}
    for label, options in (("stick", {"mpm_boundary_wall_friction": "stick"}), ("augmented", {"mpm_boundary_wall_method": "augmented"})):
        for way, stage in motion.items():  # soft penalties; a pressure that each step corrects would excite the wall
            run = test.run(LEVEL, **{**sand, "mpm_material_rock_E": 5e7, **options, **stage})
            test.check(f"wall_{label}_{way}.moved", np.max(np.abs(run.table("displacement"))) / HEIGHT, None, 2e-9)


def slope(test):
    """A block on a slope that friction holds."""
    run = test.run(INCLINED, **STAGES)
    force = run.results.column("force_ab_y")
    test.check("slope.force", difference(force, force[0]), None, 1e-9)
    test.check("slope.moved", np.max(np.abs(run.table("displacement"))) / HEIGHT, None, 2e-9)


with Test() as check:
    level(check)
    floor(check)
    layers(check)
    plate(check)
    wall(check)
    slope(check)
