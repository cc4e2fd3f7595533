"""Gradients against the runs they belong to: whole processes, for a number of parameters.

Forward is the run alone. The adjoint's and the tangent's cost is the process with the gradient less that without, over the
latter; `gradient` is the part of it that the program measures itself.
"""
from bench.runs import CANTILEVER, ROOT, Table, median, repeated, run_scene

BENCH = ROOT / "scripts" / "bench"
# Scene, options of the long and the quick run, a column, parameters.
SCENES = {
    "cantilever": (CANTILEVER, {"mpm_grid_cells": "240,240"}, {"mpm_grid_cells": "30,30"}, "track_tip_ux",
                   ["beam.E", "tip.factor", "beam.nu"]),
    "slope": (BENCH / "gradient_slope.yaml", {}, {"mpm_grid_cells": "24,11"}, "track_crest_uy",
              ["soil.E", "soil.nu", "soil.density", "weight.factor"]),
    "footing": (BENCH / "gradient_footing.yaml", {}, {"mpm_grid_cells": "6,6,8"}, "reaction_footing_z",
                ["clay.E", "clay.yield_stress", "clay.nu", "clay.hardening"]),
}
COLUMNS = ["scene", "points", "steps", "newton", "method", "parameters", "forward_s", "process_s", "gradient_s", "ratio",
           "status"]


def add_arguments(parser):
    parser.set_defaults(ranks=1)
    parser.add_argument("--scenes", nargs="+", default=list(SCENES), metavar="NAME", help="cantilever, slope, footing (all)")
    parser.add_argument("--counts", type=int, nargs="+", default=[1, 4], metavar="N", help="numbers of parameters (1 4)")


def gradient_options(method, parameters, column):
    return {"mpm_task": "gradient", "mpm_gradient_method": method, "mpm_gradient_parameters": ",".join(parameters),
            "mpm_objectives": "u", "mpm_objective_u_column": column, "mpm_objective_u_kind": "value"}


def measure(arguments, name, table):
    scene, long, quick, column, parameters = SCENES[name]
    options = {**(quick if arguments.quick else long), "mpm_output_every": 0}
    repeat = arguments.repeat or (1 if arguments.quick else 3)

    def runs(extra):
        return repeated(repeat, lambda: run_scene(arguments.program, scene, {**options, **extra}, arguments.ranks))

    forward = runs({})
    for method in ("adjoint", "tangent"):
        for count in arguments.counts:
            chosen = parameters[:count]
            found = runs(gradient_options(method, chosen, column))
            values = {"scene": name, "method": method, "parameters": len(chosen), "status": found[0].status}
            if found[0].completed and forward[0].completed:
                alone, process = median(forward, "time_total_s"), median(found, "time_total_s")
                values |= {"points": forward[0]["points"], "steps": forward[0]["steps"],
                           "newton": forward[0]["newton_iterations"], "forward_s": alone, "process_s": process,
                           "gradient_s": median(found, "gradient"), "ratio": (process - alone) / alone}
            table.add(**values)


def run(arguments):
    table = Table(arguments.out, "gradient", COLUMNS)
    for name in arguments.scenes:
        measure(arguments, name, table)
