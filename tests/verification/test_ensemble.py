#!/usr/bin/env python3
"""Ensembles: draws fill their distributions, tables and maps are those of the members' files, and nothing depends on groups.

Distributions are compared with their closed forms: each of as many equal parts has one member. Statistics and maps are computed
again by numpy from the files of the members. Ensembles on groups of ranks, and those that were killed and went on, are the same
to the last bit. Noise of terrain has its standard deviation and correlation length.

Quick.
"""
import json
import math
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import ENVIRONMENT, Test, alone, example, read_table  # noqa: E402

ENVIRONMENT["TALUS_GDAL"] = "none"  # maps as text
POINT = """mpm:
  dim: 3
  physics: stress_point
  materials: clay
  material_clay: {{type: j2, E: 10e6, nu: 0.3, yield_stress: 50e3}}
  point: {{material: clay, path: oedometer, end: -0.02, steps: {steps}}}
  output: {{prefix: point}}
  task: ensemble
  ensemble: {{members: {members}, draws: "strength,E,nu,hard", correlation: "strength:E:0.6,E:nu:-0.3"}}
  draw_strength: {{of: clay.yield_stress, distribution: lognormal, mean: 50e3, deviation: 10e3}}
  draw_E: {{of: clay.E, distribution: triangular, bounds: "5e6,20e6"}}
  draw_nu: {{of: clay.nu, distribution: normal, deviation: 0.1, bounds: "0.1,{nu}"}}
  draw_hard: {{of: clay.hardening, distribution: uniform, bounds: "0,1e6"}}
"""
FLOW = """mpm:
  dim: 2
  physics: depth_averaged
  terrain: {file: hill.asc, noise: 1, noise_length: 40}
  grid: {lower: "1000,2000", upper: "1390,2190", cells: "39,19"}
  materials: mud
  material_mud: {type: voellmy, mu: 0.3, xi: 500, density: 1300}
  bodies: flow
  body_flow: {region: sphere, center: "1060,2100", radius: 30, points_per_cell: "3,3", material: mud, depth: 2}
  time: {integrator: explicit, end: 5}
  output: {prefix: flow}
  task: ensemble
  ensemble: {members: 12, draws: "mu,depth", thresholds: "depth:0.5,pressure:1e4,speed:3", quantiles: "0.1,0.5,0.9"}
  draw_mu: {of: mud.mu, distribution: normal, deviation: 0.05, bounds: "0.1,0.5"}
  draw_depth: {of: body_flow.depth, distribution: uniform, bounds: "1,3"}
"""
THRESHOLDS = {"depth": 0.5, "pressure": 1e4, "speed": 3.0}
QUANTILES = (0.1, 0.5, 0.9)


def normal(z):
    return 0.5 * math.erfc(-z / math.sqrt(2.0))


def write(test, name, text):
    folder = test.folder()
    (folder / name).write_text(text)
    return folder / name


def summary(run):
    return json.loads(Path(f"{run.prefix}_summary.json").read_text())


def parts(shares):
    """Largest distance of sorted shares from parts of equal size, in parts: at most 1 where each has one."""
    count = len(shares)
    return float(np.max(np.abs(np.sort(shares) * count - np.arange(count) - 0.5))) * 2.0


def ranks_of(values):
    return np.argsort(np.argsort(values)).astype(float)


