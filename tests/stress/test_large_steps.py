#!/usr/bin/env python3
"""Steps ten times too long, up to the whole load in one: cut as often as needed, the end is that of the usual step.

A longer step changes the answer even where Newton converges: domains and shape functions are those of the step's start.
The reach of each comparison is a part of the whole displacement. With F-bar the same holds: none of these is nearly
incompressible as long as it is elastic.

With --full: the same at half the cell size, on 1 and 2 ranks.
"""
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))
from hostile import Hostile  # noqa: E402
from talus_test import FULL, example  # noqa: E402

LIMIT = 60.0  # s, for one run

# example, tracked displacement, steps to try, how far the end may be from that of the example's own step
CASES = (
    ("cantilever", "track_tip_uy", (0.2, 1), 0.05),
    ("bar_elastic", "track_top_uy", (0.25, 1), 0.05),
    ("bar_j2", "track_top_uy", (0.25, 1), 0.05),
    ("collapse", "track_top_uy", (0.1, 0.25, 1), 0.1),
)

FBAR = {"mpm_stabilization_fbar": "true"}

with Hostile(LIMIT) as test:
    variants = {"": {}, ".fbar": FBAR} if test.takes(example("bar_elastic"), **FBAR) else {"": {}}
    for name, column, steps, reach in CASES:
        for refine, ranks in ((1, 1), (1, 2), (2, 1), (2, 2)) if FULL else ((1, 1),):
            where = name if (refine, ranks) == (1, 1) else f"{name}.h_over_{refine}.{ranks}_ranks"
            options = {"mpm_quiet": None, "mpm_grid_refine": refine, "ranks": ranks}
            usual = test.ends(f"{where}.usual_step", example(name), **options)
            for variant, more in variants.items():
                for step in steps if not more else (None, *steps):
                    label = f"{where}{variant}.{'usual_step' if step is None else f'step_{step:g}'}"
                    length = {} if step is None else {"mpm_time_step": step}
                    run = test.ends(label, example(name), **length, **more, **options)
                    if run.completed and usual.completed:
                        test.near(f"{label}.{column}", run.last(column), usual.last(column), relative=reach)
