#!/usr/bin/env python3
"""Contact of bodies in explicit steps: momentum and angular momentum to rounding, friction, rest, restarts and ranks; what is refused.

Quick.
"""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import Test, difference  # noqa: E402

HERE = Path(__file__).resolve().parent
BALLS, BLOCKS = HERE / "explicit_balls.yaml", HERE / "explicit_blocks.yaml"


def collision(test):
    """A ball hits a box: both momenta stay, energy does not grow, neither enters the other; the same after a restart and on other ranks."""
    whole = test.run(BALLS, mpm_checkpoint_every=40, mpm_checkpoint_keep=9)
    column, first = whole.results.column, whole.results.state("first")
    momentum, angular = (np.array([column(f"{name}_{axis}") for axis in "xyz"]) for name in ("momentum", "angular_momentum"))
    scale = 0.5 * first["mass"].sum() * 0.6
    test.check("collision.momentum", np.abs(momentum - momentum[:, :1]).max() / scale, None, 1e-12)
    test.check("collision.angular", np.abs(angular - angular[:, :1]).max() / scale, None, 1e-12)
    energy = column("energy_kinetic") + column("energy_elastic")
    test.check("collision.energy", energy.max() / energy[0], None, 1.0 + 1e-10)
    test.check("collision.taken", column("energy_dissipated")[-1] / energy[0], 0.0, 0.1)
    of_ball = first["position0"][:, 0] < 0.9
    speed = [np.average(whole.table("velocity")[of, 0], weights=first["mass"][of]) for of in (of_ball, ~of_ball)]
    test.check("collision.parted", speed[1] - speed[0], 0.1, 1.1)
    nearest = min(np.linalg.norm(state["position"][~of_ball] - point, axis=1).min()
                  for state in (whole.results.state(step) for step in whole.results.steps) for point in state["position"][of_ball])
    test.check("collision.nearest", nearest, 0.025)
    for label, ranks, more in (("ranks", 3, {}), ("restart", 2, {"mpm_restart": whole.folder / "balls_checkpoint_000040.h5"})):
        run = test.run(BALLS, ranks=ranks, **more)
        for name in ("position", "velocity", "stress"):
            test.check(f"{label}.{name}", difference(whole.table(name), run.table(name)), None, 1e-11)


def on_plane(test):
    """The block's scene with a plane in place of the base."""
    lines = [line for line in BLOCKS.read_text(encoding="utf-8").splitlines()
             if not line.lstrip().startswith(("contact", "bodies", "body_base", "bc"))]
    path = test.folder() / "blocks.yaml"
    path.write_text("\n".join(lines + ["  bodies: block", "  boundaries: ab",
                                       '  boundary_ab: {type: plane, point: "0,0.25", normal: "0,1", friction: 0.3}\n']), encoding="utf-8")
    return path


def rest(test):
    """A block at rest on a body, or on a plane, stays there, also where the stage's end cuts the last step."""
    for label, path, column, more in (("body", BLOCKS, "force_ab_y", {}), ("plane", on_plane(test), "reaction_ab_y", {}),
                                      ("spline", BLOCKS, "force_ab_y", {"mpm_shape": "gimp_bspline2"})):
        run = test.run(path, mpm_stage_moving_time_end=0.1, **more)
        moving = run.results.column("stage") == 2
        force, fall = np.abs(run.results.column(column)), run.results.column("track_middle_uy")
        test.check(f"rest.{label}.force", np.abs(force[moving] / (0.5 * 1000 * 10) - 1).max(), None, 0.2)
        kinetic, elastic = run.results.column("energy_kinetic")[moving], run.results.column("energy_elastic")
        test.check(f"rest.{label}.kinetic", kinetic.max() / elastic[~moving][-1], None, 0.06)
        # the load came at once: its work is twice what is stored, and the rest is missing
        test.near(f"rest.{label}.work", run.results.column("energy_external")[~moving][-1] / elastic[~moving][-1], 2.0, relative=0.05)
        test.check(f"rest.{label}.last", kinetic[-1] / kinetic[:-1].max(), None, 1.5)
        test.check(f"rest.{label}.stays", np.abs(fall[moving] - fall[~moving][-1]).max(), None, 2e-4)


