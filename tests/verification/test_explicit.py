#!/usr/bin/env python3
"""Explicit steps: a bar's period, orders in time, stable near the limit, no matrix, restarts, ranks, what is refused, points that leave, and what is left then;
a heap that goes through stages of all kinds.

Quick.
"""
import sys
from pathlib import Path

import h5py
import numpy as np

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))
from talus_test import Test, difference  # noqa: E402

BAR, HEAP = HERE / "explicit_bar.yaml", HERE / "explicit_heap.yaml"
THROWN = """
mpm:
  dim: 3
  grid: {lower: "0,0,0", upper: "3,1.5,1", cells: "18,9,6", outflow: true}
  shape: bspline2
  materials: rubber
  material_rubber: {type: neo_hookean, E: 2e5, nu: 0.25, density: 1200}
  bodies: block
  body_block: {region: box, lower: "0.1,0.5,0.25", upper: "1.9,1,0.75", points_per_cell: "2,2,2", material: rubber, velocity: "1.5,0,0"}
  time: {integrator: explicit, end: 1.5}
  output: {prefix: thrown, every: 7, grid: true}
"""
PERIOD, STATIC = 4.0, 5e-3  # s; of the tip, m


def vibration(test):
    """The tip goes from 0 to twice its static displacement and back in a period; each way of updating the stress."""
    for update in ("musl", "usl", "usf"):
        run = test.run(BAR, mpm_quiet=None, mpm_time_update=update)
        tip = run.results.column("track_tip_ux")
        test.near(f"{update}.most", tip.max(), 2.0 * STATIC, relative=0.03)
        test.near(f"{update}.time", run.results.column("time")[tip.argmax()], 0.5 * PERIOD, relative=0.03)
        test.check(f"{update}.back", abs(tip[-1]), None, 0.03 * STATIC)
        test.check(f"{update}.newton", run.results.column("newton").max(), 0, 0)


def orders(test):
    """A stage's end has places and velocities of one time, of second order in the step, whether a weight comes at once or grows; a block falls
    as it should."""
    for update in ("musl", "usf"):
        for name, ramp, bounds in (("sudden", "0:1", (1.5e-4, 5e-4)), ("growing", "0:0,1:1", (1.5e-4, 1.5e-4))):
            ends = [test.run(BAR, mpm_quiet=None, mpm_time_update=update, mpm_time_step=1 / steps, mpm_time_end=1, mpm_load_weight_value="1e-4,0",
                             mpm_load_weight_ramp=ramp, mpm_output_every=1000).results.state("last") for steps in (40, 80, 160)]
            for field, bound in zip(("displacement", "velocity"), bounds):
                scale = np.sqrt((ends[2][field] ** 2).mean())
                change = [np.sqrt(((a[field] - b[field]) ** 2).mean()) / scale for a, b in zip(ends, ends[1:])]
                test.check(f"{update}.{name}.{field}", change[1], None, bound)
                if field == "velocity":
                    test.check(f"{update}.{name}.{field}_ratio", change[0] / change[1], 3.5)
    text = (HERE / "free_fall.yaml").read_text(encoding="utf-8")
    path = test.folder() / "fall.yaml"
    path.write_text(text.replace("integrator: newmark, step: 0.02", "integrator: explicit"), encoding="utf-8")
    run = test.run(path, mpm_quiet=None, mpm_output_every=1000)
    fall = run.results.state("last")
    test.check("fall.way", np.abs(fall["displacement"][:, 1] / (-0.5 * 9.81 * fall.time**2) - 1.0).max(), None, 1e-12)
    test.check("fall.speed", np.abs(fall["velocity"][:, 1] / (-9.81 * fall.time) - 1.0).max(), None, 1e-12)


