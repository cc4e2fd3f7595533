"""The action of CEED's problems at points, beside tensor quadrature, dense matrices of cells and an assembled matrix.

`bp1` to `bp4`: projection and Poisson's equation of one and of three components, by scripts/bench/bps; `solid`: a neo-Hookean
solid at rest. The problems live on cubes with order + 2 points an axis in each, and have about as many nodes for every order. A
number is processor time by unknown, the median of the rounds of one process (scripts/bench/bps.c).
"""
import itertools
import subprocess
import tempfile
from pathlib import Path

from bench.runs import BenchmarkError, Table

PROBLEMS = {"bp1": "projection", "bp2": "projection_vector", "bp3": "poisson", "bp4": "poisson_vector", "solid": "solid"}
FORMS = ("at_points", "tensor", "dense", "baij")
CELLS = {2: 12, 3: 8, 4: 6}  # an axis: 25 nodes on it


def add_arguments(parser):
    parser.set_defaults(ranks=1)
    parser.add_argument("--problems", nargs="+", choices=tuple(PROBLEMS), default=tuple(PROBLEMS), help="(all)")
    parser.add_argument("--orders", type=int, nargs="+", choices=tuple(CELLS), default=tuple(CELLS), help="(2 3 4)")
    parser.add_argument("--points", choices=("gauss", "uniform", "random", "cloud"), default="gauss", help="places in a cell (gauss)")
    parser.add_argument("--law", default="neo_hookean", help="of the solid: a hyperelastic law with E and nu (neo_hookean)")


def scene(arguments, problem, order, cells):
    """Options of a scene without conditions and results."""
    count = ",".join(3 * [str(cells)])
    return {"mpm_dim": 3, "mpm_physics": PROBLEMS[problem], "mpm_plugin": Path(arguments.program).resolve().parent / "bp.so",
            "mpm_grid_lower": "0,0,0", "mpm_grid_upper": count, "mpm_grid_cells": count, "mpm_shape": "element", "mpm_order": order,
            "mpm_materials": "m", "mpm_material_m_type": arguments.law if problem == "solid" else "linear_elastic",
            "mpm_material_m_E": 1, "mpm_material_m_nu": 0.3, "mpm_bodies": "cube", "mpm_body_cube_region": "box",
            "mpm_body_cube_lower": "0,0,0", "mpm_body_cube_upper": count, "mpm_body_cube_material": "m",
            "mpm_body_cube_points_per_cell": ",".join(3 * [str(order + 2)]), "mpm_stabilization_ghost": "off",
            "mpm_stabilization_fbar": "false", "mpm_time_step": 1, "mpm_time_end": 1}


def measure(arguments, problem, order, folder):
    """A number for each form; the number of unknowns; the difference of the forms."""
    cells = 2 if arguments.quick else CELLS[order]
    options = {**scene(arguments, problem, order, cells), "bench_problem": problem, "bps_points": arguments.points,
               "bench_rounds": arguments.repeat or (1 if arguments.quick else 7), "bench_sample": 0.002 if arguments.quick else 0.05}
    command = [Path(arguments.program).resolve().parent / "bench_bps"]
    for name, value in options.items():
        command += ["-" + name, value]
    process = subprocess.run([str(word) for word in command], cwd=folder, capture_output=True, text=True, check=False)
    if process.returncode:
        raise BenchmarkError(f"bench_bps ended with status {process.returncode}: {process.stderr[:2000]}")
    return {words[0]: float(words[1]) for words in map(str.split, process.stdout.splitlines()) if len(words) == 2}


def draw(rows, folder):
    from bench import figures

    orders = sorted({row["order"] for row in rows})
    handles = [figures.key(form.replace("_", " "), colour, marker, "") for form, colour, marker in
               zip(FORMS, figures.COLOURS, figures.MARKERS)]
    figure, panels = figures.panels_with_legend(len(orders), handles, width=3.6)
    for axes, order in zip(panels, orders):
        here = [row for row in rows if row["order"] == order]
        for form, colour, marker in zip(FORMS, figures.COLOURS, figures.MARKERS):
            axes.plot(range(len(here)), [row[form] for row in here], marker, color=colour)
        figures.label(axes, f"order {order}", "problem", "ns by unknown", log="y")
        axes.set_xticks(range(len(here)), [row["problem"] for row in here])
    figures.save(figure, folder, "bps")


def run(arguments):
    table = Table(arguments.out, "bps", ["problem", "order", "points", "unknowns", *FORMS, "over_tensor", "over_dense", "difference"])
    with tempfile.TemporaryDirectory(prefix="talus_bps_") as folder:
        for order, problem in itertools.product(arguments.orders, arguments.problems):
            found = measure(arguments, problem, order, folder)
            table.add(problem=problem, order=order, points=arguments.points, unknowns=int(found["unknowns"]),
                      **{form: found[form] for form in FORMS}, over_tensor=found["at_points"] / found["tensor"],
                      over_dense=found["at_points"] / found["dense"], difference=found["difference"])
    if not arguments.quick:
        draw(table.rows, arguments.out)
