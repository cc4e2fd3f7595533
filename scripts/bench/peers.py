#!/usr/bin/env python3
"""The same cantilever in Kratos MPM and in Talus, side by side: seconds and error of both, as CSV and as a picture.

    scripts/bench/peers.py [--h 0.5 0.25] [--tolerance 1e-8 1e-4] [--repeat 3] [--plot peers.png]

A beam, 10 m long and 1 m deep, clamped at its root, in plane strain, bends under its own weight, which grows in 50
equal steps; compressible neo-Hookean (scripts/bench/peers.yaml). Both programs get the same grid, 4 x 4 points a cell,
steps, load and residual tolerance, and one core. Kratos 10.4.4 comes from PyPI into an environment outside of the
repository, which is made when it is not there.

The error is the distance, over the beam's length, from where the middle of the end section ought to be: u/L = -0.551266,
v/L = -0.842725 (cantilever_reference.py, good to 2e-6). The points of both programs are read
in the same way: a quadratic in X and Y, fitted to the displacements of the points next to the end, is taken at the
middle of the end section.

Columns: seconds is the loop over the steps, seconds_total the whole process; load is the part of the weight that the
run reached. Layouts: gauss has Kratos' points where it puts them, at the Gauss points of each cell, and uniform on the
regular lattice that Talus has (one point in each of 16 small elements a cell). A row of Kratos is the best of its
direct solvers: the one that came farthest, then the fastest.

Shapes: Kratos has linear. In Talus SHAPE-plain is without the ghost penalty, which is on otherwise: linear-plain is the
method of Kratos, to be compared with the uniform layout. The penalty stiffens the beam a little, where linear basis functions and gimp are too soft; the error of gimp with it is therefore smaller than that of
gimp-plain, and the two show how much each number is worth.

Newton iterations a step: up to 100 in Kratos (its own limit of 20 is too small for most rows at 1e-8), and as many in
Talus where there is no ghost penalty; otherwise its own limit of 25.
"""
import argparse
import csv
import json
import os
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