def draws(test):
    """Distributions, their correlation, and the table of statistics, of many points in the laboratory."""
    scene = write(test, "point.yaml", POINT.format(members=400, steps=3, nu=0.45))
    run = test.run(scene, mpm_quiet=None)
    table = read_table(f"{run.prefix}_members.csv")
    log_deviation = math.sqrt(math.log(1.0 + 0.2 ** 2))
    log_mean = math.log(50e3) - 0.5 * log_deviation ** 2
    below, above = normal(-2.0), normal(1.5)
    share = {"strength": [normal((math.log(c) - log_mean) / log_deviation) for c in table["strength"]],
             "E": [(e - 5e6) ** 2 / (15e6 * 5e6) if e < 10e6 else 1.0 - (20e6 - e) ** 2 / (15e6 * 10e6) for e in table["E"]],
             "nu": [(normal((nu - 0.3) / 0.1) - below) / (above - below) for nu in table["nu"]],
             "hard": table["hard"] / 1e6}
    for name, values in share.items():
        test.check(f"parts.{name}", parts(np.array(values)), 0, 1.0 + 1e-9)
    for pair, value in (("strength E", 0.6), ("E nu", -0.3), ("strength nu", 0.0), ("hard E", 0.0)):
        a, b = (ranks_of(table[name]) for name in pair.split())
        test.near("correlation." + pair.replace(" ", "."), np.corrcoef(a, b)[0, 1], 6.0 / math.pi * math.asin(0.5 * value), absolute=0.03)
    statistics(test, run, table)

    # the row of a member is that of its own file, and its options file makes it again
    again = test.run(scene.parent / run.folder / "point_members" / "0007_options.yaml", mpm_output_prefix="again", mpm_quiet=None)
    for label, prefix in (("file", run.folder / "point_members" / "0007"), ("again", again.folder / "again")):
        history = read_table(f"{prefix}_history.csv")
        test.check(f"member.{label}", max(abs(history[name][-1] - table[name][7]) for name in history if name in table), 0, 0)

    # another seed, other numbers; a draw keeps its numbers whatever others there are
    other = read_table(test.run(scene, mpm_quiet=None, mpm_ensemble_seed=2).prefix + "_members.csv")
    test.check("seed", int((other["E"] == table["E"]).sum()), 0, 0)
    fewer = read_table(test.run(scene, mpm_quiet=None, mpm_ensemble_draws="hard", mpm_ensemble_correlation="").prefix + "_members.csv")
    plain = read_table(test.run(scene, mpm_quiet=None, mpm_ensemble_draws="E,hard", mpm_ensemble_correlation="").prefix + "_members.csv")
    test.check("alone", int((fewer["hard"] == plain["hard"]).sum()), 400, 400)


def statistics(test, run, table):
    with open(f"{run.prefix}_statistics.csv", encoding="utf-8") as file:
        names, *rows = [line.strip().split(",") for line in file]
    rows = {row[0]: dict(zip(names[1:], map(float, row[1:]))) for row in rows}
    for name in ("E", "stress_yy", "q"):
        values, row = table[name], rows[name]
        expected = {"count": len(values), "mean": values.mean(), "deviation": values.std(ddof=1), "least": values.min(),
                    "largest": values.max(), **{f"quantile_{q:g}": np.quantile(values, q) for q in (0.05, 0.5, 0.95)},
                    "rank_E": np.corrcoef(ranks_of(values), ranks_of(table["E"]))[0, 1]}
        test.check(f"statistics.{name}", max(abs(row[key] - value) / max(abs(value), 1.0) for key, value in expected.items()), 0, 1e-9)


def faults(test):
    """Members with numbers that the law refuses are counted and named, and cost nothing else."""
    run = test.run(write(test, "point.yaml", POINT.format(members=40, steps=3, nu=0.7)), mpm_quiet=None)
    table, told = read_table(f"{run.prefix}_members.csv"), summary(run)
    bad = table["nu"] >= 0.5
    test.check("refused.some", int(bad.sum()), 1, 20)
    test.check("refused.status", int(((table["status"] == 2) == bad).all()), 1, 1)
    test.check("refused.named", int([entry["member"] for entry in told["refused"]] == list(np.flatnonzero(bad))), 1, 1)
    test.check("refused.why", int("-mpm_material_clay_nu" in told["refused"][0]["why"]), 1, 1)
    test.check("refused.completed", told["completed"], 40 - bad.sum(), 40 - bad.sum())
    test.check("refused.nan", int(np.isnan(table["q"][bad]).all() and np.isfinite(table["q"][~bad]).all()), 1, 1)


