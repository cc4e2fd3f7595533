"""Saturated ground: error against seconds, and the linear solvers over cell size, step and permeability.

`accuracy`: Mandel's problem (examples/mandel), the error of the pressure over its start, for cell sizes, steps, schemes and
shapes. `solvers`: one step of the consolidation of a block, in 2D and 3D, with the direct solver and with blocks of fields.
"""
import itertools
import sys

import numpy as np

from bench import figures
from bench.runs import ROOT, Table, in_turn, median, run_scene

for folder in ("scripts", "examples/mandel"):
    sys.path.insert(0, str(ROOT / folder))
import check as mandel  # noqa: E402  (the folders have to be known first)
from results import Results  # noqa: E402

MANDEL = ROOT / "examples" / "mandel" / "case.yaml"
BLOCKS = {dim: ROOT / "scripts" / "bench" / f"poro{dim}d.yaml" for dim in (2, 3)}
SOLVERS = ("direct", "poro-fieldsplit")
END = 4500.0  # s
# What a solver is tried on besides the cell size: permeability of the ground and of the seam in it, m2, and the step, s.
STATES = {"base": (1e-12, 1e-12, 1e2), "coarse": (1e-8, 1e-8, 1e2), "tight": (1e-16, 1e-16, 1e2), "layers": (1e-10, 1e-16, 1e2),
          "short": (1e-12, 1e-12, 1e-1), "long": (1e-12, 1e-12, 1e5)}


def add_arguments(parser):
    parser.set_defaults(ranks=1)
    parser.add_argument("--parts", nargs="+", choices=("accuracy", "solvers"), default=("accuracy", "solvers"), help="(both)")
    parser.add_argument("--refine", type=int, nargs="+", metavar="N", help="accuracy: refinements of the grid (1 2 4)")
    parser.add_argument("--steps", type=int, nargs="+", metavar="N", help="accuracy: steps (25 100 400)")
    parser.add_argument("--shapes", nargs="+", default=("linear", "gimp", "bspline2", "gimp_bspline2"), help="accuracy: (all but bspline3)")
    parser.add_argument("--cells-2d", type=int, nargs="+", metavar="N", help="solvers: refinements in 2D (2 4 8)")
    parser.add_argument("--cells-3d", type=int, nargs="+", metavar="N", help="solvers: refinements in 3D (1 2 3)")
    parser.add_argument("--limit", type=float, metavar="S", help="a run that takes longer is ended (900; quick 60)")


def mandel_error(prefix):
    """The largest error of the pressure at points and states, over that at the start."""
    results = Results(prefix)
    theory = mandel.Theory(results)
    place = results.initial["position0"][:, 0]
    states = [results.state(step) for step in results.steps[1:]]
    errors = [np.max(np.abs(state["pressure"].ravel() - theory.pressure(place, state.time))) for state in states]
    return max(errors) / (0.5 * theory.force / theory.a)


