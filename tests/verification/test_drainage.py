#!/usr/bin/env python3
"""Water through surfaces of bodies: settlement against theory while the drained top sinks through the grid, water that leaves
is volume that pores lose, a drained rim between nodes; on any number of ranks and over a restart."""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import Test, difference  # noqa: E402

HERE = Path(__file__).resolve().parent
LAYER, RIM = HERE / "layer.yaml", HERE / "rim.yaml"
HEIGHT, VELOCITY, J_INF = 10.0, 0.04, 0.792064218209  # m; c_v, m2/s; Uzuoka and Borja's law makes the problem linear


def settlement(time):
    """Exact: H (1 - J_inf) U(T)."""
    root = np.pi * (np.arange(2000) + 0.5)
    return HEIGHT * (1 - J_INF) * (1 - np.sum(2 / root**2 * np.exp(-np.outer(time, root**2) * VELOCITY / HEIGHT**2), axis=1))


def lost(run):
    """Volume that the points have lost."""
    volume, stretch = run.table("volume"), np.linalg.det(run.table("F").reshape(-1, 3, 3))
    return np.sum(volume / stretch - volume)


def layer(test):
    """Settlement is outflow over the width. It follows theory, slows down all the time, and nothing jumps at the nodes."""
    alone = test.run(LAYER, snes_rtol=1e-11, mpm_checkpoint_every=10)
    history = alone.results
    time, outflow = history.column("time"), history.column("outflow_top")
    test.near("layer.force", history.column("reaction_base_y")[-1], 10e3, 1e-9)
    test.near("layer.lost", lost(alone), outflow[-1], 1e-9)
    late = time > 100  # earlier the layer of the water's flow is thinner than a cell
    test.check("layer.settlement", np.max(np.abs(outflow - settlement(time))[late]) / (HEIGHT * (1 - J_INF)), None, 0.012)
    speed = np.diff(np.append(0, outflow)) / np.diff(np.append(0, time))
    test.check("layer.slows", np.max(np.diff(speed)), None, 0)
    test.check("layer.newton", np.max(alone.newton), None, 5)
    for ranks in (2, 3, 4):
        run = test.run(LAYER, ranks=ranks, snes_rtol=1e-11)
        test.check(f"layer_on_{ranks}.same", difference(alone.table("pressure"), run.table("pressure")), None, 1e-8)
        test.near(f"layer_on_{ranks}.outflow", run.results.column("outflow_top")[-1], outflow[-1], 1e-9)
    run = test.run(LAYER, ranks=2, snes_rtol=1e-11, mpm_restart=min(alone.folder.glob("layer_checkpoint_*.h5")))
    test.check("layer_again.same", difference(alone.table("pressure"), run.table("pressure")), None, 1e-9)
    test.near("layer_again.outflow", run.results.column("outflow_top")[-1], outflow[-1], 1e-10)
    smooth = test.run(LAYER, mpm_shape="gimp_bspline2")
    test.check("layer_smooth.settlement", np.max(np.abs(smooth.results.column("outflow_top") - outflow)[late]), None, 0.02)
    fbar = test.run(LAYER, mpm_stabilization_fbar="true", snes_rtol=1e-11)
    test.near("layer_fbar.lost", lost(fbar), fbar.results.column("outflow_top")[-1], 1e-9)
    test.check("layer_fbar.settlement", np.max(np.abs(fbar.results.column("outflow_top") - outflow)[late]), None, 0.02)


def short(test):
    """In steps so short that only a skin of a few hundredths of a cell drains, no row of cells loses its water."""
    run = test.run(LAYER, mpm_time_step=2e-3, mpm_time_growth=1, mpm_time_step_max=2e-3, mpm_time_end=2e-2)
    history = run.results
    test.check("short.outflow", history.column("outflow_top")[-1] / settlement(history.column("time"))[-1], 0.02, 1)


