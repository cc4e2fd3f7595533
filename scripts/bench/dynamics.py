"""What a step of dynamics costs, and which integrator is the better one for a slow and for a fast process.

`dynamics`: nanoseconds a point and core of an explicit step, with everything that it does, of every shape and some laws in 2D (3 x 3
points a cell) and 3D (2 x 2 x 2), and of one residual of a quasi-static step on the same points; both take turns in one run of the program
bench_dynamics. `dynamics_newton`: what a Newton iteration of an implicit dynamic step costs over one of a quasi-static step on the same
points, in the same program: its residuals, Jacobian and linear solution, and with all else that a step does (step_over_quasistatic).
`dynamics_error`: error against seconds of a bar under its weight, put on at once or over fifty of its periods.
`dynamics_kratos`: nanoseconds a point and step of a block that its weight presses together, beside those of Kratos MPM 10.4: the
same grid, points, law (neo-Hookean), linear functions and steps. Kratos is looked for in --environment; --install fetches it.
"""
import json
import math
import os
import statistics
import subprocess
import tempfile
from pathlib import Path

from bench import peers
from bench.figures import COLOURS, MARKERS, label, panels, save
from bench.kratos import find_kratos
from bench.runs import BenchmarkError, Table, check_program, execute, in_turn, median, run_scene, words_of

HERE = Path(__file__).resolve().parent
SHAPES = ("linear", "gimp", "bspline2", "bspline3", "gimp_bspline2")
ELASTIC = "E: 1e7, nu: 0.3, density: 1000"
LAWS = {"hencky": ELASTIC, "linear_elastic": ELASTIC, "neo_hookean": ELASTIC, "j2": ELASTIC + ", yield_stress: 1e4",
        "mohr_coulomb": ELASTIC + ", cohesion: 1e3, friction: 30, dilation: 0"}
CELLS = {2: 100, 3: 24}
BLOCK = {"cells": 60, "steps": 400, "dt": 1e-4}  # of the comparison with Kratos; its steps are explicit
BAR = {"length": 10.0, "speed": 10.0, "gravity": 1e-3, "cell": 12.5 / 80}  # m, m/s, m/s2, m: dynamics_bar.yaml
PERIOD = 4.0 * BAR["length"] / BAR["speed"]
STEPS = {"fast": (0.4, 0.2, 0.1, 0.05, 0.02), "slow": (40.0, 20.0, 10.0, 5.0, 2.0)}  # s, of implicit steps
COURANT = (0.9, 0.5, 0.25)


def add_arguments(parser):
    parser.set_defaults(ranks=1)
    parser.add_argument("--helper", metavar="PROGRAM", help="the program bench_dynamics (beside --program)")
    parser.add_argument("--environment", default="~/.cache/talus-peers", help="folder of a Python environment with Kratos")
    parser.add_argument("--install", action="store_true", help="make that environment, from PyPI")
    parser.add_argument("--only", choices=list(PARTS), nargs="+", default=list(PARTS), help="some of the tables")


# ---- an explicit step and a residual ----

def block(dim, shape, law, cells, prefix, time, more=""):
    """A block on the ground that slides off slowly, as a scene; `time`: its block of that name; `more`: lines of its first level."""
    lower, upper = ",".join(["0.2"] * (dim - 1) + ["0"]), ",".join(["1.0"] * (dim - 1) + ["0.8"])
    velocity = f', velocity: "{",".join(["0.1"] + ["0"] * (dim - 1))}"' if "explicit" in time else ""
    every = ",".join(["0"] * dim)
    return f"""mpm:
  dim: {dim}
  physics: solid
  grid: {{lower: "{every}", upper: "{",".join(["1.2"] * dim)}", cells: "{",".join([str(cells)] * dim)}"}}
  shape: {shape}
  materials: m
  material_m: {{type: {law}, {LAWS[law]}}}
  bodies: b
  body_b: {{region: box, lower: "{lower}", upper: "{upper}", points_per_cell: "{"3,3" if dim == 2 else "2,2,2"}", material: m{velocity}}}
  bcs: base
  bc_base: {{region: box, lower: "{every}", upper: "{",".join(["1.2"] * (dim - 1) + ["0"])}", components: "{"x,y,z"[:2 * dim - 1]}"}}
  loads: g
  load_g: {{type: gravity, value: "{",".join(["0"] * (dim - 1) + ["-10"])}", ramp: "0:1"}}
  time: {{{time}}}
  output: {{prefix: {prefix}, every: 0}}
{more}"""


