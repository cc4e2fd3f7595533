"""The Jacobian's action at the points, without a matrix: nanoseconds a point by shape and order.

A block full of points of a neo-Hookean solid (atpoints.yaml), (p + 1)^3 points a cell with elements of order p, and 2^3
with averaged shapes, on the cells' lattice and off it, where their domains cross faces. The program bench_atpoints
measures all forms in turn on one prepared step, in time of the processor, together with the machine: `triad` and `fma`.
The limit is the longer one of the times in which a product's numbers are read at `triad`, and its operations are done at
`fma`. `share` is the limit over the measured time. BAIJ's product of the same operator is beside it.
"""
import statistics
from collections import defaultdict
from pathlib import Path

from bench import figures
from bench.runs import ROOT, BenchmarkError, Table, check_program, execute, words_of

SCENE = ROOT / "scripts" / "bench" / "atpoints.yaml"
MOVED = {"mpm_grid_upper": "1.02,1.03,1.04"}  # the block's points then lie anywhere in the cells
# shape, order, points a cell and axis, cells an axis, and quick ones, further options
CASES = {"element 1": ("element", 1, 2, 20, 8, {}), "element 2": ("element", 2, 3, 12, 5, {}),
         "element 3": ("element", 3, 4, 8, 4, {}), "element 4": ("element", 4, 5, 6, 3, {}),
         "gimp": ("gimp", 1, 2, 20, 8, {}), "gimp, moved": ("gimp", 1, 2, 20, 8, MOVED),
         "bspline2": ("bspline2", 1, 2, 20, 8, MOVED), "bspline3": ("bspline3", 1, 2, 20, 8, MOVED),
         "gimp_bspline2": ("gimp_bspline2", 1, 2, 20, 8, {}), "gimp_bspline2, moved": ("gimp_bspline2", 1, 2, 20, 8, MOVED)}


def add_arguments(parser):
    parser.set_defaults(ranks=1)
    parser.add_argument("--cases", nargs="+", choices=tuple(CASES), default=tuple(CASES), metavar="CASE",
                        help=f"some of {', '.join(CASES)} (all)")
    parser.add_argument("--no-matrix", action="store_true", help="nothing assembled")
    parser.add_argument("--helper", metavar="PROGRAM", help="the program bench_atpoints (beside --program)")


def measure(arguments, case):
    """Medians of what bench_atpoints prints."""
    shape, order, points, cells, quick, further = CASES[case]
    cells = quick if arguments.quick else cells
    options = {"mpm_shape": shape, "mpm_grid_cells": f"{cells},{cells},{cells}",
               "mpm_body_block_points_per_cell": f"{points},{points},{points}", "mpm_quiet": None,
               "bench_rounds": arguments.repeat, "bench_assembled": "false" if arguments.no_matrix else "true", **further}
    if "element" in shape:
        options["mpm_order"] = order
    status, output, errors = execute([arguments.helper, "-options_file", str(SCENE)] + words_of(options))
    if status != 0:
        raise BenchmarkError(f"bench_atpoints, {case}: exit status {status}\n{errors.strip()[-400:]}")
    numbers = defaultdict(list)
    for line in output.splitlines():
        name, value = line.split()
        numbers[name].append(float(value))
    return {name: statistics.median(values) for name, values in numbers.items()}


def row_of(case, found):
    points, seconds = found["points"], found["stored"]
    limit = max(found["bytes"] / found["triad"], found["operations"] / found["fma"])
    row = {"case": case, "points": int(points), "unknowns": int(found["unknowns"]), "ns": 1e9 * seconds / points,
           "limit_ns": 1e9 * limit / points, "share": limit / seconds, "direct_ns": 1e9 * found["direct"] / points,
           "bytes_a_point": found["stored_bytes"] / points, "triad_GB_s": found["triad"] / 1e9,
           "fma_Gflop_s": found["fma"] / 1e9, "difference": found["difference"]}
    if "baij" in found:
        row.update(over_baij=seconds / found["baij"],
                   set_up_over_assembly=(found["set_up"] + found["tangents"]) / found["assembly"],
                   lines_over_assembly=found["set_up"] / found["assembly"],
                   memory_over_assembled=found["stored_bytes"] / found["assembled_bytes"],
                   memory_over_baij=found["stored_bytes"] / found["baij_bytes"])
    return row


def draw(arguments, rows):
    figure, axes = figures.panels(1)
    places = range(len(rows))
    for name, shift, colour in (("ns", -0.2, 0), ("limit_ns", 0.2, 1)):
        axes[0].bar([place + shift for place in places], [row[name] for row in rows], 0.4,
                    color=figures.COLOURS[colour], label={"ns": "measured", "limit_ns": "limit"}[name])
    axes[0].set_xticks(list(places), [row["case"] for row in rows], rotation=45, ha="right", fontsize="small")
    axes[0].set_ylabel("ns a point")
    axes[0].set_title("action at the points")
    axes[0].legend(fontsize="small")
    figures.save(figure, arguments.out, "atpoints")


def run(arguments):
    arguments.repeat = arguments.repeat or (1 if arguments.quick else 5)
    arguments.helper = arguments.helper or str(Path(arguments.program).parent / "bench_atpoints")
    check_program(arguments.helper)
    table = Table(arguments.out, "atpoints", [
        "case", "points", "unknowns", "ns", "limit_ns", "share", "direct_ns", "over_baij", "set_up_over_assembly",
        "lines_over_assembly", "bytes_a_point", "memory_over_assembled", "memory_over_baij", "triad_GB_s",
        "fma_Gflop_s", "difference"])
    for case in arguments.cases:
        table.add(**row_of(case, measure(arguments, case)))
    draw(arguments, table.rows)
    return 1 if any(row["difference"] > 1e-13 for row in table.rows) else 0
