"""Run time against error, for settings, cell sizes, points a cell and solvers.

A setting is a shape with its edges and penalty. Two cases: `bar`, the column of examples/bar_elastic with its exact
solution, and `cantilever`, a beam that hangs under its own weight, with a limit from finite elements. A run that fails
is a row that says how. Afterwards come the observed order of each setting, fitted over the cell sizes with the first
solver, and how each curve of seconds over error lies to the points of plain GIMP with the direct solver.
"""
import itertools
from math import exp, inf, log

from bench import figures
from bench.accuracy import CASES, SETTINGS, order
from bench.runs import Table, in_turn, median, run_scene

POINTS, QUICK_POINTS = (2, 3, 4, 6), (2, 3)
SOLVERS, QUICK_SOLVERS = ("direct", "amg", "boomeramg"), ("direct", "amg")
PLAIN = {"setting": "gimp", "solver": "direct"}
FRONT_WIDTH = 5.0  # points


def add_arguments(parser):
    parser.set_defaults(ranks=1)
    parser.add_argument("--cases", nargs="+", choices=tuple(CASES), default=tuple(CASES), help="(both)")
    parser.add_argument("--settings", nargs="+", choices=tuple(SETTINGS), default=tuple(SETTINGS), help="(all)")
    parser.add_argument("--bar-cells", type=int, nargs="+", metavar="N", help="cells over the height (8 12 16 ... 512)")
    parser.add_argument("--cantilever-cells", type=int, nargs="+", metavar="N", help="cells an axis (30 60 120 240)")
    parser.add_argument("--points", type=int, nargs="+", metavar="N", help="points a cell and axis (2 3 4 6)")
    parser.add_argument("--solvers", nargs="+", metavar="NAME", help="presets (direct amg boomeramg)")
    parser.add_argument("--limit", type=float, metavar="S", help="a run that takes longer is ended (600; quick 60)")


def levels(arguments, case, setting):
    given = {"bar": arguments.bar_cells, "cantilever": arguments.cantilever_cells}[case.name]
    return given or case.coarse.get(setting, ()) + (case.quick_levels if arguments.quick else case.levels)


def measure(arguments, case, table):
    """All runs of a case; they take turns, since curves are compared across cell sizes."""
    keys = [(*key, level) for key in itertools.product(arguments.settings, arguments.points, arguments.solvers)
            for level in levels(arguments, case, key[0])]

    def run_of(setting, points, solver, level):
        options = {**case.options(level, points), **SETTINGS[setting], "mpm_solver": solver,
                   "mpm_output_every": 1000000}  # the first and the last state
        return run_scene(arguments.program, case.scene, options, arguments.ranks, arguments.limit, case.error)

    all_runs = in_turn(arguments.repeat, [lambda key=key: run_of(*key) for key in keys])
    for (setting, points, solver, level), runs in zip(keys, all_runs):
        row = {"case": case.name, "setting": setting, "points_per_cell": points, "solver": solver, "cells": level,
               "h": case.cell_size(level), "ranks": arguments.ranks, "status": runs[0].status}
        if runs[0].summary:
            row.update(points=runs[0]["points"], unknowns=runs[0]["active_dofs_max"],
                       newton=runs[0]["newton_iterations"], linear=runs[0]["linear_iterations"],
                       cuts=runs[0]["step_cuts"], error=runs[0].value, seconds=median(runs, "time_total_s"))
        table.add(**row)


def completed(table, **values):
    return [row for row in table.select(**values) if row.get("error")]


def orders(arguments, table):
    """The observed orders, one row for each case, setting and number of points."""
    columns = ["case", "setting", "points_per_cell", "solver", "levels", "order"]
    result = Table(arguments.out, "error_time_orders", columns)
    solver = arguments.solvers[0]
    for case, setting, points in itertools.product(arguments.cases, arguments.settings, arguments.points):
        rows = completed(table, case=case, setting=setting, points_per_cell=points, solver=solver)
        if rows:
            result.add(case=case, setting=setting, points_per_cell=points, solver=solver, levels=len(rows),
                       order=order([row["h"] for row in rows], [row["error"] for row in rows]))