def slide(test):
    """Down a slope of 45 degrees a block moves as a rigid one with Coulomb's friction; below its angle it stays."""
    side = 10.0 / np.sqrt(2.0)
    path = test.folder() / "slide.yaml"
    lines = [line for line in BLOCKS.read_text(encoding="utf-8").splitlines() if "stage_still" not in line]
    path.write_text("\n".join(lines).replace("still,moving", "moving") + "\n", encoding="utf-8")
    column = test.run(path, mpm_load_weight_value=f"{side},{-side}").results.column
    way = column("track_middle_ux")[-1]
    test.near("slide.way", way, 0.5 * 0.7 * side * 0.4**2, relative=0.01)
    test.near("slide.friction", column("force_ab_x").sum() / column("force_ab_y").sum(), -0.3, relative=0.01)
    test.near("slide.heat", column("energy_dissipated")[-1], 0.3 * side * 500 * way, relative=0.1)
    for label, path, shape in (("gimp_bspline2", BLOCKS, "gimp_bspline2"), ("gimp", BLOCKS, "gimp"), ("plane_gimp", on_plane(test), "gimp")):
        column = test.run(path, mpm_load_weight_value="2.5,-10", mpm_shape=shape).results.column
        moving = column("stage") == 2
        gone = column("track_middle_ux")[moving] - column("track_middle_ux")[~moving][-1]
        test.check(f"slide.{label}.holds", np.abs(gone).max(), None, 1e-4)
        missing = column("energy_balance")[moving] - column("energy_balance")[~moving][-1]
        test.check(f"slide.{label}.balance", np.abs(missing).max() / column("energy_elastic")[~moving][-1], None, 0.15)


def crosses(test):
    """With linear shapes and affine velocities, too, points that come into cells touch nodes there with next to no mass."""
    path = on_plane(test)
    text = path.read_text(encoding="utf-8").replace("still,moving", "moving")
    path.write_text("\n".join(line for line in text.splitlines() if "stage_still" not in line), encoding="utf-8")
    for cfl in (0.5, 0.9):
        column = test.run(path, mpm_shape="linear", mpm_stage_moving_time_cfl=cfl, mpm_load_weight_value="8,-8").results.column
        test.near(f"crosses.{cfl}.way", column("track_middle_ux")[-1], 0.5 * 0.7 * 8 * 0.4**2, relative=0.01)
        test.check(f"crosses.{cfl}.balance", np.abs(column("energy_balance")).max() / column("energy_external")[-1], None, 0.02)


def stops(test):
    """What an explicit stage leaves in motion a quasi-static step stops; the next one does not go on from that."""
    path = on_plane(test)
    text = path.read_text(encoding="utf-8").replace("still,moving", "moving,stop")
    path.write_text(text.replace("stage_still: {time: {end: 1, step: 0.5}}", "stage_stop: {time: {end: 0.4, step: 0.1}}"), encoding="utf-8")
    for shape, weight in (("gimp", "2.5,-10"), ("gimp_bspline2", "0,-10")):
        column = test.run(path, mpm_shape=shape, mpm_load_weight_value=weight, mpm_stage_moving_time_end=0.03).results.column
        test.check(f"stops.{shape}.second", column("newton")[column("stage") == 2][1], None, 8)
        test.near(f"stops.{shape}.force", column("reaction_ab_y")[-1], 5000, relative=1e-6)


def refused(test):
    """A barrier has no answer where explicit steps would ask it."""
    run = test.run(BALLS, status=2, mpm_contact_lr_method="barrier")
    test.check("barrier.names", "-mpm_contact_lr_method barrier: " in run.errors, 1, 1)
    test.check("barrier.line", len(run.errors.strip().splitlines()), 1, 1)


with Test() as test:
    collision(test)
    rest(test)
    slide(test)
    crosses(test)
    stops(test)
    refused(test)