def read_map(path):
    with open(path, encoding="utf-8") as file:
        lines = file.read().split("\n")
    head = {line.split()[0].lower(): float(line.split()[1]) for line in lines[:6]}
    values = np.array([line.split() for line in lines[6:] if line.strip()], dtype=float)
    return np.where(values == head["nodata_value"], np.nan, values)


def hill(x, y):
    return 200.0 - 0.5 * (x - 1000.0) + 0.002 * (y - 2100.0) ** 2


def maps(test):
    """Probabilities and quantiles of flows are those of the members' maps, the bed of each has noise of its own."""
    scene = write(test, "flow.yaml", FLOW)
    xs, ys = 990.0 + 10.0 * np.arange(42), 1990.0 + 10.0 * np.arange(22)
    heights = [" ".join(repr(float(hill(x, y))) for x in xs) for y in ys[::-1]]
    (scene.parent / "hill.asc").write_text("ncols 42\nnrows 22\nxllcenter 990\nyllcenter 1990\ncellsize 10\n" + "\n".join(heights) + "\n")
    run = test.run(scene, mpm_quiet=None)
    for ranks in (2, 3):
        other = test.run(scene, ranks=ranks, mpm_quiet=None)
        test.check(f"groups.{ranks}", summary(other)["groups"], ranks, ranks)
        for name in ("members.csv", "statistics.csv", "probability_depth_above_0.5.asc", "quantiles_pressure_0.9.asc"):
            same = Path(f"{run.prefix}_{name}").read_bytes() == Path(f"{other.prefix}_{name}").read_bytes()
            test.check(f"groups.{ranks}.{name}", int(same), 1, 1)
    for name, threshold in THRESHOLDS.items():
        members = np.array([read_map(path) for path in sorted(run.folder.glob(f"flow_members/*_peak_{name}.asc"))])
        share = np.where(np.isnan(members[0]), np.nan, (members > threshold).mean(axis=0))
        written = read_map(f"{run.prefix}_probability_{name}_above_{threshold:g}.asc")
        test.check(f"probability.{name}.some", int(((share > 0.0) & (share < 1.0)).sum()), 5)
        test.check(f"probability.{name}", float(np.nanmax(abs(written - share))), 0, 1e-14)
        for quantile in QUANTILES:
            written = read_map(f"{run.prefix}_quantiles_{name}_{quantile:g}.asc")
            expected = np.quantile(members, quantile, axis=0)
            test.check(f"quantile.{name}.{quantile}", float(np.nanmax(abs(written - expected) / (1.0 + abs(expected)))), 0, 1e-13)
    beds = np.array([read_map(path) for path in sorted(run.folder.glob("flow_members/*_peak_bed.asc"))])
    noise = beds - np.array([[hill(x, y) for x in xs] for y in ys[::-1]])
    test.check("noise.mean", abs(float(noise.mean())), 0, 0.2)
    test.near("noise.deviation", float(noise.std()), 1.0, absolute=0.15)
    for lag in (2, 4):
        pairs = np.mean(noise[:, :, lag:] * noise[:, :, :-lag]), np.mean(noise[:, lag:] * noise[:, :-lag])
        test.near(f"noise.lag{lag}", float(np.mean(pairs) / noise.var()), math.exp(-((lag / 4.0) ** 2)), absolute=0.12)
    return scene


