"""Run time against error, for shapes, cell sizes, points a cell and solvers.

Two cases: `bar`, the column of examples/bar_elastic with its exact solution, and `cantilever`, a beam that hangs under
its own weight, with a limit from finite elements. A run that fails is a row that says how. Afterwards the observed
order of each shape is printed, fitted over the cell sizes with the first solver.
"""
import itertools

from bench import figures
from bench.accuracy import CASES, order
from bench.runs import Table, median, repeated, run_scene

POINTS, QUICK_POINTS = (2, 3, 4, 6), (2, 3)
SOLVERS, QUICK_SOLVERS = ("direct", "amg", "boomeramg"), ("direct", "amg")
SHAPES = ("linear", "gimp", "bspline2", "bspline3", "gimp_bspline2")
FRONT_WIDTH = 5.0  # points


def add_arguments(parser):
    parser.set_defaults(ranks=1)
    parser.add_argument("--cases", nargs="+", choices=tuple(CASES), default=tuple(CASES), help="(both)")
    parser.add_argument("--shapes", nargs="+", choices=SHAPES,
                        help="shape functions (all)")
    parser.add_argument("--bar-cells", type=int, nargs="+", metavar="N", help="cells over the height (8 16 ... 512)")
    parser.add_argument("--cantilever-cells", type=int, nargs="+", metavar="N", help="cells an axis (30 60 120 240)")
    parser.add_argument("--points", type=int, nargs="+", metavar="N", help="points a cell and axis (2 3 4 6)")
    parser.add_argument("--solvers", nargs="+", metavar="NAME", help="presets (direct amg boomeramg)")
    parser.add_argument("--limit", type=float, metavar="S", help="a run that takes longer is ended (600; quick 60)")


def levels(arguments, case):
    given = {"bar": arguments.bar_cells, "cantilever": arguments.cantilever_cells}[case.name]
    return given or (case.quick_levels if arguments.quick else case.levels)


def measure(arguments, case, table):
    shapes = [shape for shape in case.shapes if not arguments.shapes or shape in arguments.shapes]
    for shape, points, solver, level in itertools.product(shapes, arguments.points, arguments.solvers,
                                                          levels(arguments, case)):
        options = {**case.options(level, points), "mpm_shape": shape, "mpm_solver": solver,
                   "mpm_output_every": 1000000}  # the first and the last state
        runs = repeated(arguments.repeat, lambda options=options: run_scene(
            arguments.program, case.scene, options, arguments.ranks, arguments.limit, case.error))
        row = {"case": case.name, "shape": shape, "points_per_cell": points, "solver": solver, "cells": level,
               "h": case.cell_size(level), "ranks": arguments.ranks, "status": runs[0].status}
        if runs[0].summary:
            row.update(points=runs[0]["points"], unknowns=runs[0]["active_dofs_max"],
                       newton=runs[0]["newton_iterations"], linear=runs[0]["linear_iterations"],
                       cuts=runs[0]["step_cuts"], error=runs[0].value, seconds=median(runs, "time_total_s"))
        table.add(**row)


def completed(table, **values):
    return [row for row in table.select(**values) if row.get("error")]


def orders(arguments, table):
    """The observed orders, one row for each case, shape and number of points."""
    columns = ["case", "shape", "points_per_cell", "solver", "levels", "order"]
    result = Table(arguments.out, "error_time_orders", columns)
    solver = arguments.solvers[0]
    for case, shape, points in itertools.product(arguments.cases, SHAPES, arguments.points):
        rows = completed(table, case=case, shape=shape, points_per_cell=points, solver=solver)
        if rows:
            result.add(case=case, shape=shape, points_per_cell=points, solver=solver, levels=len(rows),
                       order=order([row["h"] for row in rows], [row["error"] for row in rows]))


def front(rows):
    """The runs that no other run beats in both time and error, by time."""
    best = []
    for row in sorted(rows, key=lambda row: (row["seconds"], row["error"])):
        if not best or row["error"] < best[-1]["error"]:
            best.append(row)
    return best


def legend(arguments, table):
    seen = {row["shape"] for row in table.rows}
    shapes = [figures.key(shape, colour) for shape, colour in zip(SHAPES, figures.COLOURS) if shape in seen]
    points = [figures.key(f"{points} x {points} points a cell", marker=marker, line="")
              for points, marker in zip(arguments.points, figures.MARKERS)]
    solvers = [figures.key(solver, line=line) for solver, line in zip(arguments.solvers, figures.LINES)]
    front_key = figures.key("none faster and better", "0.8")
    front_key.set_linewidth(FRONT_WIDTH)
    return shapes + points + solvers + [front_key]


def draw(arguments, table):
    figure, panels = figures.panels_with_legend(len(arguments.cases), legend(arguments, table), width=6.0, height=5.6)
    for axes, name in zip(panels, arguments.cases):
        for shape, points, solver in itertools.product(SHAPES, arguments.points, arguments.solvers):
            rows = completed(table, case=name, shape=shape, points_per_cell=points, solver=solver)
            axes.plot([row["seconds"] for row in rows], [row["error"] for row in rows], linewidth=1.0, markersize=4.5,
                      color=figures.COLOURS[SHAPES.index(shape)],
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
        "case", "shape", "points_per_cell", "solver", "cells", "h", "ranks", "points", "unknowns", "newton", "linear",
        "cuts", "error", "seconds", "status"])
    for name in arguments.cases:
        measure(arguments, CASES[name], table)
    orders(arguments, table)
    draw(arguments, table)
