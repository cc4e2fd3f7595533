"""Seconds for one Jacobian by dual numbers, by a tangent coded by hand, by colours, densely and by differences.

The grids are the six of Table 2 of Zhao, Li, Jiang and Choo (2025), GeoWarp: the cantilever of examples/cantilever with
h = 1/2 to 1/16 m and 6 x 6 points a cell. All forms are measured in the same deformed state, in turn, by the program
bench_jacobian; their matrices are compared with the local one in the Frobenius norm (Fig. 15). Then the scene is run to
its end with each form (Figs 16, 17). `hand` is `local` with the tangent of scripts/bench/hencky_tangent.h.

What is expected to take longer than a limit is left out, with a row that says so.
"""
import statistics
from collections import defaultdict
from pathlib import Path

from bench import figures
from bench.runs import (CANTILEVER, BenchmarkError, Run, Table, check_program, execute, in_turn, median, run_scene,
                        words_of)

FORMS = ("local", "hand", "coloring", "dense", "fd")
RUN_FORMS = ("local", "hand", "coloring", "dense")
NAMES = {"local": "local (dual numbers)", "hand": "hand-coded tangent", "coloring": "colouring", "dense": "dense",
         "fd": "differences"}
WIDTH = 15.0  # m, of the scene's grid
CELLS, QUICK_CELLS = (30, 60, 90, 120, 180, 240), (30, 60)
DIFFERENCE = 1e-12  # what `hand` has to agree to with `local`


def add_arguments(parser):
    parser.set_defaults(ranks=1)
    parser.add_argument("--cells", type=int, nargs="+", metavar="N", help="cells an axis (30 60 90 120 180 240)")
    parser.add_argument("--forms", nargs="+", choices=FORMS, default=FORMS, help="forms of the Jacobian (all)")
    parser.add_argument("--steps", type=int, default=10, help="load steps, of 50, before the Jacobians are made (10)")
    parser.add_argument("--limit", type=float, metavar="S", help="no dense Jacobian that takes longer (60; quick 5)")
    parser.add_argument("--run-limit", type=float, metavar="S", help="no dense run that takes longer (300; quick 10)")
    parser.add_argument("--no-runs", action="store_true", help="single Jacobians only")
    parser.add_argument("--helper", metavar="PROGRAM", help="the program bench_jacobian (beside --program)")


def grid(cells):
    return {"mpm_grid_cells": f"{cells},{cells}"}


# ---- single Jacobians ----

def measure(arguments, cells):
    """What bench_jacobian prints: {key: number}, {key: {form: [numbers]}}."""
    options = {**grid(cells), "mpm_quiet": None, "bench_steps": arguments.steps, "bench_rounds": arguments.repeat,
               "bench_limit": arguments.limit, "bench_forms": ",".join(arguments.forms)}
    status, output, errors = execute([arguments.helper, "-options_file", str(CANTILEVER)] + words_of(options))
    if status != 0:
        raise BenchmarkError(f"bench_jacobian on {cells} x {cells} cells: exit status {status}\n{errors.strip()}")
    numbers, lists = {}, defaultdict(lambda: defaultdict(list))
    for line in output.splitlines():
        name, *rest = line.split()
        if len(rest) == 1:
            numbers[name] = float(rest[0])
        elif len(rest) == 2:
            lists[name][rest[0]].append(float(rest[1]))
    return numbers, lists


def assemblies(arguments, table, tangents):
    """Rows of single Jacobians; returns the seconds that a dense one is expected to take, by cells."""
    expected = {}
    for cells in arguments.cells:
        numbers, lists = measure(arguments, cells)
        seconds = {form: statistics.median(values) for form, values in lists["seconds"].items()}
        expected[cells] = seconds.get("dense", lists["expected"]["dense"][0] if lists["expected"] else float("inf"))
        for form in arguments.forms:
            row = {"h": WIDTH / cells, "cells": cells, "points": int(numbers["points"]),
                   "unknowns": int(numbers["unknowns"]), "form": form}
            if form not in seconds:
                table.add(**row, status=f"left out: about {expected[cells]:.3g} s")
                continue
            difference = lists["difference"][form][0] if form != "local" else 0.0
            table.add(**row, seconds=seconds[form], over_local=seconds[form] / seconds["local"],
                      over_hand=seconds[form] / seconds["hand"] if "hand" in seconds else None, difference=difference,
                      status="ok" if form != "hand" or difference <= DIFFERENCE else f"differs by over {DIFFERENCE:g}")
        add_tangents(tangents, cells, numbers, lists["tangent_ns"])
    return expected