def seconds_at(rows, error):
    """Where a curve has come down to an error: the time of its cheapest run that is as good, or log-linearly between
    a run that is not and the next one that is; infinite where no run is."""
    best = min((row["seconds"] for row in rows if row["error"] <= error), default=inf)
    rows = sorted(rows, key=lambda row: row["error"])
    for fine, coarse in zip(rows, rows[1:]):
        if fine["error"] <= error < coarse["error"]:
            part = log(error / fine["error"]) / log(coarse["error"] / fine["error"])
            best = min(best, exp((1.0 - part) * log(fine["seconds"]) + part * log(coarse["seconds"])))
    return best


def against_plain(arguments, table):
    """For each curve: at how many points of plain GIMP with the direct solver it has the same error in less time, and
    the least and the largest ratio of its time to theirs."""
    columns = ["case", "setting", "points_per_cell", "solver", "plain_points", "faster", "least_ratio", "largest_ratio"]
    result = Table(arguments.out, "error_time_against_gimp", columns)
    for case, setting, points, solver in itertools.product(arguments.cases, arguments.settings, arguments.points,
                                                           arguments.solvers):
        key = {"setting": setting, "solver": solver}
        rows = completed(table, case=case, points_per_cell=points, **key)
        plain = completed(table, case=case, **PLAIN)
        if key == PLAIN or not rows or not plain:
            continue
        ratios = [seconds_at(rows, row["error"]) / row["seconds"] for row in plain]
        result.add(case=case, points_per_cell=points, **key, plain_points=len(plain),
                   faster=sum(ratio < 1.0 for ratio in ratios), least_ratio=min(ratios), largest_ratio=max(ratios))


def front(rows):
    """The runs that no other run beats in both time and error, by time."""
    best = []
    for row in sorted(rows, key=lambda row: (row["seconds"], row["error"])):
        if not best or row["error"] < best[-1]["error"]:
            best.append(row)
    return best


def legend(arguments):
    settings = [figures.key(name, colour) for name, colour in zip(SETTINGS, figures.COLOURS)
                if name in arguments.settings]
    points = [figures.key(f"{points} x {points} points a cell", marker=marker, line="")
              for points, marker in zip(arguments.points, figures.MARKERS)]
    solvers = [figures.key(solver, line=line) for solver, line in zip(arguments.solvers, figures.LINES)]
    front_key = figures.key("none faster and better", "0.8")
    front_key.set_linewidth(FRONT_WIDTH)
    return settings + points + solvers + [front_key]


def draw(arguments, table):
    figure, panels = figures.panels_with_legend(len(arguments.cases), legend(arguments), width=6.0, height=5.6)
    for axes, name in zip(panels, arguments.cases):
        for setting, points, solver in itertools.product(arguments.settings, arguments.points, arguments.solvers):
            rows = completed(table, case=name, setting=setting, points_per_cell=points, solver=solver)
            axes.plot([row["seconds"] for row in rows], [row["error"] for row in rows], linewidth=1.0, markersize=4.5,
                      color=figures.COLOURS[list(SETTINGS).index(setting)],
                      marker=figures.MARKERS[arguments.points.index(points) % len(figures.MARKERS)],
                      linestyle=figures.LINES[arguments.solvers.index(solver) % len(figures.LINES)])
        best = front(completed(table, case=name))
        axes.step([row["seconds"] for row in best], [row["error"] for row in best], where="post", color="0.8",
                  linewidth=FRONT_WIDTH, zorder=0)
        figures.label(axes, CASES[name].title, "seconds", "error")
    figures.save(figure, arguments.out, "error_time")


def run(arguments):
    quick = arguments.quick
    arguments.points = list(arguments.points or (QUICK_POINTS if quick else POINTS))
    arguments.solvers = list(arguments.solvers or (QUICK_SOLVERS if quick else SOLVERS))
    arguments.repeat = arguments.repeat or (1 if quick else 3)
    arguments.limit = arguments.limit or (60.0 if quick else 600.0)
    table = Table(arguments.out, "error_time", [
        "case", "setting", "points_per_cell", "solver", "cells", "h", "ranks", "points", "unknowns", "newton", "linear",
        "cuts", "error", "seconds", "status"])
    for name in arguments.cases:
        measure(arguments, CASES[name], table)
    orders(arguments, table)
    against_plain(arguments, table)
    draw(arguments, table)
