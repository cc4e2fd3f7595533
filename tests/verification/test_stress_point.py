#!/usr/bin/env python3
"""The laboratory, one point without a grid: closed forms of laws along its paths, what each path holds, tables beside paths
with a name, Newton's iterations, steps that are cut, ranks, the examples triaxial and rubber_uniaxial, and scenes that it refuses.

Quick.
"""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import Run, Test, difference, example  # noqa: E402

E, NU = 30e6, 0.25
MODULUS, LAMBDA, G = E * (1 - NU) / ((1 + NU) * (1 - 2 * NU)), E * NU / ((1 + NU) * (1 - 2 * NU)), E / (2 * (1 + NU))
HENCKY = {"type": "hencky", "E": E, "nu": NU}
J2 = {"type": "j2", "E": E, "nu": NU, "yield_stress": 60e3, "hardening": 2e6}
PRAGER = {"type": "drucker_prager", "E": E, "nu": NU, "cohesion": 5e3, "friction": 33, "dilation": 10}
CONFINED = "-100e3,-100e3,-100e3,0,0,0"
SYM = ("xx", "yy", "zz", "xy", "yz", "xz")


def write_scene(folder, law, options):
    """A scene of one material and its point; `options` without mpm_point_, or with mpm_ or the name of PETSc's."""
    lines = {"mpm_dim": 3, "mpm_physics": "stress_point", "mpm_materials": "soil", "mpm_point_material": "soil",
             "mpm_output_prefix": "run", "mpm_quiet": "true"}
    lines.update({f"mpm_material_soil_{name}": value for name, value in law.items()})
    lines.update({name if name.startswith(("mpm_", "snes_")) else "mpm_point_" + name: value
                  for name, value in options.items()})
    path = folder / "scene.yaml"
    path.write_text("".join(f'{name}: "{value}"\n' for name, value in lines.items() if value is not None),
                    encoding="utf-8")
    return path


def start(test, law, ranks=1, files=(), **options):
    """A run in a folder of its own, whatever its end."""
    folder = test.folder()
    for name, text in files:
        (folder / name).write_text(text, encoding="utf-8")
    return Run(test.program, write_scene(folder, law, options), ranks, {}, folder)


def follow(test, law, status=0, **options):
    """The history of a run that must end with this status."""
    run = start(test, law, **options)
    if run.status != status:
        sys.exit(f"exit status {run.status} instead of {status}: {options}\n{run.output}\n{run.errors}")
    return run.results.history


def table_text(columns):
    """A CSV file of columns by name."""
    rows = zip(*columns.values())
    return "\n".join([",".join(columns)] + [",".join(f"{value:.17g}" for value in row) for row in rows]) + "\n"


def check_oedometer(test):
    """No lateral strain: tau = M e, lambda e, also on top of a stress at the start; sigma = tau/J."""
    for measure in ("kirchhoff", "cauchy"):
        for strain in ("log", "engineering"):
            history = follow(test, HENCKY, path="oedometer", end=-0.3, steps=3, measure=measure, strain=strain)
            e = history["strain_yy"] if strain == "log" else np.log(1 + history["strain_yy"])
            J = np.exp(e) if measure == "cauchy" else 1.0
            label = f"oedometer.{measure}.{strain}"
            test.check(label + ".rows", len(e), 3, 3)
            test.near(label + ".end", history["strain_yy"][-1], -0.3, absolute=1e-15)
            test.check(label + ".axial", difference(MODULUS * e / J, history["stress_yy"]), None, 1e-13)
            test.check(label + ".lateral", difference(LAMBDA * e / J, history["stress_xx"]), None, 1e-13)
            volume = e if strain == "log" else np.exp(e) - 1
            test.check(label + ".eps_v", difference(volume, history["eps_v"]), None, 1e-14)
    history = follow(test, HENCKY, path="oedometer", end=-0.1, steps=4, measure="kirchhoff", stress="-50e3,-80e3,-50e3,0,0,0")
    test.check("oedometer.from_stress", difference(-80e3 + MODULUS * history["strain_yy"], history["stress_yy"]), None, 1e-12)
    linear = {**HENCKY, "type": "linear_elastic"}
    history = follow(test, linear, path="oedometer", end=-0.02, strain="engineering", steps=5)
    test.check("oedometer.linear", difference(MODULUS * history["strain_yy"], history["stress_yy"]), None, 1e-13)
    history = follow(test, linear, path="triaxial_drained", end=-0.02, strain="engineering", steps=5)
    test.check("triaxial.linear", difference(E * history["strain_yy"], history["stress_yy"]), None, 1e-12)