def add_tangents(table, cells, numbers, nanoseconds):
    """The tangents alone, at the points."""
    dual, hand = (statistics.median(nanoseconds[form]) for form in ("local", "hand"))
    table.append({"h": WIDTH / cells, "cells": cells, "local_ns": dual, "hand_ns": hand, "local_over_hand": dual / hand,
                  "difference": numbers["tangent_difference"]})


# ---- whole runs ----

def whole_run(arguments, cells, form):
    options = {**grid(cells), "mpm_output_every": 0}
    if form == "hand":
        return run_scene(arguments.helper, CANTILEVER, {**options, "bench_run": None}, arguments.ranks)
    return run_scene(arguments.program, CANTILEVER, {**options, "mpm_jacobian": form}, arguments.ranks)


def whole_runs(arguments, table, expected):
    forms = [form for form in RUN_FORMS if form in arguments.forms]
    for cells in arguments.cells:
        short = [form for form in forms if form != "dense"]
        runs = dict(zip(short, in_turn(arguments.repeat, [lambda form=form: whole_run(arguments, cells, form)
                                                          for form in short])))
        if "dense" in forms:
            newton = runs["local"][0]["newton_iterations"] if runs["local"][0].completed else 0
            guess = newton * expected[cells]
            if newton and guess <= arguments.run_limit:
                runs["dense"] = in_turn(1, [lambda: whole_run(arguments, cells, "dense")])[0]
            else:
                runs["dense"] = [Run(f"left out: about {guess:.3g} s")]
        local = median(runs["local"], "time_total_s")
        for form, mine in runs.items():
            row = {"h": WIDTH / cells, "cells": cells, "form": form, "ranks": arguments.ranks, "status": mine[0].status}
            if mine[0].summary:
                total, jacobian = median(mine, "time_total_s"), median(mine, "jacobian")
                row.update(newton=mine[0]["newton_iterations"], seconds=total, jacobian_seconds=jacobian,
                           jacobian_percent=100.0 * jacobian / total, over_local=total / local if local else None)
            table.add(**row)


# ---- pictures ----

def curve(axes, rows, forms, entry):
    for form in forms:
        mine = [row for row in rows if row["form"] == form and row.get(entry)]
        if not mine:
            continue
        place = FORMS.index(form)
        axes.plot([1.0 / row["h"] for row in mine], [row[entry] for row in mine], color=figures.COLOURS[place],
                  marker=figures.MARKERS[place], markerfacecolor="none", label=NAMES[form])
    axes.legend(fontsize="small")


def draw(arguments, assembled, whole):
    figure, axes = figures.panels(3 if whole else 2)
    inverse = [1.0 / row["h"] for row in assembled.rows]
    curve(axes[0], assembled.rows, [form for form in arguments.forms if form != "local"], "difference")
    figures.label(axes[0], "difference from the local Jacobian", "1/h (1/m)", "relative Frobenius norm")
    curve(axes[1], assembled.rows, arguments.forms, "seconds")
    figures.label(axes[1], "one Jacobian", "1/h (1/m)", "seconds")
    if whole:
        curve(axes[2], whole.rows, [form for form in RUN_FORMS if form in arguments.forms], "seconds")
        figures.label(axes[2], "the whole run, 50 steps", "1/h (1/m)", "seconds")
    for panel in axes:
        figures.ticks(panel, set(inverse))
    figures.save(figure, arguments.out, "jacobian")


def run(arguments):
    quick = arguments.quick
    arguments.cells = arguments.cells or (QUICK_CELLS if quick else CELLS)
    arguments.repeat = arguments.repeat or (2 if quick else 5)
    arguments.limit = arguments.limit or (5.0 if quick else 60.0)
    arguments.run_limit = arguments.run_limit or (10.0 if quick else 300.0)
    arguments.forms = list(dict.fromkeys(["local", *arguments.forms]))
    arguments.helper = arguments.helper or str(Path(arguments.program).parent / "bench_jacobian")
    check_program(arguments.helper)
    assembled = Table(arguments.out, "jacobian", ["h", "cells", "points", "unknowns", "form", "seconds", "over_local",
                                                  "over_hand", "difference", "status"])
    tangents, whole = [], None
    expected = assemblies(arguments, assembled, tangents)
    alone = Table(arguments.out, "jacobian_tangents", list(tangents[0]))
    for row in tangents:
        alone.add(**row)
    if not arguments.no_runs:
        whole = Table(arguments.out, "jacobian_runs", ["h", "cells", "form", "ranks", "newton", "seconds",
                                                       "jacobian_seconds", "jacobian_percent", "over_local", "status"])
        whole_runs(arguments, whole, expected)
    draw(arguments, assembled, whole)
    return 1 if any(row["status"].startswith("differs") for row in assembled.rows) else 0
