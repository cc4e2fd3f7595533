"""Iterations of the linear solver and seconds against the cell size, by preset.

In 2D the cantilever of examples/cantilever with h = 1/8, 1/16 and 1/32 m and 3 x 3, 4 x 4 and 6 x 6 points a cell; in
3D a thick cantilever of 17 000, 145 000 and 1 200 000 unknowns with 2 x 2 x 2 points a cell. A few load steps each. The
direct solver is left out in 3D beyond the smallest grid.
"""
from bench import figures
from bench.runs import CANTILEVER, ROOT, Table, median, repeated, run_scene

SOLVERS = ("direct", "amg", "boomeramg")
END_2D, END_3D = 0.1, 0.5  # s: 5 and 2 steps
PLANE_WIDTH, SPACE_LENGTHS = 15.0, (9, 3, 7)  # m, of the scenes' grids
DIRECT_MOST = 5  # cells a metre in 3D


def add_arguments(parser):
    parser.set_defaults(ranks=1)
    parser.add_argument("--dim", type=int, nargs="+", choices=(2, 3), default=(2, 3), help="(both)")
    parser.add_argument("--cells-2d", type=int, nargs="+", metavar="N", help="cells an axis in 2D (120 240 480)")
    parser.add_argument("--cells-3d", type=int, nargs="+", metavar="N", help="cells a metre in 3D, odd (5 11 23)")
    parser.add_argument("--points", type=int, nargs="+", metavar="N", help="points a cell and axis in 2D (3 4 6)")
    parser.add_argument("--solvers", nargs="+", default=SOLVERS, metavar="NAME", help="presets (direct amg boomeramg)")
    parser.add_argument("--limit", type=float, metavar="S", help="a run that takes longer is ended (1800; quick 120)")


def plane(cells, points):
    return {"scene": CANTILEVER, "dim": 2, "cells": cells, "h": PLANE_WIDTH / cells, "points_per_cell": points,
            "options": {"mpm_grid_cells": f"{cells},{cells}", "mpm_body_beam_points_per_cell": f"{points},{points}",
                        "mpm_time_end": END_2D}}


def space(cells):
    return {"scene": ROOT / "scripts" / "bench" / "cantilever3d.yaml", "dim": 3, "cells": cells, "h": 1.0 / cells,
            "points_per_cell": 2,
            "options": {"mpm_grid_cells": ",".join(str(length * cells) for length in SPACE_LENGTHS),
                        "mpm_time_end": END_3D}}


def problems(arguments):
    quick = arguments.quick
    if 2 in arguments.dim:
        for points in arguments.points or ((3,) if quick else (3, 4, 6)):
            for cells in arguments.cells_2d or ((60, 120) if quick else (120, 240, 480)):
                yield plane(cells, points)
    if 3 in arguments.dim:
        for cells in arguments.cells_3d or ((3,) if quick else (5, 11, 23)):
            yield space(cells)


def measure(arguments, problem, solver, table):
    values = {name: problem[name] for name in ("dim", "cells", "h", "points_per_cell")}
    values.update(solver=solver, ranks=arguments.ranks)
    if solver == "direct" and problem["dim"] == 3 and problem["cells"] > DIRECT_MOST:
        table.add(**values, status="left out: a direct solver in 3D")
        return
    options = {**problem["options"], "mpm_solver": solver, "mpm_output_every": 0}
    runs = repeated(arguments.repeat, lambda: run_scene(arguments.program, problem["scene"], options, arguments.ranks,
                                                        arguments.limit))
    values["status"] = runs[0].status
    if runs[0].summary:
        newton, linear = runs[0]["newton_iterations"], runs[0]["linear_iterations"]
        values.update(points=runs[0]["points"], unknowns=runs[0]["active_dofs_max"], newton=newton, linear=linear,
                      iterations_per_solve=linear / newton if newton else None,
                      seconds_per_solve=median(runs, "solve") / newton if newton else None,
                      solve=median(runs, "solve"), total=median(runs, "time_total_s"),
                      memory_mb=median(runs, "memory_max_bytes") / 1e6)
    table.add(**values)


def draw(arguments, table):
    kinds = sorted({(row["dim"], row["points_per_cell"]) for row in table.rows})
    handles = [figures.key(solver, colour) for solver, colour in zip(arguments.solvers, figures.COLOURS)]
    handles += [figures.key(f"{dim}D, {points} points an axis", marker=marker, line="")
                for (dim, points), marker in zip(kinds, figures.MARKERS)]
    figure, axes = figures.panels_with_legend(2, handles, width=5.6)
    for solver, colour in zip(arguments.solvers, figures.COLOURS):
        for (dim, points), marker in zip(kinds, figures.MARKERS):
            rows = [row for row in table.select(dim=dim, points_per_cell=points, solver=solver, status="completed")]
            style = {"color": colour, "marker": marker, "markerfacecolor": "none",
                     "linestyle": "-" if dim == 2 else "--"}
            if solver != "direct":
                axes[0].plot([row["h"] for row in rows], [row["iterations_per_solve"] for row in rows], **style)
            axes[1].plot([row["unknowns"] for row in rows], [row["seconds_per_solve"] for row in rows], **style)
    figures.label(axes[0], "iterations of a linear solve", "h (m)", "iterations", log="x")
    axes[0].set_ylim(0.0, None)
    figures.ticks(axes[0], {row["h"] for row in table.rows})
    figures.label(axes[1], "time of a linear solve, set-up included", "unknowns", "seconds")
    figures.save(figure, arguments.out, "solver")


def run(arguments):
    arguments.repeat = arguments.repeat or (1 if arguments.quick else 3)
    arguments.limit = arguments.limit or (120.0 if arguments.quick else 1800.0)
    table = Table(arguments.out, "solver", [
        "dim", "cells", "h", "points_per_cell", "solver", "ranks", "points", "unknowns", "newton", "linear",
        "iterations_per_solve", "seconds_per_solve", "solve", "total", "memory_mb", "status"])
    for problem in problems(arguments):
        for solver in arguments.solvers:
            measure(arguments, problem, solver, table)
    draw(arguments, table)