def measure(arguments, scenes, options):
    """What bench_dynamics tells of two scenes, by their options' names: lists of numbers by key."""
    found = {}
    with tempfile.TemporaryDirectory() as folder:
        options = {"bench_rounds": arguments.repeat, **options}
        for key, text in scenes.items():
            options[f"bench_{key}"] = Path(folder) / f"{key}.yaml"
            options[f"bench_{key}"].write_text(text.replace("PREFIX", str(Path(folder) / key)), encoding="utf-8")
        status, output, errors = execute([arguments.helper, *words_of(options)])
    if status != 0:
        raise BenchmarkError(f"{arguments.helper}: exit status {status}\n{errors.strip()}")
    for words in (line.split() for line in output.splitlines()):
        if len(words) == 2:
            found.setdefault(words[0], []).append(float(words[1]))
    return found


def over(found, one, other):
    """The median of quotients of numbers that were measured side by side."""
    return statistics.median(a / b for a, b in zip(found[one], found[other]))


def steps(arguments):
    table = Table(arguments.out, "dynamics", ("dim", "shape", "law", "points", "explicit_ns", "residual_ns", "ratio"))
    for dim in (2, 3):
        cases = [(shape, "hencky") for shape in SHAPES] + [("gimp", law) for law in LAWS if law != "hencky"]
        for shape, law in cases:
            cells = CELLS[dim] // 2 if arguments.quick else CELLS[dim]
            scenes = {key: block(dim, shape, law, cells, "PREFIX", time)
                      for key, time in (("explicit", "integrator: explicit, cfl: 0.5, end: 1e3"), ("static", "end: 1, step: 1"))}
            found = measure(arguments, scenes, {"bench_steps": 5 if arguments.quick else 10})
            table.add(dim=dim, shape=shape, law=law, points=int(found["points"][0]),
                      explicit_ns=statistics.median(found["explicit_ns"]), residual_ns=statistics.median(found["residual_ns"]),
                      ratio=over(found, "explicit_ns", "residual_ns"))


# ---- a Newton iteration ----

def newton(arguments):
    table = Table(arguments.out, "dynamics_newton", ("dim", "shape", "integrator", "mass", "points", "static_ns", "implicit_ns",
                                                     "over_quasistatic", "step_over_quasistatic"))
    time = "end: 1, step: 0.002"
    ways = [("newmark", "lumped"), ("newmark", "consistent"), ("generalized_alpha", "consistent"), ("backward_euler", "consistent")]
    for dim, shape in ((dim, shape) for dim in (2, 3) for shape in SHAPES):
        cells = (60 if dim == 2 else 12) // (2 if arguments.quick else 1)
        for integrator, mass in ways:
            scenes = {key: block(dim, shape, "hencky", cells, "PREFIX", words + time, "  newton_lag: false\n")
                      for key, words in (("static", ""), ("implicit", f"integrator: {integrator}, mass: {mass}, "))}
            found = measure(arguments, scenes, {"bench_rounds": 3 * arguments.repeat})
            table.add(dim=dim, shape=shape, integrator=integrator, mass=mass, points=int(found["points"][0]),
                      static_ns=statistics.median(found["static_ns"]), implicit_ns=statistics.median(found["implicit_ns"]),
                      over_quasistatic=over(found, "implicit_ns", "static_ns"),
                      step_over_quasistatic=over(found, "step_implicit_ns", "step_static_ns"))


# ---- error against seconds ----

def exact(place, time, ramp):
    """Displacement of the bar at a place and a time, m, over that of its free end at rest; the weight grows over `ramp` s."""
    total = 0.0
    for n in range(400):
        wave = (2 * n + 1) * math.pi / (2.0 * BAR["length"])
        omega = wave * BAR["speed"]
        answer = 1.0 - math.cos(omega * time) if ramp == 0.0 else time / ramp - math.sin(omega * time) / (omega * ramp)
        total += 4.0 / ((2 * n + 1) * math.pi) / omega**2 * math.sin(wave * place) * answer
    return total / (0.5 * (BAR["length"] / BAR["speed"])**2)