def plate(test):
    """A rigid plate that lets water through, and settles under its load, does what the same load and a drained surface do."""
    pressed = {"mpm_boundaries": "plate", "mpm_boundary_plate_type": "box", "mpm_boundary_plate_lower": "-1,10",
               "mpm_boundary_plate_upper": "2,11", "mpm_boundary_plate_load": "0,-10e3", "mpm_boundary_plate_load_ramp": "0:1",
               "mpm_boundary_plate_free": "y"}
    alone = test.run(LAYER, snes_rtol=1e-11, mpm_time_end=500)
    bare = {"mpm_surface_top_drained": "false", "mpm_surface_top_traction": "0,0"}
    run = test.run(LAYER, ranks=2, snes_rtol=1e-11, mpm_time_end=500, mpm_boundary_plate_drained="true", **pressed, **bare)
    test.near("plate.outflow", run.results.column("outflow_plate")[-1], alone.results.column("outflow_top")[-1], 1e-8)
    test.near("plate.lost", lost(run), run.results.column("outflow_plate")[-1], 1e-9)
    second = {"mpm_time_scheme": "second", "snes_rtol": 1e-11, "mpm_time_end": 500}
    alone, run = test.run(LAYER, **second), test.run(LAYER, mpm_boundary_plate_drained="true", **second, **pressed, **bare)
    test.near("plate_second.outflow", run.results.column("outflow_plate")[-1], alone.results.column("outflow_top")[-1], 1e-7)
    test.near("plate_second.lost", lost(run), run.results.column("outflow_plate")[-1], 1e-8)
    sealed = test.run(LAYER, mpm_time_end=500, **pressed, **bare)
    test.check("plate.sealed", abs(lost(sealed)), None, 1e-7)


def pressure(test):
    """A prescribed pressure that grows with its ramp: in the end all water has it, and none flows."""
    run = test.run(LAYER, mpm_surface_top_drained="false", mpm_surface_top_pressure=4e3, mpm_surface_top_ramp="0:1",
                   mpm_time_end=20000, mpm_time_step_max=1000)
    test.check("pressure.all", np.max(np.abs(run.table("pressure") - 4e3)) / 4e3, None, 1e-5)
    volume = run.table("volume")
    test.near("pressure.stress", np.sum(run.table("stress")[:, 1] * volume) / volume.sum(), -6e3, 2e-3)


def rim(test):
    """The pressure at the disc's centre over that on its rim, at T = c_v t/a^2."""
    run = test.run(RIM, ranks=2)
    middle = np.argsort(np.hypot(*run.results.initial["position"][:, :2].T))[:4]
    for step, exact in ((10, 1.1228), (100, 0.7761)):  # T = 0.02, 0.2
        test.near(f"rim_{step}", np.mean(run.table("pressure", step)[middle]) / 1e3, exact, 0.04)


def well(test):
    """What a well brings in leaves through the top, under a pressure that falls in proportion above the well."""
    run = test.run(LAYER, ranks=2, mpm_material_clay_type="linear_elastic", mpm_material_clay_permeability_law="constant",
                   mpm_surface_top_traction="0,0", mpm_loads="well", mpm_load_well_type="flux", mpm_load_well_value=1e-5,
                   mpm_load_well_ramp="0:1", mpm_load_well_region="box", mpm_load_well_lower="0,2", mpm_load_well_upper="1,2.5",
                   mpm_time_end=20000, mpm_time_step_max=1000, mpm_time_scheme="second")
    outflow, time = run.results.column("outflow_top"), run.results.column("time")
    test.near("well.outflow", (outflow[-1] - outflow[-2]) / (time[-1] - time[-2]), 1e-5, 1e-6)
    height, pressure_there = run.results.initial["position"][:, 1], run.table("pressure")
    above = height > 3
    test.check("well.pressure", np.max(np.abs(pressure_there - 10.0 * (10 - height))[above]) / 70, None, 1e-3)
    test.check("well.below", np.ptp(pressure_there[height < 1.5]) / 70, None, 1e-4)


with Test() as check:
    layer(check)
    short(check)
    well(check)
    plate(check)
    pressure(check)
    rim(check)