def killed(test):
    """An ensemble that is killed goes on with the members that are left, and ends as one that was not."""
    scene = write(test, "point.yaml", POINT.format(members=300, steps=400, nu=0.45))
    whole = test.run(scene, mpm_quiet=None)
    folder = test.folder()
    command = [str(test.program), "-options_file", str(scene), "-mpm_quiet"]
    process = subprocess.Popen(command, cwd=folder, env={**ENVIRONMENT, **alone()})
    until = time.monotonic() + 60.0
    while len(list(folder.glob("point_members/*_member.csv"))) < 20 and time.monotonic() < until:
        time.sleep(0.002)
    os.kill(process.pid, signal.SIGKILL)
    process.wait()
    there = {path: path.stat().st_mtime_ns for path in folder.glob("point_members/*_member.csv")}
    test.check("killed.there", len(there), 20, 299)
    process = subprocess.run([*command, "-mpm_ensemble_restart"], cwd=folder, env={**ENVIRONMENT, **alone()}, check=False)
    test.check("killed.status", process.returncode, 0, 0)
    test.check("killed.kept", int(all(path.stat().st_mtime_ns == at for path, at in there.items())), 1, 1)
    for name in ("members.csv", "statistics.csv"):
        same = (folder / f"point_{name}").read_bytes() == Path(f"{whole.prefix}_{name}").read_bytes()
        test.check(f"killed.{name}", int(same), 1, 1)
    # members of another scene are not taken
    subprocess.run([*command, "-mpm_ensemble_restart", "-mpm_point_end", "-0.01"], cwd=folder, env={**ENVIRONMENT, **alone()}, check=False)
    test.check("killed.other", int(all(path.stat().st_mtime_ns != at for path, at in there.items())), 1, 1)


REFUSED = [
    ("number", {"mpm_draw_E_of": "clay.e"}, "-mpm_draw_E_of clay.e: clay has no number e; did you mean clay.E?"),
    ("distribution", {"mpm_draw_E_distribution": "beta"}, "-mpm_draw_E_distribution beta: must be one of uniform, normal"),
    ("bounds", {"mpm_draw_E_bounds": "3,1"}, "must ascend"),
    ("no_bounds", {"mpm_draw_strength_distribution": "uniform"}, "-mpm_draw_strength_bounds is missing"),
    ("mode", {"mpm_draw_E_mode": "1"}, "-mpm_draw_E_mode 1"),
    ("deviation", {"mpm_draw_nu_deviation": "0"}, "-mpm_draw_nu_deviation 0: must be > 0"),
    ("block", {"mpm_ensemble_draws": "E,F"}, "-mpm_draw_F_of is missing"),
    ("correlation", {"mpm_ensemble_correlation": "E:F:0.5"}, "-mpm_ensemble_correlation E:F:0.5: must be A:B:R"),
    ("pair_twice", {"mpm_ensemble_correlation": "E:nu:0.5,nu:E:0.1"}, "nu and E are there twice"),
    ("one_number", {"mpm_draw_hard_of": "clay.nu,material_clay.E"}, "-mpm_draw_hard_of material_clay.E: draw E has this number"),
    ("no_matrix", {"mpm_ensemble_correlation": "E:nu:0.9,E:hard:0.9,nu:hard:-0.9"}, "not positive definite"),
    ("results", {"mpm_ensemble_results": "stress_y"}, "-mpm_ensemble_results stress_y: the history has no such column"),
    ("thresholds", {"mpm_ensemble_thresholds": "height:1"}, "of depth, speed or pressure"),
    ("quantiles", {"mpm_ensemble_quantiles": "1"}, ": must lie in (0, 1)"),
]


with Test() as test:
    draws(test)
    faults(test)
    maps(test)
    killed(test)
    slope = test.run(example("ensemble_slope"), ranks=2, mpm_quiet=None, mpm_ensemble_members=8, mpm_grid_cells="32,8")
    test.check_example("slope", slope, "ensemble_slope")
    point = write(test, "point.yaml", POINT.format(members=20, steps=3, nu=0.45))
    for label, options, words in REFUSED:
        run = test.run(point, status=2, mpm_quiet=None, **options)
        test.check(f"refuse.{label}", int(words in run.errors and run.errors.count("\n") == 1), 1, 1)
        if words not in run.errors:
            print(run.errors)
