"""Contact in Kratos MPM and in Talus, side by side: error and seconds of both.

`disc`: a rigid disc, radius 4 m, is pressed 10 mm into an elastic block of 1.5 m x 1 m (half of it) without friction, in 10
steps. Error: of the force on the disc, against 3320.2 N/m of finite elements (kratos_reference.py). `slide`: a block of 1 m x 0.5 m is pressed 5 mm on a
plane, in 5 steps, and pushed 10 mm along it, in 15, with a friction of 0.3. Error: of the ratio of the two forces at the end,
when all of it slides, against 0.3.

Both programs get the same grid, 4 x 4 points a cell on the same lattice, law (neo-Hookean), steps, residual tolerance, a direct solver and one core. What
differs: Kratos' disc is a row of lines that hold the grid's displacement where they lie, from the first step and wherever
their cell holds material; it knows no gap, and its answer depends on the penalty, of which the table has two. Its plane is an edge of the grid, while
that of Talus may lie anywhere. In Kratos friction follows the pressure of the step before, and its residual does
not come below 1e-4 in 50 iterations, whatever the penalty: there the change of the displacement tells when a step is done, to 1e-8 or
to 1e-4, its own default. Shapes: Kratos has linear.

Kratos is looked for in --environment; --install fetches it from PyPI.
"""
import json
import os
import subprocess
import tempfile
import time
from pathlib import Path

from bench import peers
from bench.figures import COLOURS, MARKERS, label, panels, save
from bench.runs import BenchmarkError, Table, in_turn, median, run_scene

NAME = "kratos"
HERE = Path(__file__).resolve().parent
SIZES = (0.1, 0.05, 0.025)  # m
FORCE, DEPTH, HEIGHT, FRICTION = 3320.2, 0.01, 1.0, 0.3  # N/m, m, m, -
COMMON = {"points_per_side": 4, "E": 1e6, "nu": 0.3, "tolerance": 1e-8, "criterion": "residual_criterion", "max_iteration": 50}
CASES = {
    "disc": {**COMMON, "case": "disc", "block": [0.0, 1.5, HEIGHT], "grid": [1.6, 1.2], "radius": 4.0, "reach": 0.8,
             "lines_per_cell": 4, "steps": 10, "depth": DEPTH},
    "slide": {**COMMON, "case": "slide", "block": [0.2, 1.2, 0.5], "grid": [1.4, 0.6], "steps": 20, "depth": 0.005,
              "slide": 0.01, "friction": FRICTION},
}
# Ways of Kratos: friction does not bring its residual below 1e-4 in 50 iterations, so the displacement tells when to stop.
WAYS = {
    "disc": {"penalty 1e7": {"penalty": 1e7}, "penalty 1e9": {"penalty": 1e9}},
    "slide": {"tolerance 1e-8": {"penalty": 1e9, "criterion": "displacement_criterion"},
              "tolerance 1e-4": {"penalty": 1e9, "criterion": "displacement_criterion", "tolerance": 1e-4}},
}
SHAPES = ("linear", "gimp")


def add_arguments(parser):
    parser.add_argument("--environment", default="~/.cache/talus-peers", help="folder of a Python environment with Kratos")
    parser.add_argument("--install", action="store_true", help="make that environment, from PyPI")
    parser.add_argument("--h", type=float, nargs="+", help="cell sizes, m (0.1 0.05 0.025; quick: the first)")


def find_kratos(arguments):
    """The environment's Python, or None with a line that says what is missing."""
    if arguments.install:
        return peers.environment(arguments.environment)
    python = Path(arguments.environment).expanduser() / "bin" / "python"
    code = "import KratosMultiphysics.MPMApplication"
    if python.exists() and subprocess.run([python, "-c", code], check=False, capture_output=True).returncode == 0:
        return python
    print(f"bench.py kratos: there is no Kratos MPM in {python.parent.parent}; --install fetches it. Talus alone:")
    return None


def error_of(case, force):
    """Relative error; force: along the plane and across it (disc: across)."""
    return abs(force[1] / FORCE - 1.0) if case == "disc" else abs(abs(force[0] / force[1]) / FRICTION - 1.0)