def bar_error(prefix, ramp):
    from results import Results

    results, rest = Results(prefix), BAR["gravity"] * 0.5 * (BAR["length"] / BAR["speed"])**2
    place = BAR["length"] - 0.25 * BAR["cell"]  # of the points that the track takes
    times, ux = results.column("time"), results.column("track_tip_ux")
    every = max(len(times) // 400, 1)
    squares = [(u / rest - exact(place, t, ramp))**2 for t, u in list(zip(times, ux))[every - 1::every]]
    return math.sqrt(sum(squares) / len(squares))


def errors(arguments):
    table = Table(arguments.out, "dynamics_error", ("process", "integrator", "step", "steps", "error", "seconds", "status"))
    for process in ("fast", "slow"):
        ramp = 0.0 if process == "fast" else (10 if arguments.quick else 50) * PERIOD
        end = ramp or (1 if arguments.quick else 3) * PERIOD
        common = {"mpm_load_weight_ramp": f"0:0, {ramp}:1" if ramp else "0:1", "mpm_time_end": end}
        cases = [(name, {"mpm_time_integrator": name, "mpm_time_step": step}) for step in STEPS[process] if step <= end / 2
                 for name in ("backward_euler", "generalized_alpha")]
        cases += [("explicit", {"mpm_time_integrator": "explicit", "mpm_time_cfl": cfl}) for cfl in COURANT]
        runs = in_turn(arguments.repeat, [lambda options=options: run_scene(
            arguments.program, HERE / "dynamics_bar.yaml", {**common, **options}, measure=lambda prefix: bar_error(prefix, ramp))
            for _, options in cases])
        for (name, _), mine in zip(cases, runs):
            row = {"process": process, "integrator": name, "status": mine[0].status}
            if mine[0].completed:
                row.update(step=end / mine[0]["steps"], steps=mine[0]["steps"], error=mine[0].value,
                           seconds=median(mine, "time_total_s"))
            table.add(**row)
    figure, axes = panels(2)
    for panel, process in zip(axes, ("fast", "slow")):
        for k, name in enumerate(dict.fromkeys(row["integrator"] for row in table.rows)):
            rows = [row for row in table.select(process=process, integrator=name) if "error" in row]
            panel.plot([row["seconds"] for row in rows], [row["error"] for row in rows], color=COLOURS[k], marker=MARKERS[k], label=name)
        label(panel, f"bar, {process}", "seconds, one core", "error of the end's displacement over that at rest")
        panel.legend(frameon=False, fontsize="small")
    save(figure, arguments.out, "dynamics_error")


# ---- Kratos ----

def kratos_run(python, scene):
    with tempfile.TemporaryDirectory() as folder:
        before, after = Path(folder) / "scene.json", Path(folder) / "result.json"
        before.write_text(json.dumps(scene), encoding="utf-8")
        process = subprocess.run([python, HERE / "kratos_dynamics.py", before, after], check=False, capture_output=True,
                                 text=True, env={**os.environ, **peers.ONE_CORE})
        if process.returncode:
            raise BenchmarkError(peers.failure("Kratos", process))
        return json.loads(after.read_text(encoding="utf-8"))


def last_height(prefix):
    from results import Results

    return float(Results(prefix).column("track_top_uy")[-1])


def beside_kratos(arguments):
    python = find_kratos(arguments)
    table = Table(arguments.out, "dynamics_kratos", ("integrator", "code", "points", "steps", "newton", "top_uy", "seconds",
                                                     "ns_per_point_step", "over_talus"))
    cells = BLOCK["cells"] // (2 if arguments.quick else 1)
    for integrator in ("explicit", "newmark"):
        count = BLOCK["steps"] // (4 if arguments.quick else 1) // (1 if integrator == "explicit" else 20)
        dt = BLOCK["dt"] * (1 if integrator == "explicit" else 20)
        options = {"mpm_grid_cells": f"{cells},{cells}", "mpm_time_integrator": integrator, "mpm_time_step": dt,
                   "mpm_time_end": count * dt}
        scene = {"integrator": integrator, "cells": cells, "steps": count, "dt": dt}
        rounds = [(run_scene(arguments.program, HERE / "dynamics_block.yaml", options, measure=last_height),
                   kratos_run(python, scene) if python else None) for _ in range(arguments.repeat)]
        one = rounds[0][0]
        if not one.completed:
            raise BenchmarkError(f"dynamics_block.yaml: {one.status}")
        ours = statistics.median(run["time_total_s"] - run["setup"] - run["output"] for run, _ in rounds)
        table.add(integrator=integrator, code="Talus", points=one["points"], steps=one["steps"], newton=one["newton_iterations"],
                  top_uy=one.value, seconds=ours, ns_per_point_step=1e9 * ours / (one["points"] * one["steps"]), over_talus=1.0)
        if not python:
            continue
        other = rounds[0][1]
        seconds = statistics.median(run["seconds"] for _, run in rounds)
        table.add(integrator=integrator, code=f"Kratos {peers.VERSION}", points=other["points"], steps=other["steps"],
                  newton=other["newton_iterations"], top_uy=other["top_uy"], seconds=seconds,
                  ns_per_point_step=1e9 * seconds / (other["points"] * other["steps"]), over_talus=seconds / ours)


PARTS = {"steps": steps, "newton": newton, "errors": errors, "kratos": beside_kratos}


def run(arguments):
    arguments.repeat = arguments.repeat or (1 if arguments.quick else 5)
    arguments.helper = arguments.helper or str(Path(arguments.program).parent / "bench_dynamics")
    check_program(arguments.helper)
    check_program(arguments.program)
    for part in arguments.only:
        PARTS[part](arguments)