def accuracy(arguments):
    table = Table(arguments.out, "poro_accuracy", ["shape", "scheme", "refine", "steps", "unknowns", "newton", "error", "seconds", "status"])
    keys = list(itertools.product(arguments.shapes, ("euler", "second"), arguments.refine, arguments.steps))

    def run_of(shape, scheme, refine, steps):
        options = {"mpm_shape": shape, "mpm_time_scheme": scheme, "mpm_grid_refine": refine, "mpm_time_step": END / steps,
                   "mpm_output_every": max(steps // 5, 1)}
        return run_scene(arguments.program, MANDEL, options, arguments.ranks, arguments.limit, mandel_error)

    for key, runs in zip(keys, in_turn(arguments.repeat, [lambda key=key: run_of(*key) for key in keys])):
        row = dict(zip(("shape", "scheme", "refine", "steps"), key), status=runs[0].status)
        if runs[0].summary:
            row.update(unknowns=runs[0]["active_dofs_max"], newton=runs[0]["newton_iterations"], error=runs[0].value,
                       seconds=median(runs, "time_total_s"))
        table.add(**row)
    return table


def solvers(arguments):
    table = Table(arguments.out, "poro_solvers", ["dim", "refine", "state", "solver", "unknowns", "newton", "iterations_per_solve", "solve",
                                                  "total", "memory_mb", "status"])
    grids = [(2, refine) for refine in arguments.cells_2d] + [(3, refine) for refine in arguments.cells_3d]
    for (dim, refine), (state, (soil, seam, step)) in itertools.product(grids, STATES.items()):
        options = {"mpm_grid_refine": refine, "mpm_material_soil_permeability": soil,
                   "mpm_material_seam_permeability": seam, "mpm_time_step": step, "mpm_time_end": step}
        all_runs = in_turn(arguments.repeat, [lambda name=name: run_scene(arguments.program, BLOCKS[dim], {**options, "mpm_solver": name},
                                                                          arguments.ranks, arguments.limit) for name in SOLVERS])
        for name, runs in zip(SOLVERS, all_runs):
            row = {"dim": dim, "refine": refine, "state": state, "solver": name, "status": runs[0].status}
            if runs[0].summary:
                newton, linear = runs[0]["newton_iterations"], runs[0]["linear_iterations"]
                row.update(unknowns=runs[0]["active_dofs_max"], newton=newton, iterations_per_solve=linear / max(newton, 1),
                           solve=median(runs, "solve"), total=median(runs, "time_total_s"),
                           memory_mb=median(runs, "memory_max_bytes") / 1e6)
            table.add(**row)
    return table


def draw_accuracy(arguments, table):
    handles = [figures.key(shape, colour) for shape, colour in zip(arguments.shapes, figures.COLOURS)]
    handles += [figures.key(scheme, line=line) for scheme, line in zip(("euler", "second"), figures.LINES)]
    handles += [figures.key(f"h = a/{20 * refine}", marker=marker, line="") for refine, marker in zip(arguments.refine, figures.MARKERS)]
    figure, (axes,) = figures.panels_with_legend(1, handles, width=6.0, height=4.8)
    for (shape, colour), (scheme, line), (refine, marker) in itertools.product(
            zip(arguments.shapes, figures.COLOURS), zip(("euler", "second"), figures.LINES), zip(arguments.refine, figures.MARKERS)):
        rows = [row for row in table.select(shape=shape, scheme=scheme, refine=refine) if row.get("error")]
        axes.plot([row["seconds"] for row in rows], [row["error"] for row in rows], color=colour, linestyle=line, marker=marker, markersize=4.5)
    figures.label(axes, "Mandel's problem", "seconds", "error of the pressure over that at the start")
    figures.save(figure, arguments.out, "poro_accuracy")


def draw_solvers(arguments, table):
    handles = [figures.key(state, colour) for state, colour in zip(STATES, figures.COLOURS)]
    handles += [figures.key(f"{dim}D", marker=marker, line="") for dim, marker in zip((2, 3), figures.MARKERS)]
    handles += [figures.key(name, line=line) for name, line in zip(SOLVERS, figures.LINES)]
    figure, axes = figures.panels_with_legend(2, handles, width=5.2)
    for (state, colour), (dim, marker), (solver, line) in itertools.product(
            zip(STATES, figures.COLOURS), zip((2, 3), figures.MARKERS), zip(SOLVERS, figures.LINES)):
        rows = table.select(state=state, dim=dim, solver=solver, status="completed")
        style = {"color": colour, "marker": marker, "linestyle": line, "markerfacecolor": "none"}
        if solver != "direct":
            axes[0].plot([row["unknowns"] for row in rows], [row["iterations_per_solve"] for row in rows], **style)
        axes[1].plot([row["unknowns"] for row in rows], [row["solve"] for row in rows], **style)
    figures.label(axes[0], "iterations of a linear solve", "unknowns", "iterations", log="x")
    axes[0].set_ylim(0.0, None)
    figures.label(axes[1], "linear solves of a step, set-up included", "unknowns", "seconds")
    figures.save(figure, arguments.out, "poro_solvers")


def run(arguments):
    quick = arguments.quick
    arguments.repeat = arguments.repeat or (1 if quick else 3)
    arguments.limit = arguments.limit or (60.0 if quick else 900.0)
    arguments.refine = arguments.refine or ((1,) if quick else (1, 2, 4))
    arguments.steps = arguments.steps or ((25, 50) if quick else (25, 100, 400))
    arguments.cells_2d = arguments.cells_2d or ((1, 2) if quick else (2, 4, 8))
    arguments.cells_3d = arguments.cells_3d or ((1,) if quick else (1, 2, 3))
    if "accuracy" in arguments.parts:
        draw_accuracy(arguments, accuracy(arguments))
    if "solvers" in arguments.parts:
        draw_solvers(arguments, solvers(arguments))