def kratos_row(python, case, h, way, repeat):
    scene = {**CASES[case], "h": h, **WAYS[case][way]}
    runs, processes = [], []
    for _ in range(repeat):
        with tempfile.TemporaryDirectory() as folder:
            before, after = Path(folder) / "scene.json", Path(folder) / "result.json"
            before.write_text(json.dumps(scene), encoding="utf-8")
            begin = time.perf_counter()
            process = subprocess.run([python, HERE / "kratos_contact.py", before, after], check=False, capture_output=True,
                                     text=True, env={**os.environ, **peers.ONE_CORE})
            processes.append(time.perf_counter() - begin)
            if process.returncode:
                raise BenchmarkError(peers.failure("Kratos", process))
            runs.append(json.loads(after.read_text(encoding="utf-8")))
    one = runs[0]
    force = [one["reaction"][0], -one["virial"] / (HEIGHT - DEPTH) if case == "disc" else abs(one["reaction"][1])]
    middle = len(runs) // 2
    return {"code": f"Kratos {peers.VERSION}", "method": f"linear, {way}", "points": one["points"],
            "force": force[1], "error": error_of(case, force), "newton": one["newton_iterations"],
            "seconds": sorted(run["seconds"] for run in runs)[middle], "seconds_total": sorted(processes)[middle],
            "remark": f"{one['unconverged']} of {scene['steps']} steps do not converge" if one["unconverged"] else ""}


def talus_forces(prefix, case):
    from results import Results

    results = Results(prefix)
    names = ("disc_x", "disc_y") if case == "disc" else ("push_x", "press_y")
    return [float(abs(results.column(f"reaction_{name}")[-1])) for name in names]


def talus_row(arguments, case, h, shape, repeat):
    scene = CASES[case]
    rows = round(scene["grid"][1] / h) + (round(0.1 / h) if case == "slide" else 0)
    options = {"mpm_grid_cells": f"{round(scene['grid'][0] / h)},{rows}", "mpm_shape": shape}
    runs = in_turn(repeat, [lambda: run_scene(arguments.program, HERE / f"kratos_{case}.yaml", options,
                                              measure=lambda prefix: talus_forces(prefix, case))])[0]
    one = runs[0]
    row = {"code": "Talus", "method": shape, "remark": "" if one.completed else one.status}
    if one.completed:
        total = median(runs, "time_total_s")
        row.update(points=one["points"], force=one.value[1], error=error_of(case, one.value), newton=one["newton_iterations"],
                   seconds=total - median(runs, "setup") - median(runs, "output"), seconds_total=total)
    return row


def draw(table, folder):
    figure, axes = panels(len(CASES))
    for panel, case in zip(axes, CASES):
        rows = [row for row in table.select(case=case) if row.get("error") is not None]
        for k, name in enumerate(dict.fromkeys((row["code"], row["method"]) for row in rows)):
            mine = [row for row in rows if (row["code"], row["method"]) == name]
            panel.plot([row["seconds"] for row in mine], [max(row["error"], 1e-16) for row in mine], color=COLOURS[k],
                       marker=MARKERS[k], label=" ".join(name))
        label(panel, case, "seconds of the loop over the steps, one core", "relative error of the force")
        panel.legend(frameon=False, fontsize="small")
    save(figure, folder, NAME)


def run(arguments):
    python = find_kratos(arguments)
    repeat = arguments.repeat or (1 if arguments.quick else 3)
    table = Table(arguments.out, NAME, ("case", "code", "method", "h", "points", "force", "error", "newton", "seconds",
                                        "seconds_total", "remark"))
    for case in CASES:
        for h in arguments.h or SIZES[:1 if arguments.quick else None]:
            for way in WAYS[case] if python else ():
                table.add(case=case, h=h, **kratos_row(python, case, h, way, repeat))
            for shape in SHAPES:
                table.add(case=case, h=h, **talus_row(arguments, case, h, shape, repeat))
    draw(table, arguments.out)