def two_stages(test):
    """The half kicks where a stage ends and the next one begins are the whole one between two steps, but for another way to the points."""
    text = BAR.read_text(encoding="utf-8").replace("transfer: flip, end: 4", "transfer: flip, step: 0.025, end: 1")
    one, two = test.folder() / "one.yaml", test.folder() / "two.yaml"
    one.write_text(text, encoding="utf-8")
    two.write_text(text.replace("end: 1", "end: 0.5").rstrip() + "\n  stages: first,second\n", encoding="utf-8")
    for update in ("musl", "usl", "usf"):
        ends = [test.run(path, mpm_quiet=None, mpm_time_update=update, mpm_output_every=1000).results for path in (one, two)]
        states = [results.state("last") for results in ends]
        for field in ("displacement", "velocity", "stress"):
            test.check(f"two_stages.{update}.{field}", difference(states[0][field], states[1][field]), None, 2e-4)
        work = [results.column("energy_external")[-1] for results in ends]
        test.check(f"two_stages.{update}.work", abs(work[1] / work[0] - 1), None, 1e-5)
        balance = [results.column("energy_balance")[-1] for results in ends]
        test.check(f"two_stages.{update}.balance", abs(balance[1] - balance[0]) / abs(work[0]), None, 1e-5)


def stability(test):
    """With steps near the limit no energy grows, and little is lost."""
    for update, shape in (("musl", "gimp"), ("usl", "gimp"), ("musl", "linear"), ("usl", "bspline2")):
        run = test.run(BAR, mpm_quiet=None, mpm_time_cfl=0.9, mpm_time_end=20 * PERIOD, mpm_time_transfer="apic", mpm_time_update=update,
                       mpm_shape=shape)
        energy, time = run.results.column("energy_kinetic") + run.results.column("energy_elastic"), run.results.column("time")
        test.check(f"stable.{update}.{shape}", energy[time > 19 * PERIOD].max() / energy[time < PERIOD].max(), 0.9, 1.0)


def no_matrix(test):
    """PETSc makes no matrix, no nonlinear and no linear solver."""
    run = test.run(BAR, mpm_quiet=None, log_view=":log.txt", mpm_time_end=0.5, mpm_jacobian="coloring", mpm_solver="auto",
                   mpm_stabilization_ghost=0.1, mpm_multigrid_levels=3)
    told = [f"talus: warning: -mpm_{option}: not used, all stages are explicit" for option in
            ("jacobian coloring", "multigrid_levels 3", "stabilization_ghost 0.1")]
    test.check("unused", float(run.errors.strip().splitlines() == told), 1, 1)
    made = [line for line in (run.folder / "log.txt").read_text().splitlines()
            if line.strip().startswith(("Matrix ", "SNES ", "Krylov Solver ", "Preconditioner "))]
    test.check("objects", len(made), 0, 0)
    test.check("summary.solver", run.results.summary["solver"] == "none", 1, 1)