def check_triaxial(test):
    """Laws that flow, in steps that pass their yield stress: on these paths backward Euler is exact."""
    history = follow(test, J2, path="triaxial_drained", end=-0.08, steps=16, measure="kirchhoff")
    e = -history["strain_yy"]
    q = np.where(e < 60e3 / E, E * e, (e + 60e3 / 2e6) / (1 / E + 1 / 2e6))
    test.check("j2.q", difference(q, history["q"]), None, 1e-12)
    test.check("j2.eps_v", difference(-(1 - 2 * NU) * q / E, history["eps_v"]), None, 1e-11)
    test.check("j2.hardening", difference(q[1:], 60e3 + 2e6 * history["equivalent_plastic_strain"][1:]), None, 1e-12)
    test.check("j2.newton", history["newton"].max(), 1, 4)
    cauchy = follow(test, J2, path="triaxial_drained", end=-0.08, steps=16, measure="cauchy")
    test.check("j2.cauchy", difference(q / np.exp(-(1 - 2 * NU) * q / E), cauchy["q"]), None, 1e-12)

    sine = [np.sin(np.radians(angle)) for angle in (33, 10)]
    slope, flow = (6 * s / (np.sqrt(3) * (3 - s)) for s in sine)
    size = 6 * np.cos(np.radians(33)) / (np.sqrt(3) * (3 - sine[0])) * 5e3
    for sign, path in ((1, "compression"), (-1, "extension")):
        history = follow(test, PRAGER, path="triaxial_drained", end=-0.05 * sign, steps=10, stress=CONFINED,
                         measure="kirchhoff")
        e = np.abs(history["strain_yy"])
        limit = (size + slope * 100e3) / (1 / np.sqrt(3) - sign * slope / 3)
        q = np.minimum(E * e, limit)
        gamma = (e - q / E) / (1 / np.sqrt(3) - sign * flow / 3)
        test.check(f"prager.{path}.q", difference(q, history["q"]), None, 1e-11)
        test.check(f"prager.{path}.p", difference(-100e3 - sign * q / 3, history["p"]), None, 1e-11)
        test.check(f"prager.{path}.eps_v", difference(flow * gamma - sign * (1 - 2 * NU) * q / E, history["eps_v"]), None, 1e-10)
        for name in ("stress_xx", "stress_zz"):
            test.check(f"prager.{path}.{name}", np.abs(history[name] + 100e3).max(), None, 1e-6)


