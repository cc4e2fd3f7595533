"""The cantilever's time by stage, for cell counts and forms of the Jacobian.

The scene is that of examples/cantilever.
"""
from bench import figures
from bench.runs import CANTILEVER, TIMERS, Table, median, repeated, run_scene


def add_arguments(parser):
    parser.set_defaults(ranks=2, repeat=None)
    parser.add_argument("--cells", type=int, nargs="+", metavar="N", help="cells an axis (60 240)")
    parser.add_argument("--jacobian", nargs="+", default=["local", "coloring"], metavar="FORM",
                        help="values of -mpm_jacobian (local coloring)")


def row(arguments, cells, form, repeat):
    options = {"mpm_grid_cells": f"{cells},{cells}", "mpm_jacobian": form}
    runs = repeated(repeat, lambda: run_scene(arguments.program, CANTILEVER, options, arguments.ranks))
    values = {"cells": cells, "form": form, "ranks": arguments.ranks, "status": runs[0].status}
    if runs[0].summary is None:
        return values
    points, newton = runs[0]["points"], runs[0]["newton_iterations"]
    work = (median(runs, "residual") + median(runs, "jacobian")) * arguments.ranks / (points * newton) * 1e6
    return {**values, "points": points, "newton": newton, **{timer: median(runs, timer) for timer in TIMERS},
            "total": median(runs, "time_total_s"), "us_per_point_iteration_core": work}


def draw(table, folder):
    figure, (axes,) = figures.panels(1, width=7.0)
    rows = [row for row in table.rows if "total" in row]
    bottom = [0.0] * len(rows)
    for colour, timer in zip(figures.COLOURS, TIMERS):
        heights = [row[timer] for row in rows]
        axes.bar(range(len(rows)), heights, bottom=bottom, color=colour, label=timer)
        bottom = [low + height for low, height in zip(bottom, heights)]
    axes.set_xticks(range(len(rows)), [f"{row['form']}\n{row['cells']} cells" for row in rows])
    figures.label(axes, "cantilever, 50 steps", "", "seconds", log="")
    axes.set_axisbelow(True)
    axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), frameon=False)
    figures.save(figure, folder, "stages")


def run(arguments):
    cells = arguments.cells or ([30] if arguments.quick else [60, 240])
    table = Table(arguments.out, "stages", ["cells", "points", "form", "ranks", "newton", *TIMERS, "total",
                                            "us_per_point_iteration_core", "status"])
    for form in arguments.jacobian:
        for count in cells:
            table.add(**row(arguments, count, form, arguments.repeat or (1 if arguments.quick else 3)))
    draw(table, arguments.out)