def going_on(test):
    """A run that goes on from a checkpoint on two ranks ends as the undisturbed one; to the bit on as many, also where it had ended earlier."""
    whole = test.run(BAR, mpm_quiet=None, mpm_checkpoint_every=50, mpm_checkpoint_keep=5)
    rest = test.run(BAR, ranks=2, mpm_quiet=None, mpm_restart=whole.folder / "explicit_bar_checkpoint_000050.h5")
    several = test.run(BAR, ranks=3, mpm_quiet=None)
    states = test.run(BAR, mpm_quiet=None, mpm_time_step=0.02, mpm_time_end=0.1, mpm_output_every=1)
    with h5py.File(f"{states.prefix}.h5") as file:
        behind = [group.attrs.get("velocities_behind", 0.0) for group in file["points"].values()]
    test.check("behind", max(abs(a - b) for a, b in zip(behind, (0, 0.01, 0.01, 0.01, 0.01, 0), strict=True)), None, 1e-15)
    for name in ("track_tip_ux", "track_tip_vx", "reaction_wall_x", "energy_kinetic"):
        one = whole.results.column(name)
        after = rest.results.column(name)
        test.check(f"restart.{name}", difference(one, np.concatenate((one[: -after.size], after))), None, 1e-12)
        test.check(f"ranks.{name}", difference(one, several.results.column(name)), None, 1e-11)
    options = {"mpm_quiet": None, "mpm_time_step": 0.02, "mpm_output_every": 1000}
    whole = test.run(BAR, mpm_time_end=0.3, **options)
    half = test.run(BAR, mpm_time_end=0.14, mpm_checkpoint_every=1000, **options)
    rest = test.run(BAR, mpm_time_end=0.3, mpm_restart=half.folder / "explicit_bar_checkpoint.h5", **options)
    test.check("ended_earlier.history", max(np.abs(whole.results.column(name)[7:] - rest.results.column(name)).max()
                                            for name in ("time", "track_tip_vx", "energy_kinetic", "energy_balance")), 0, 0)
    for field in ("position", "velocity", "stress"):
        test.check(f"ended_earlier.{field}", difference(whole.results.state("last")[field], rest.results.state("last")[field]), 0, 0)
    again = test.run(BAR, mpm_time_end=0.14, mpm_restart=half.folder / "explicit_bar_checkpoint.h5", **options)  # no step is left
    stages = test.folder() / "stages.yaml"
    stages.write_text(BAR.read_text(encoding="utf-8").replace("end: 4", "step: 0.02").replace(
        "prefix: explicit_bar, every: 0", "prefix: stages, every: 1000")
        + "  stages: one,two\n  stage_one: {time: {end: 0.1}}\n  stage_two: {time: {end: 0.04}}\n", encoding="utf-8")
    whole = test.run(stages, mpm_quiet=None, mpm_checkpoint_every=5)
    rest = test.run(stages, mpm_quiet=None, mpm_restart=whole.folder / "stages_checkpoint_000005.h5")
    for field in ("position", "velocity", "stress"):
        for label, one, other in (("no_step_left", half, again), ("at_stage_end", whole, rest)):
            test.check(f"{label}.{field}", difference(one.results.state("last")[field], other.results.state("last")[field]), 0, 0)


def refused(test):
    """Steps above the limit, and points that leave, in one line."""
    run = test.run(BAR, status=2, mpm_quiet=None, mpm_time_step=0.06)
    test.check("step.line", len(run.errors.strip().splitlines()), 1, 1)
    test.check("step.names", "-mpm_time_step 0.06: must not exceed 0.05" in run.errors, 1, 1)
    thrown = {"mpm_quiet": None, "mpm_body_bar_velocity": "2,0", "mpm_bc_wall_components": "y"}
    run = test.run(BAR, status=3, **thrown)
    test.check("left.names", " left the grid at (12." in run.errors, 1, 1)
    for name, step in (("explicit", None), ("backward_euler", 0.05)):
        path = test.folder() / "bar.yaml"
        path.write_text(BAR.read_text(encoding="utf-8").replace("cfl: 0.5, ", "" if step else "cfl: 0.5, "), encoding="utf-8")
        options = {"mpm_time_integrator": name, "mpm_time_step": step} if step else {}
        run = test.run(path, ranks=2, mpm_grid_outflow=None, mpm_output_every=1000000, mpm_time_end=3, **thrown, **options)
        left = run.results.state("last")["position"]
        test.near(f"outflow.{name}.remaining", left.shape[0], 96, absolute=4)
        test.check(f"outflow.{name}.inside", left[:, 0].max(), None, 12.0)


def leaving(test):
    """What flies out of the grid, point by point, leaves momentum and energy of the rest as they should be, and the grid's output its mass."""
    scene = test.folder() / "thrown.yaml"
    scene.write_text(THROWN, encoding="utf-8")
    for name, ranks in (("explicit", 1), ("explicit", 3), ("newmark", 2)):
        more = {} if name == "explicit" else {"mpm_time_step": 0.02}
        results = test.run(scene, ranks=ranks, mpm_quiet=None, mpm_time_integrator=name, **more).results
        energy, momentum = results.column("energy_kinetic"), results.column("momentum_x")
        test.check(f"leaving.{name}.{ranks}.energy", np.abs(energy / momentum / 0.75 - 1.0).max(), None, 1e-11)
        test.check(f"leaving.{name}.{ranks}.balance", np.abs(results.column("energy_balance")).max() / energy[0], None, 1e-11)
        left = results.state("last")["mass"].sum()
        test.near(f"leaving.{name}.{ranks}.left", left * 1.5, momentum[-1], relative=1e-11)
        test.check(f"leaving.{name}.{ranks}.some", left / (momentum[0] / 1.5), 0.3, 0.6)
        with h5py.File(f"{results.prefix}.h5") as file:
            off = [file[f"grid/{key}/nodes/mass"][()].sum() / file[f"points/{key}/mass"][()].sum() - 1.0 for key in file["points"]]
        test.check(f"leaving.{name}.{ranks}.grid", np.abs(off).max(), None, 1e-12)