def check_undrained(test):
    """Volume and, in the biaxial test, zz's strain are kept; eps_q and q by their definitions."""
    for strain in ("log", "engineering"):
        for path in ("triaxial_undrained", "biaxial_undrained"):
            history = follow(test, PRAGER, path=path, end=-0.1, steps=20, stress=CONFINED, strain=strain)
            test.check(f"{path}.{strain}.volume", np.abs(history["eps_v"]).max(), None, 1e-12)
            same = history["strain_xx"] if path.startswith("triaxial") else np.zeros(20)
            test.check(f"{path}.{strain}.zz", np.abs(history["strain_zz"] - same).max(), None, 0.0)
            test.check(f"{path}.{strain}.flows", history["q"][-1], 1e5)
    triaxial = follow(test, J2, path="triaxial_undrained", end=0.05, steps=5, measure="kirchhoff")
    test.near("undrained.eps_q", triaxial["eps_q"][-1], 0.05, 1e-14)
    test.near("undrained.q", triaxial["q"][-1], (3 * G * 2e6 * 0.05 + 3 * G * 60e3) / (3 * G + 2e6), 1e-12)
    drained = follow(test, PRAGER, path="biaxial_drained", end=-0.1, steps=20, stress=CONFINED)
    test.check("biaxial_drained.zz", np.abs(drained["strain_zz"]).max(), None, 0.0)
    test.check("biaxial_drained.xx", np.abs(drained["stress_xx"] + 100e3).max(), None, 1e-6)
    plane = follow(test, PRAGER, path="biaxial_drained", end=-0.1, steps=20, stress="-100e3,-100e3,-100e3,0", mpm_dim=2)
    for name in ("strain_xx", "stress_yy", "stress_zz", "q", "eps_v"):
        test.check(f"plane_strain.{name}", difference(drained[name], plane[name]), None, 1e-11)


def check_cauchy(test):
    """Hencky's law under a Cauchy stress that is held: with tau_r = sigma_r J and tau = 2 G e + lambda ln J."""
    history = follow(test, HENCKY, path="triaxial_drained", end=-0.2, steps=4, stress="-2e6,-2e6,-2e6,0,0,0")
    sym = np.array([history["stress_" + name] for name in SYM])
    bulk = LAMBDA + 2 * G / 3
    J0 = 1.0
    for _ in range(100):  # ln J_0 = J_0 p/K
        J0 = np.exp(J0 * -2e6 / bulk)
    e0 = np.log(J0) / 3
    for k, axial in enumerate(history["strain_yy"]):
        radial = history["strain_xx"][k]
        lnJ = 3 * e0 + axial + 2 * radial
        test.near(f"cauchy.radial_{k}", (2 * G * (e0 + radial) + LAMBDA * lnJ) / np.exp(lnJ), -2e6, 1e-11)
        test.near(f"cauchy.axial_{k}", (2 * G * (e0 + axial) + LAMBDA * lnJ) / np.exp(lnJ), sym[1, k], 1e-11)


def check_shear(test):
    """Simple shear turns principal axes: tau = 2 G ln V, with ln V by numpy."""
    history = follow(test, HENCKY, path="simple_shear", end=1.5, steps=6, measure="kirchhoff")
    for k, gamma in enumerate(0.25 * np.arange(1, 7)):
        F = np.array([[1, gamma, 0], [0, 1, 0], [0, 0, 1]])
        value, axes = np.linalg.eigh(F @ F.T)
        log = axes @ np.diag(0.5 * np.log(value)) @ axes.T
        found = np.array([history["strain_" + name][k] for name in SYM])
        stress = np.array([history["stress_" + name][k] for name in SYM])
        wanted = log[[0, 1, 2, 0, 1, 0], [0, 1, 2, 1, 2, 2]]
        test.check(f"simple_shear.strain_{k}", difference(wanted, found), None, 1e-14)
        test.check(f"simple_shear.stress_{k}", difference(2 * G * wanted, stress), None, 1e-13)
    history = follow(test, HENCKY, path="simple_shear", end=0.2, steps=2, strain="engineering", mpm_dim=2)
    test.near("simple_shear.engineering", history["strain_xy"][-1], 0.1, 1e-15)


def check_isotropic(test):
    for measure in ("cauchy", "kirchhoff"):
        history = follow(test, PRAGER, path="isotropic", end=400e3, steps=8, stress="-60e3,-90e3,-70e3,0,0,0", measure=measure)
        test.near(f"isotropic.{measure}.p", history["p"][-1], -400e3, 1e-10)
        test.check(f"isotropic.{measure}.q", history["q"][-1], None, 4e-5)
        test.near(f"isotropic.{measure}.half", history["stress_yy"][3], -(90e3 + 400e3) / 2, 1e-10)


