#!/usr/bin/env python3
"""The cantilever: tip displacements against an independent program's, by cell size, and against the elastica; and how
much the ghost penalty moves the tip. With --full a finer grid."""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import EXAMPLES, FULL, Test, example, read_table  # noqa: E402

LENGTH = 10.0  # m
REACH = 1e-3  # of the length
ALPHA = 10.0  # F L^2/(E I) at full load
PENALTY_REACH = 3.8e-3  # of the length
MULTIGRID_MOST = 25.0  # iterations of a linear solve, on average


def tip(run):
    return np.array([run.results.column(f"track_tip_u{axis}")[-1] for axis in "xy"])


def with_multigrid(test, label, direct, **options):
    """The same run with GAMG and the default penalty: about the same tip, in few iterations."""
    run = test.run(example("cantilever"), ranks=2, mpm_output_every=50, mpm_quiet=None, mpm_solver="amg", **options)
    summary = run.results.summary
    test.check(f"{label}.penalty_moves_tip", np.linalg.norm(tip(run) - tip(direct)) / LENGTH, 1e-6, PENALTY_REACH)
    test.check(f"{label}.multigrid_iterations", summary["linear_iterations"] / summary["newton_iterations"], None, MULTIGRID_MOST)


with Test() as test:
    table = read_table(EXAMPLES / "cantilever" / "reference.csv")
    for size in (0.5, 0.25, 0.125, *([0.0625] if FULL else [])):
        label, cells = f"h={size:g}", round(15.0 / size)
        run = test.run(example("cantilever"), ranks=2, mpm_grid_cells=f"{cells},{cells}", mpm_output_every=50, mpm_quiet=None,
                       mpm_stabilization_ghost="off")
        values = test.check_example(label, run, "cantilever")
        row = np.flatnonzero((table["h"] == size) & (table["alpha"] == ALPHA))[0]
        for name in "uv":  # a check.py that fell back on loose bounds would not show it
            test.near(f"{label}.{name}_at_full_load", values[f"{name}_at_{ALPHA:g}"], table[name][row], absolute=REACH)
        test.check(f"{label}.tabulated_loads", sum(name.startswith("u_at_") for name in values), np.sum(table["h"] == size))
        test.check(f"{label}.v_over_elastica_bound", values["v_over_elastica"], 0.975, 1.025)
        test.check(f"{label}.newton_mean", run.newton.mean(), None, 5.0)
        test.check(f"{label}.step_cuts", run.results.summary["step_cuts"], None, 0)
        if size in (0.25, 0.125):
            with_multigrid(test, label, run, mpm_grid_cells=f"{cells},{cells}")