NAME = "peers"
HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
SCENE = HERE / "peers.yaml"
ONE_CORE = {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1", "OMP_NUM_THREADS": "1"}

PACKAGE, VERSION = "KratosMPMApplication", "10.4.4"
DIRECT_SOLVERS = ["sparse_lu", "skyline_lu"]  # sparse_qr takes twice as long; the wheels have no MKL and no SuiteSparse

LENGTH, BOX, GRID, POINTS = 10.0, [0.0, 9.0, 10.0, 10.0], [15.0, 15.0], 4
END = (10.0, 9.5)  # the middle of the end section, m
REFERENCE = (-0.551266, -0.842725)  # its displacement over the length
BEAM = {"density": 1000.0, "E": 12e6, "nu": 0.2, "gravity": 20.0, "steps": 50}  # as in peers.yaml
PATIENCE = 100  # Newton iterations a step, where nothing helps against small-cut nodes
WITH_GHOST = ("linear", "gimp")  # Talus has the ghost penalty for these

COLUMNS = ["code", "shape", "layout", "h", "points", "tolerance", "linear_solver", "steps", "load", "newton_iterations",
           "seconds", "seconds_total", "u_over_L", "v_over_L", "error", "remark"]


def note(text):
    print(text, file=sys.stderr, flush=True)


def failure(code, process):
    return f"{code} ended with status {process.returncode}:\n{process.stdout[-2000:]}{process.stderr[-2000:]}"


def end_displacement(position, displacement, h):
    """Displacement over the length of the middle of the end section, from points (rows) by a fitted quadratic."""
    import numpy as np

    position, displacement = np.asarray(position), np.asarray(displacement)
    near = position[:, 0] > END[0] - max(0.5, 2.0 * h)
    x, y = (position[near] - END).T
    basis = np.column_stack([np.ones_like(x), x, y, x * x, x * y, y * y])
    return np.linalg.lstsq(basis, displacement[near], rcond=None)[0][0] / LENGTH


def judge(row, position, displacement, h):
    """Adds displacement and error to the row of a run that came to its end."""
    u, v = end_displacement(position, displacement, h)
    row.update(u_over_L=f"{u:.5f}", v_over_L=f"{v:.5f}")
    row["error"] = f"{((u - REFERENCE[0]) ** 2 + (v - REFERENCE[1]) ** 2) ** 0.5:.5f}"
    return row


def environment(folder):
    """Python of an environment that has Kratos; makes it when it is not there."""
    python = Path(folder).expanduser() / "bin" / "python"
    question = f"import importlib.metadata as m, sys; sys.exit(m.version('{PACKAGE}') != '{VERSION}')"
    if python.exists() and subprocess.run([python, "-c", question], check=False, capture_output=True).returncode == 0:
        return python
    note(f"installs {PACKAGE}=={VERSION} and what it needs (KratosMultiphysics, KratosLinearSolversApplication, numpy) "
         f"from PyPI into {python.parent.parent}")
    subprocess.run([sys.executable, "-m", "venv", python.parent.parent], check=True)
    subprocess.run([python, "-m", "pip", "install", "--quiet", f"{PACKAGE}=={VERSION}"], check=True)
    return python


def run_kratos(python, h, layout, tolerance, solver):
    """One run of Kratos: its result, with the seconds of the process."""
    scene = {**BEAM, "h": h, "layout": layout, "grid": GRID, "box": BOX, "points_per_side": POINTS,
             "solver_type": "quasi_static", "tolerance": tolerance, "max_iteration": PATIENCE, "linear_solver": solver}
    with tempfile.TemporaryDirectory() as folder:
        before, after = Path(folder) / "scene.json", Path(folder) / "result.json"
        before.write_text(json.dumps(scene), encoding="utf-8")
        begin = time.perf_counter()
        process = subprocess.run([python, HERE / "peers_kratos.py", before, after], check=False, capture_output=True,
                                 text=True, env={**os.environ, **ONE_CORE})
        seconds = time.perf_counter() - begin
        if process.returncode != 0:
            raise SystemExit(failure("Kratos", process))
        return {**json.loads(after.read_text(encoding="utf-8")), "process": seconds, "linear_solver": solver}


def kratos_row(python, h, layout, tolerance, arguments):
    """The best of Kratos' direct solvers, median of the repeated runs."""
    best = None
    for solver in arguments.kratos_solvers:
        runs = [run_kratos(python, h, layout, tolerance, solver) for _ in range(arguments.repeat)]
        candidate = {**runs[0], "seconds": statistics.median(run["seconds"] for run in runs),
                     "process": statistics.median(run["process"] for run in runs)}
        if best is None or (-candidate["steps"], candidate["seconds"]) < (-best["steps"], best["seconds"]):
            best = candidate
    row = {"code": f"Kratos {VERSION}", "shape": "linear", "layout": layout, "h": h, "points": best["points"],
           "tolerance": tolerance, "linear_solver": best["linear_solver"], "steps": best["steps"],
           "load": f"{best['steps'] / BEAM['steps']:.2f}", "newton_iterations": best["newton_iterations"],
           "seconds": f"{best['seconds']:.2f}", "seconds_total": f"{best['process']:.2f}", "remark": best["failure"]}
    complete = not best["failure"]
    return judge(row, best["initial"], best["displacement"], h) if complete else row


def run_talus(program, h, shape, tolerance, prefix):
    """One run of Talus: its results, with the seconds of the process and what it said."""
    from results import Results

    cells = ",".join(str(round(length / h)) for length in GRID)
    name, _, plain = shape.partition("-")
    words = [program, "-options_file", SCENE, "-mpm_output_prefix", prefix, "-mpm_grid_cells", cells,
             "-mpm_shape", name, "-snes_rtol", str(tolerance)]
    if plain:
        words += ["-mpm_stabilization_ghost", "off"]
    if plain or name not in WITH_GHOST:
        words += ["-snes_max_it", str(PATIENCE)]
    begin = time.perf_counter()
    process = subprocess.run(words, check=False, capture_output=True, text=True, env={**os.environ, **ONE_CORE})
    seconds = time.perf_counter() - begin
    if process.returncode not in (0, 3):
        raise SystemExit(failure("Talus", process))
    return Results(prefix), seconds, process


def talus_remark(results, process):
    """What a reader of the table has to know of a run: cuts, the ghost penalty, or why it gave up."""
    remarks = []
    for line in process.stdout.splitlines():
        if "from here on with" in line:
            remarks.append("ghost penalty " + line.split()[-1])
    if results.summary["step_cuts"]:
        remarks.append(f"steps cut: {results.summary['step_cuts']}")
    if process.returncode == 3:
        remarks.append(process.stderr.strip().rsplit(": ", 1)[-1])
    return "; ".join(remarks)


def talus_row(h, shape, tolerance, arguments):
    with tempfile.TemporaryDirectory() as folder:
        runs = [run_talus(arguments.program, h, shape, tolerance, str(Path(folder) / str(i)))
                for i in range(arguments.repeat)]
        results, _, process = runs[0]
        loops = []
        for one, _, _ in runs:
            summary = one.summary
            loops.append(summary["time_total_s"] - summary["time"]["setup"] - summary["time"]["output"])
        summary = results.summary
        row = {"code": f"Talus {summary['version']}", "shape": shape, "layout": "uniform", "h": h,
               "points": summary["points"], "tolerance": tolerance, "linear_solver": "direct", "steps": summary["steps"],
               "load": f"{results.column('load')[-1]:.2f}", "newton_iterations": summary["newton_iterations"],
               "seconds": f"{statistics.median(loops):.2f}",
               "seconds_total": f"{statistics.median(seconds for _, seconds, _ in runs):.2f}",
               "remark": talus_remark(results, process)}
        if process.returncode == 0:
            judge(row, results.initial["position0"], results.state("last")["displacement"], h)
        return row


def plot(rows, path):
    """Seconds against error: a line a method, a mark a cell size; hollow where the tolerance is the looser one."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(figsize=(7.5, 5.0))
    methods = list(dict.fromkeys((row["code"], row["shape"], row["layout"]) for row in rows))
    tolerances = sorted({row["tolerance"] for row in rows})
    for i, method in enumerate(methods):
        for tolerance in tolerances:
            mine = [row for row in rows if (row["code"], row["shape"], row["layout"]) == method
                    and row["tolerance"] == tolerance and "error" in row]
            tight = tolerance == tolerances[0]
            label = " ".join(method[:2]) + (f", {method[2]}" if "Kratos" in method[0] else "")
            axes.loglog([float(row["seconds"]) for row in mine], [float(row["error"]) for row in mine],
                        "-" if tight else ":", color=f"C{i}", marker="so^DvP*"[i % 7],
                        markerfacecolor=f"C{i}" if tight else "white", label=label if tight else None)
            for row in mine if tight else []:
                axes.annotate(f"1/{1 / row['h']:g}", (float(row["seconds"]), float(row["error"])), (4, 4),
                              textcoords="offset points", fontsize=7)
    axes.set(xlabel="seconds of the loop over 50 steps, one core", ylabel="error of the end's displacement / length")
    axes.set_title("Cantilever under its own weight; marks: h in m; "
                   + (f"full: tolerance {tolerances[0]:g}, hollow: {tolerances[-1]:g}" if len(tolerances) > 1 else
                      f"tolerance {tolerances[0]:g}"), fontsize=9)
    axes.grid(True, which="both", alpha=0.3)
    axes.legend(fontsize=8)
    figure.tight_layout()
    figure.savefig(path, dpi=130)


def add_arguments(parser):
    parser.add_argument("--program", default=str(ROOT / "build" / "talus"))
    parser.add_argument("--environment", default="~/.cache/talus-peers", help="folder for Kratos' Python environment")
    parser.add_argument("--h", type=float, nargs="+", default=[0.5, 0.25, 0.125], help="cell sizes, m")
    parser.add_argument("--tolerance", type=float, nargs="+", default=[1e-8, 1e-4],
                        help="residual over that at the start of the step; 1e-8 is Talus' default, 1e-4 that of Kratos")
    parser.add_argument("--shape", nargs="*", default=["linear-plain", "linear", "gimp-plain", "gimp", "gimp_bspline2"],
                        help="of Talus")
    parser.add_argument("--layout", nargs="*", default=["gauss", "uniform"], help="of Kratos' points")
    parser.add_argument("--kratos-solvers", nargs="+", default=DIRECT_SOLVERS, metavar="NAME")
    parser.add_argument("--repeat", type=int, default=3, help="runs; the table has medians")
    parser.add_argument("--plot", metavar="FILE.png")


def run(arguments):
    sys.path.insert(0, str(HERE.parent))  # results.py
    python = environment(arguments.environment)
    writer = csv.DictWriter(sys.stdout, COLUMNS, restval="", lineterminator="\n")
    writer.writeheader()
    rows = []

    def add(row):
        rows.append(row)
        writer.writerow(row)
        sys.stdout.flush()

    for tolerance in arguments.tolerance:
        for h in arguments.h:
            for layout in arguments.layout:
                add(kratos_row(python, h, layout, tolerance, arguments))
            for shape in arguments.shape:
                add(talus_row(h, shape, tolerance, arguments))
    if arguments.plot:
        plot(rows, arguments.plot)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    add_arguments(parser)
    run(parser.parse_args())


if __name__ == "__main__":
    main()