def check_tables(test):
    """A table that says what a path with a name does gives the same rows; with rows between, and with shear."""
    path = follow(test, PRAGER, path="triaxial_drained", end=-0.05, steps=20, stress=CONFINED)
    hold = [-100e3, -100e3]
    columns = {"time": [0, 1], "stress_xx": hold, "strain_yy": [0, -0.05], "stress_zz": hold, "strain_xy": [0, 0]}
    table = follow(test, PRAGER, files=(("path.csv", table_text(columns)),), path="table", table="path.csv", steps=20,
                   stress=CONFINED)
    for name, column in path.items():
        if np.abs(column).max() > 0:
            test.check(f"table.{name}", difference(column, table[name]), None, 1e-13)
    columns = {"time": [2, 3, 7], "stress_yy": [-1e5, -1e5, -3e5], "strain_xx": [0.01, 0, 0.02],
               "strain_zz": [0, 0, 0.01], "stress_xy": [0, 4e4, -4e4], "strain_yz": [0, 0.02, 0]}
    table = follow(test, HENCKY, files=(("path.csv", "# remark\n" + table_text(columns)),), path="table",
                   table="path.csv", steps=14, measure="cauchy")
    test.check("table.rows", len(table["time"]), 14, 14)
    for name, column in columns.items():
        if name != "time":
            wanted = np.interp(table["time"], [0] + columns["time"], [0] + column)
            test.check(f"table.follows_{name}", difference(wanted, table[name]), None, 1e-11)
    columns = {"time": [0, 1, 4], "strain_xx": [0, 0, 0.1], "strain_yy": [0, 0.1, 0], "strain_zz": [0, 0, 0]}
    table = follow(test, HENCKY, files=(("path.csv", table_text(columns)),), path="table", table="path.csv", steps=1)
    test.check("table.stops_at_rows", difference(np.array([1.0, 4.0]), table["time"]), None, 0.0)


def check_tangent(test):
    """Six stresses at once, of a law of another kind, also in plane strain and at small strain: Newton converges as it must."""
    goal = dict(zip(SYM, (-3e6, 4e6, -2e6, 4e6, 2e6, -1e6)))
    columns = {"time": [1], **{"stress_" + name: [value] for name, value in goal.items()}}
    for law in ("neo_hookean", "hencky", "linear_elastic"):
        for measure in ("cauchy", "kirchhoff"):
            for strain in ("log", "engineering"):
                history = follow(test, {**HENCKY, "type": law}, files=(("path.csv", table_text(columns)),), path="table",
                                 table="path.csv", steps=3, measure=measure, strain=strain,
                                 stress="-1e6,-2e6,-1.5e6,3e5,-2e5,1e5")
                label = f"tangent.{law}.{measure}.{strain}"
                test.check(label, history["newton"].max(), 1, 5)
                found = np.array([history["stress_" + name][-1] for name in SYM])
                test.check(label + ".stress", difference(np.array(list(goal.values())), found), None, 1e-12)
    columns = {"time": [1], "stress_xx": [-2e6], "stress_yy": [3e6], "stress_xy": [2e6]}
    history = follow(test, {**HENCKY, "type": "neo_hookean"}, files=(("path.csv", table_text(columns)),), path="table",
                     table="path.csv", steps=2, mpm_dim=2)
    test.check("tangent.plane", history["newton"].max(), 1, 6)


