#!/usr/bin/env python3
"""A body that starts with a spin: the angle after a quarter of a turn, kinetic energy and angular momentum of a rigid body,
by shapes and integrators, in 3D, and where nothing has inertia.

Quick.
"""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import Test, difference  # noqa: E402

SCENE = Path(__file__).resolve().parent / "spin.yaml"
SPIN = 2.0


def turned(test, label, options, angle=2e-3, energy=1e-2, ranks=1):
    """Turns by omega t about the centre of mass, which flies on; energy of translation and rotation, by the points' masses."""
    run = test.run(SCENE, ranks=ranks, mpm_quiet=None, **options)
    results, first = run.results, run.results.state(0)
    x, mass, time = first["position"], first["mass"], results.column("time")[-1]
    centre = mass @ x / mass.sum()
    inertia = mass @ ((x - centre) ** 2).sum(axis=1)
    state = results.state("last")
    r0, r1 = x - centre, state["position"] - mass @ state["position"] / mass.sum()
    moment = mass @ (r0[:, 0] * r1[:, 1] - r0[:, 1] * r1[:, 0]), mass @ (r0[:, :2] * r1[:, :2]).sum(axis=1)
    test.near(f"{label}.angle", np.arctan2(*moment), SPIN * time, relative=angle)
    test.near(f"{label}.flight", (mass @ state["position"] / mass.sum() - centre)[0], time, relative=1e-6)
    kinetic = 0.5 * mass.sum() + 0.5 * SPIN**2 * inertia
    test.near(f"{label}.energy", results.column("energy_kinetic")[-1], kinetic, relative=energy)
    test.check(f"{label}.account", abs(results.column("energy_balance")[0]) / kinetic, None, 1e-3)
    return state["position"]


with Test() as test:
    one = turned(test, "explicit", {})
    three = turned(test, "ranks", {}, ranks=3)
    test.check("ranks", difference(one, three), None, 1e-9)
    turned(test, "gimp", {"mpm_shape": "gimp"}, angle=5e-3, energy=1e-2)
    turned(test, "gimp_bspline2", {"mpm_shape": "gimp_bspline2"})
    turned(test, "flip", {"mpm_time_transfer": "flip"}, angle=3e-2, energy=2e-2)
    turned(test, "implicit", {"mpm_time_integrator": "newmark", "mpm_time_step": 0.02})
    solid = {"mpm_dim": 3, "mpm_grid_lower": "0,0,0", "mpm_grid_upper": "2,2,2", "mpm_grid_cells": "8,8,8", "mpm_body_disc_center": "1,1,1",
             "mpm_body_disc_points_per_cell": "2,2,2",
             "mpm_body_disc_velocity": "0,0,0", "mpm_body_disc_spin": "1,2,3", "mpm_track_rim_at": "1.4,1,1",
             "mpm_track_middle_at": "1,1,1", "mpm_time_end": 0.02}
    ball = test.run(SCENE, mpm_quiet=None, **solid).results.state(0)
    test.check("ball.velocity", difference(np.cross([1.0, 2.0, 3.0], ball["position"] - 1.0), ball["velocity"]), None, 1e-12)
    refused = test.run(SCENE, status=2, mpm_time_integrator="quasistatic", mpm_time_step=0.1)
    test.check("refused", float("-mpm_body_disc_" in refused.errors), 1, 1)
