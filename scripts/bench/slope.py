"""Newton and linear iterations of a slope in 3D, associated and not, against the cell size.

A slope of 2:1 between a rough wall and a plane of symmetry, Mohr-Coulomb with a dilation angle of 0 and of the friction
angle: at rest under its weight, then with its strength divided by 1.1 and by 1.2. Cells of 1.25, 0.83 and 0.625 m: 8 700,
26 000 and 59 000 unknowns. What counts are the solves of the second stage, whose points yield.
"""
import csv

from bench import figures
from bench.runs import ROOT, Table, median, repeated, run_scene

SCENE = ROOT / "scripts" / "bench" / "slope3d.yaml"
FRICTION, COARSE, STAGE = 20, 2.5, 2  # degrees, m: of the scene; the stage that reduces its strength


def add_arguments(parser):
    parser.set_defaults(ranks=1)
    parser.add_argument("--refine", type=int, nargs="+", metavar="N",
                        help="parts that 2.5 m is cut into for cells (2 3 4; quick 1 2)")
    parser.add_argument("--dilation", type=float, nargs="+", metavar="DEG", help="dilation angles (0 20)")
    parser.add_argument("--solver", default="amg", metavar="NAME", help="preset (amg)")
    parser.add_argument("--limit", type=float, metavar="S", help="a run that takes longer is ended (1800; quick 120)")


def iterations(prefix):
    """Newton and linear iterations of the stage."""
    with open(prefix + "_history.csv", newline="", encoding="utf-8") as file:
        rows = [row for row in csv.DictReader(file) if int(row["stage"]) == STAGE]
    return sum(int(row["newton"]) for row in rows), sum(int(row["linear"]) for row in rows)


def measure(arguments, dilation, refine, table):
    options = {"mpm_material_soil_dilation": dilation, "mpm_grid_refine": refine, "mpm_solver": arguments.solver}
    runs = repeated(arguments.repeat, lambda: run_scene(arguments.program, SCENE, options, arguments.ranks,
                                                        arguments.limit, iterations))
    values = {"dilation": dilation, "h": COARSE / refine, "solver": arguments.solver, "ranks": arguments.ranks,
              "status": runs[0].status}
    if runs[0].completed:
        newton, linear = runs[0].value
        before = table.select(dilation=dilation, solver=arguments.solver, status="completed")
        a_solve = linear / newton
        values.update(unknowns=runs[0]["active_dofs_max"], newton=newton, linear=linear, iterations_per_solve=a_solve,
                      growth=a_solve / before[0]["iterations_per_solve"] if before else 1.0,
                      newton_in_all=runs[0]["newton_iterations"], linear_in_all=runs[0]["linear_iterations"],
                      solve=median(runs, "solve"), total=median(runs, "time_total_s"))
    table.add(**values)


def draw(arguments, table, dilations):
    figure, axes = figures.panels(2)
    for dilation, colour, marker in zip(dilations, figures.COLOURS, figures.MARKERS):
        rows = table.select(dilation=dilation, status="completed")
        name = "psi = phi" if dilation == FRICTION else f"psi = {dilation:g}"
        axes[0].plot([row["h"] for row in rows], [row["iterations_per_solve"] for row in rows], color=colour,
                     marker=marker, label=name)
        axes[1].plot([row["h"] for row in rows], [row["newton"] for row in rows], color=colour, marker=marker)
    figures.label(axes[0], "iterations of a linear solve", "h (m)", "iterations", log="x")
    figures.label(axes[1], "Newton iterations of the stage", "h (m)", "iterations", log="x")
    for panel in axes:
        panel.set_ylim(0.0, None)
        figures.ticks(panel, {row["h"] for row in table.rows})
    axes[0].legend()
    figures.save(figure, arguments.out, "slope")


def run(arguments):
    arguments.repeat = arguments.repeat or 1
    arguments.limit = arguments.limit or (120.0 if arguments.quick else 1800.0)
    dilations = arguments.dilation or (0.0, float(FRICTION))
    table = Table(arguments.out, "slope", [
        "dilation", "h", "solver", "ranks", "unknowns", "newton", "linear", "iterations_per_solve", "growth",
        "newton_in_all", "linear_in_all", "solve", "total", "status"])
    for dilation in dilations:
        for refine in arguments.refine or ((1, 2) if arguments.quick else (2, 3, 4)):
            measure(arguments, dilation, refine, table)
    draw(arguments, table, dilations)
    return 0