def check_cuts(test):
    """A single step in which Newton's method may not iterate enough is cut, and steps grow back."""
    whole = follow(test, HENCKY, path="triaxial_drained", end=-0.6, steps=50, stress="-3e6,-3e6,-3e6,0,0,0")
    cut = follow(test, HENCKY, path="triaxial_drained", end=-0.6, steps=1, stress="-3e6,-3e6,-3e6,0,0,0", snes_max_it=3)
    test.check("cuts", cut["cuts"].sum(), 2)
    test.check("cuts.rows", len(cut["time"]), 3)
    test.check("cuts.grow", cut["dt"].max() / cut["dt"][0], 2)
    test.near("cuts.end", cut["stress_yy"][-1], whole["stress_yy"][-1], 1e-11)
    run = start(test, HENCKY, path="table", table="path.csv", stress="0,0,0,0,0,0",  # Cauchy stress has a maximum
                files=(("path.csv", "time,stress_xx,stress_yy,stress_zz\n1,0,1e9,0\n"),))
    test.check("beyond_strength.status", run.status, 3, 3)
    test.check("beyond_strength.summary", run.results.summary["status"] not in ("", "completed"), 1, 1)
    test.check("beyond_strength.rows", len(run.results.column("time")), 1)


def check_ranks(test):
    texts = [[(start(test, PRAGER, ranks=ranks, path="triaxial_drained", end=-0.05, steps=20, stress=CONFINED, mpm_title="r").folder
               / f"run_{name}").read_bytes() for name in ("history.csv", "options.yaml")] for ranks in (1, 2)]
    test.check("ranks.same_files", texts[0] == texts[1], 1, 1)
    for name in ("triaxial", "rubber_uniaxial"):
        test.check_example(name, test.run(example(name), ranks=2, mpm_quiet=None), name)
    run = start(test, HENCKY, path="oedometer", end=-0.1)
    test.check("files", run.files == ["run_history.csv", "run_options.yaml", "run_summary.json", "scene.yaml"], 1, 1)
    again = Run(test.program, run.folder / "run_options.yaml", 1, {"mpm_output_prefix": "again"}, run.folder)
    histories = [(run.folder / f"{name}_history.csv").read_bytes() for name in ("run", "again")]
    test.check("options_again", again.status == 0 and histories[0] == histories[1], 1, 1)