def stages(test):
    """Geostatic, explicit, relaxation, quasi-static: what comes to rest stays there."""
    runs = [test.run(HEAP, ranks=ranks, mpm_quiet=None) for ranks in (1, 2)]
    stage, crest = (runs[0].results.column(name) for name in ("stage", "track_crest_uy"))
    last = np.flatnonzero(stage == 3)[-1]
    for name in ("K_F", "K_E"):
        test.check(f"stages.{name}", runs[0].results.column(name)[last], 0.0, 0.05)
    test.check("stages.resets", runs[0].results.column("resets")[last], 1)
    test.check("stages.time", runs[0].results.column("time")[last], 2.0, 41.9)
    test.check("stages.fall", crest[last], None, -1.0)
    test.near("stages.rest", crest[-1], crest[last], relative=5e-3)
    test.check("stages.ranks", abs(crest[-1] - runs[1].results.column("track_crest_uy")[-1]) / abs(crest[-1]), None, 1e-2)


def relaxation(test):
    """Times of a linear bar's relaxation: when both criteria hold first, and since when without a break."""
    linear = {"mpm_load_pull_value": "1e-6,0", "mpm_stage_rest_relaxation_tolerance": 1e-6, "mpm_quiet": None}
    for update, damping, end, first, always in (("musl", "kinetic", 30, 16.91, 24.84), ("usl", "kinetic", 30, 20.23, 23.60),
                                                ("usl", "0.157", 65, 49.03, 60.24)):
        viscous = {} if damping == "kinetic" else {"mpm_stage_rest_relaxation_damping": "viscous", "mpm_stage_rest_relaxation_xi": damping}
        run = test.run(HERE.parent.parent / "examples" / "relaxation_bar" / "case.yaml", status=None, mpm_stage_rest_time_end=end,
                       mpm_stage_rest_time_update=update, **linear, **viscous)
        time = run.results.column("time")
        good = (run.results.column("K_F") < 0.01) & (run.results.column("K_E") < 0.01)
        test.near(f"relaxation.{update}.{damping}.first", time[good][0], first, relative=0.01)
        test.near(f"relaxation.{update}.{damping}.always", time[~good][-1], always, relative=0.01)


def rests(test):
    """Without `hold` a relaxation ends in its static state, and with zero where the criteria hold first, whatever forces they compare."""
    case = test.folder() / "bar.yaml"
    case.write_text((HERE.parent.parent / "examples" / "relaxation_bar" / "case.yaml").read_text().replace(", hold: 40", ""))
    for damping, update in (("kinetic", "usl"), ("0.157", "musl")):
        more = {} if damping == "kinetic" else {"mpm_stage_rest_relaxation_damping": "viscous", "mpm_stage_rest_relaxation_xi": damping}
        run = test.run(case, mpm_stage_rest_time_update=update, mpm_quiet=None, **more)
        test.near(f"rests.{damping}.{update}", run.results.column("track_middle_ux")[-1], 4.75e-3, relative=1e-3)
    for balance, passing, ranks in (("nodes", 16.96, 1), ("points", 16.74, 1), ("points", 16.74, 3)):
        run = test.run(case, ranks=ranks, mpm_stage_rest_relaxation_hold=0, mpm_stage_rest_relaxation_balance=balance, mpm_quiet=None)
        test.near(f"rests.passing.{balance}.{ranks}", run.results.column("time")[-1], passing, absolute=0.02)
        test.check(f"rests.not.{balance}.{ranks}", run.results.column("track_middle_ux")[-1] / 4.75e-3, 1.02, 1.05)


