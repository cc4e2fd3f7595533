"""What it costs to redistribute the points, and what it brings: a heap that slides over the whole grid.

Scene scripts/bench/slide.yaml, with -mpm_grid_balance from 1.01 to never.
"""
from pathlib import Path

from bench.runs import Table, in_turn, median, run_scene

SCENE = Path(__file__).resolve().parent / "slide.yaml"
LIMITS = (1.01, 1.05, 1.1, 1.3, 1e9)


def add_arguments(parser):
    parser.set_defaults(ranks=2)
    parser.add_argument("--refine", type=int, help="cells an axis, times that of the scene (4; quick 1)")


def run(arguments):
    refine = arguments.refine or (1 if arguments.quick else 4)
    table = Table(arguments.out, "balance", ("ranks", "points", "balance", "imbalance", "rebalances", "migrate_s",
                                             "residual_s", "jacobian_s", "solve_s", "total_s"))
    runs = in_turn(arguments.repeat or (1 if arguments.quick else 3), [
        lambda limit=limit: run_scene(arguments.program, SCENE, {
            "mpm_grid_balance": limit, "mpm_grid_refine": refine}, arguments.ranks) for limit in LIMITS])
    for limit, mine in zip(LIMITS, runs):
        table.add(ranks=arguments.ranks, points=mine[0]["points"], balance=limit, imbalance=mine[0]["imbalance"],
                  rebalances=mine[0]["rebalances"], total_s=median(mine, "time_total_s"),
                  **{f"{stage}_s": median(mine, stage) for stage in ("migrate", "residual", "jacobian", "solve")})