# What is wrong, the options of the point, its table, and what the line must contain.
NORMAL = "time,stress_xx,strain_yy,stress_zz\n"
BAD = (
    ("unknown_path", {"path": "triaxial"}, None, "-mpm_point_path triaxial: must be one of isotropic"),
    ("no_path", {"path": None}, None, "-mpm_point_path is missing"),
    ("no_steps", {"steps": 0}, None, "-mpm_point_steps 0: must lie in [1,"),
    ("no_end", {"end": None}, None, "-mpm_point_end is missing: axial (yy) strain"),
    ("end_that_flattens", {"strain": "engineering", "end": -1}, None, "-mpm_point_end -1: must be > -1"),
    ("end_with_a_unit", {"path": "isotropic", "end": "1 kPa"}, None, "pressure at the end, > 0 in compression (Pa)"),
    ("four_stresses", {"stress": "-1,-1,-1,0"}, None, "-mpm_point_stress -1,-1,-1,0: must have 6 values, has 4"),
    ("six_stresses_in_2D", {"mpm_dim": 2, "stress": "1,1,1,0,1,0"}, None, "must have 4 values, has 6"),
    ("stress_beyond_strength", {"stress": "-1e6,0,0,0,0,0"}, None, "-mpm_point_stress: material soil cannot bear it"),
    ("no_material", {"material": None}, None, "-mpm_point_material is missing"),
    ("material_not_there", {"material": "clay"}, None, "-mpm_point_material clay: must be one of soil"),
    ("unknown_measure", {"measure": "nominal"}, None, "-mpm_point_measure nominal"),
    ("unknown_strain", {"strain": "true"}, None, "-mpm_point_strain true"),
    ("triaxial_in_2D", {"mpm_dim": 2, "stress": "0,0,0,0"}, None, "-mpm_point_path triaxial_drained: needs -mpm_dim 3"),
    ("isotropic_in_2D", {"mpm_dim": 2, "path": "isotropic", "end": 1, "stress": None}, None, "needs -mpm_dim 3"),
    ("grid", {"mpm_grid_cells": "1,1,1"}, None, "-mpm_grid_cells: unknown option"),
    ("bodies", {"mpm_bodies": "block"}, None, "-mpm_bodies: unknown option"),
    ("foreign_option", {"velocity": 1}, None, "-mpm_point_velocity: unknown option"),
    ("table_without_its_path", {"table": "path.csv"}, NORMAL, "-mpm_point_table: goes with -mpm_point_path table only"),
    ("end_with_a_table", {"path": "table", "table": "path.csv"}, NORMAL + "1,-100e3,-0.1,-100e3\n", "path table ends where its file does, at 1 s"),
    ("no_table", {"path": "table", "end": None}, None, "-mpm_point_table is missing"),
    ("table_not_there", {"path": "table", "end": None, "table": "none.csv"}, None, "-mpm_point_table none.csv: cannot be read"),
)
TABLES = (
    ("both", "time,stress_xx,strain_yy,strain_zz,strain_xx\n1,0,0,0,0\n", "has both strain_xx and stress_xx"),
    ("neither", "time,stress_xx,strain_yy\n1,0,0\n", "has no column strain_zz and none stress_zz"),
    ("no_time", "stress_xx,strain_yy,stress_zz\n0,0,0\n", "has no column time"),
    ("unknown_column", "time,stress_xx,strain_yy,stress_zz,strain_yx\n1,0,0,0,0\n", "column strain_yx is unknown"),
    ("no_rows", NORMAL, "has no row with a time > 0"),
    ("empty", "", "has no column time"),
    ("time_that_stands", NORMAL + "1,0,0,0\n1,0,0,0\n", "time must grow from row to row: 1 s of row 2 follows 1 s"),
    ("negative_time", NORMAL + "-1,0,0,0\n1,0,0,0\n", "time of row 1 is -1 s, must be >= 0"),
    ("infinite", NORMAL + "1,inf,0,0\n", "stress_xx of row 1 is not a finite number"),
    ("word", NORMAL + "1,0,much,0\n", "line 2, column strain_yy: 'much' is not a number"),
    ("other_start", NORMAL + "0,-5e3,0,0\n1,0,0,0\n", "stress_xx at time 0 is -5000, must be that of the start, -100000 Pa"),
    ("other_strain", NORMAL + "0,-1e5,0.1,-1e5\n1,0,0,0\n", "strain_yy at time 0 is 0.1, must be that of the start, 0"),
)


def check_bad_scenes(test):
    cases = [(name, options, text, line) for name, options, text, line in BAD]
    cases += [("table_" + name, {"path": "table", "end": None, "table": "path.csv"}, text, line)
              for name, text, line in TABLES]
    for name, options, text, line in cases:
        for ranks in (1, 2) if name in ("table_both", "stress_beyond_strength") else (1,):
            files = (("path.csv", text),) if text is not None else ()
            run = start(test, PRAGER, ranks, files, **{"path": "triaxial_drained", "end": -0.1, "stress": CONFINED, **options})
            told = [words for words in run.errors.splitlines() if words.startswith("talus: error:")]
            good = run.status == 2 and len(told) == 1 and line in told[0] and "PETSC ERROR" not in run.errors
            good = good and (ranks > 1 or len(run.errors.splitlines()) == 1) and not run.prefix
            test.check(f"refuses.{name}" + (".2_ranks" if ranks > 1 else ""), good, 1, 1)
            if not good:
                print(f"    status {run.status}, {run.files}: {run.errors.strip()[:500]}")


with Test() as test:
    for check in (check_oedometer, check_triaxial, check_undrained, check_cauchy, check_shear, check_isotropic,
                  check_tables, check_tangent, check_cuts, check_ranks, check_bad_scenes):
        check(test)