def ramps(test):
    """A relaxation rests once loads, supports and strengths are at their ends, and never before anything has moved."""
    scene = HERE / "relaxation_ramp.yaml"
    for ranks in (1, 3):
        run = test.run(scene, ranks=ranks, mpm_quiet=None)
        test.near(f"ramps.load.{ranks}.displacement", run.results.column("track_t_uy")[-1], -0.0116, relative=0.02)
        test.check(f"ramps.load.{ranks}.factor", run.results.column("load")[-1], 1, 1)
    late = test.run(scene, mpm_quiet=None, mpm_load_g_ramp="0:0,2:0.5,8:0.5,9:1", mpm_stage_fall_relaxation_damping="local")
    test.check("ramps.late", late.results.column("time")[-1], 9.0, 30.0)
    push = {"mpm_bcs": "f,push", "mpm_bc_push_region": "box", "mpm_bc_push_lower": "0,1", "mpm_bc_push_upper": "6,1",
            "mpm_bc_push_components": "y", "mpm_load_g_ramp": "0:1", "mpm_quiet": None}
    support = test.run(scene, mpm_bc_push_value=-0.02, mpm_bc_push_ramp="0:0,5:0,6:1", **push)
    test.check("ramps.support.time", support.results.column("time")[-1], 6.0, 59.0)
    for ramp in ("0:0", "0:0,30:0,60:1"):
        run = test.run(scene, status=3, mpm_quiet=None, mpm_load_g_ramp=ramp)
        line = "nothing has moved" if ramp == "0:0" else "loads, conditions or strengths change until 60"
        test.check(f"ramps.{ramp}", float(line in run.errors), 1, 1)


def scaled_masses(test):
    """With scaled masses a bar whose fixed half is stiff comes to the same rest in a fraction of the steps, by any damping and on any ranks."""
    static = 1e-3 * (5.0 / 400.0 + 4.875)
    runs = {}
    for mass, ranks, more in (("physical", 1, {}), ("scaled", 1, {}), ("scaled", 3, {}),
                              ("scaled", 1, {"mpm_stage_rest_relaxation_damping": "viscous", "mpm_stage_rest_relaxation_xi": 0.3})):
        run = test.run(HERE / "graded_bar.yaml", ranks=ranks, mpm_quiet=None, mpm_stage_rest_relaxation_nodal_mass=mass, **more)
        key = f"{mass}.{ranks}.{'viscous' if more else 'kinetic'}"
        runs[key] = run.results.column("step")[-1]
        test.near(f"{key}.tip", run.results.column("track_tip_ux")[-1], static, relative=2e-3)
        test.near(f"{key}.wall", run.results.column("reaction_wall_x")[-1], -1e-3, relative=1e-3)
    test.check("scaled.steps", runs["scaled.1.kinetic"] / runs["physical.1.kinetic"], None, 0.2)
    test.check("scaled.ranks", abs(runs["scaled.1.kinetic"] - runs["scaled.3.kinetic"]), 0, 0)


def offered(test):
    """Where Newton's method finds no state of rest, relaxation is named."""
    run = test.run(HERE.parent.parent / "examples" / "collapse" / "case.yaml", status=3, mpm_quiet=None, mpm_time_step=1, mpm_time_step_min=0.9)
    test.check("offered", "a stage of type relaxation may find it" in run.errors, 1, 1)
    test.check("offered.lines", len(run.errors.strip().splitlines()), 1, 1)


with Test() as test:
    vibration(test)
    orders(test)
    two_stages(test)
    stability(test)
    no_matrix(test)
    going_on(test)
    refused(test)
    leaving(test)
    stages(test)
    relaxation(test)
    ramps(test)
    rests(test)
    scaled_masses(test)
    offered(test)
    test.check_example("relaxation_bar", test.run(HERE.parent.parent / "examples" / "relaxation_bar" / "case.yaml", mpm_quiet=None,
                                                  mpm_output_every=1000000), "relaxation_bar")
