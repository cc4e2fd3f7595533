"""Seconds on 1 and 2 ranks, and what ranks tell each other on 1, 2, 4 and 8.

The scenes are the cantilever of examples/cantilever and a thick one in 3D. Times are medians of runs that take turns;
on more ranks than the machine has cores they would say nothing and are not taken. Messages, their length and reductions
are those that PETSc's -log_view counts, the engine's own among them: the most of any rank, and the most over the least
where PETSc gives it. So are the floating-point operations, but these are PETSc's only.
"""
import os
import re
import tempfile
from pathlib import Path

from bench import figures
from bench.runs import CANTILEVER, ROOT, Table, in_turn, median, run_scene

LINES = {"MPI Msg Count": "messages", "MPI Msg Len (bytes)": "message_bytes", "MPI Reductions": "reductions",
         "Flops": "petsc_flops"}
STAGES = ("transfer", "residual", "jacobian", "solve", "migrate")
RATIOS = ("messages", "message_bytes", "petsc_flops")
COUNTED = (("messages", "messages", 1.0), ("message_bytes", "kilobytes sent", 1e-3), ("reductions", "reductions", 1.0))


def scenes(quick):
    """Scene file and options by name."""
    plane, space = ("60", "27,9,21") if quick else ("240", "81,27,63")
    return {"cantilever": (CANTILEVER, {"mpm_grid_cells": f"{plane},{plane}", "mpm_time_end": 0.1 if quick else 1.0}),
            "cantilever3d": (ROOT / "scripts" / "bench" / "cantilever3d.yaml",
                             {"mpm_grid_cells": space, "mpm_solver": "amg", "mpm_time_end": 0.25 if quick else 1.0})}


def add_arguments(parser):
    parser.set_defaults(ranks=None)
    parser.add_argument("--scenes", nargs="+", choices=tuple(scenes(True)), default=tuple(scenes(True)), help="(both)")
    parser.add_argument("--ranks", type=int, nargs="+", default=(1, 2), metavar="N", help="ranks that are timed (1 2)")
    parser.add_argument("--message-ranks", type=int, nargs="+", metavar="N", help="ranks whose messages are counted "
                        "(1 2 4 8; quick 1 2 4)")
    parser.add_argument("--solver", metavar="NAME", help="a preset (direct in 2D, amg in 3D)")


def parse_log(text):
    """The counts at the head of a log of -log_view: the most of any rank and, where it is given, most over least."""
    values = {}
    for line in text.splitlines():
        name, colon, rest = line.partition(":")
        numbers = re.findall(r"[-+0-9.eE]+", rest)
        if colon and name.strip() in LINES and numbers:
            entry = LINES[name.strip()]
            values[entry] = float(numbers[0])
            if entry in RATIOS and len(numbers) > 1:
                values[entry + "_ratio"] = float(numbers[1])
    return values


def options_of(arguments, name):
    scene, options = scenes(arguments.quick)[name]
    return scene, {**options, "mpm_output_every": 0, **({"mpm_solver": arguments.solver} if arguments.solver else {})}


def times(arguments, name, table):
    scene, options = options_of(arguments, name)
    allowed = [ranks for ranks in arguments.ranks if ranks <= os.cpu_count()]
    runs = dict(zip(allowed, in_turn(arguments.repeat, [
        lambda ranks=ranks: run_scene(arguments.program, scene, options, ranks) for ranks in allowed])))
    first = median(runs[allowed[0]], "time_total_s") if allowed else None
    for ranks in arguments.ranks:
        if ranks not in runs:
            table.add(scene=name, ranks=ranks, status="left out: more ranks than cores")
            continue
        total = median(runs[ranks], "time_total_s")
        table.add(scene=name, ranks=ranks, seconds=total, status=runs[ranks][0].status,
                  speedup=first / total if first and total else None,
                  efficiency=first * allowed[0] / (total * ranks) if first and total else None,
                  **{stage: median(runs[ranks], stage) for stage in STAGES})


def messages(arguments, name, table):
    scene, options = options_of(arguments, name)
    for ranks in arguments.message_ranks:
        with tempfile.TemporaryDirectory() as folder:
            log = Path(folder) / "log"
            run = run_scene(arguments.program, scene, {**options, "log_view": f":{log}"}, ranks)
            values = parse_log(log.read_text(encoding="utf-8")) if log.is_file() else {}
        if run.summary:
            values.update(points=run["points"], unknowns=run["active_dofs_max"], newton=run["newton_iterations"],
                          linear=run["linear_iterations"])
        table.add(scene=name, ranks=ranks, status=run.status, **values)


def draw(arguments, timed, counted):
    figure, axes = figures.panels(4, width=4.2)
    for place, name in enumerate(arguments.scenes):
        style = {"color": figures.COLOURS[place], "marker": figures.MARKERS[place], "label": name}
        rows = [row for row in timed.select(scene=name) if row.get("speedup")]
        axes[0].plot([row["ranks"] for row in rows], [row["speedup"] for row in rows], **style)
        rows = [row for row in counted.select(scene=name) if row.get("newton")]
        for panel, (entry, _, factor) in zip(axes[1:], COUNTED):
            panel.plot([row["ranks"] for row in rows],
                       [factor * row.get(entry, 0.0) / row["newton"] for row in rows], **style)
    ideal = [ranks / arguments.ranks[0] for ranks in arguments.ranks]
    axes[0].plot(arguments.ranks, ideal, "--", color="0.6", label="ideal")
    figures.label(axes[0], "speed-up", "ranks", "", log="")
    for panel, (_, title, _) in zip(axes[1:], COUNTED):
        figures.label(panel, f"{title} a Newton iteration, busiest rank", "ranks", "", log="")
        panel.set_ylim(0.0, None)
    for panel, ticks in zip(axes, (arguments.ranks, *[arguments.message_ranks] * 3)):
        panel.set_xticks(list(ticks))
    axes[0].legend()
    figures.save(figure, arguments.out, "scaling")


def run(arguments):
    arguments.repeat = arguments.repeat or (1 if arguments.quick else 3)
    arguments.message_ranks = arguments.message_ranks or ((1, 2, 4) if arguments.quick else (1, 2, 4, 8))
    timed = Table(arguments.out, "scaling", ["scene", "ranks", "seconds", "speedup", "efficiency", *STAGES, "status"])
    for name in arguments.scenes:
        times(arguments, name, timed)
    counted = Table(arguments.out, "scaling_messages", [
        "scene", "ranks", "points", "unknowns", "newton", "linear", "messages", "messages_ratio", "message_bytes",
        "message_bytes_ratio", "reductions", "petsc_flops", "petsc_flops_ratio", "status"])
    for name in arguments.scenes:
        messages(arguments, name, counted)
    draw(arguments, timed, counted)
