#!/usr/bin/env python3
"""The number of ranks changes nothing: the same steps and Newton iterations, and displacements equal to rounding."""
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import Test, difference, example  # noqa: E402

REACH = 1e-9  # relative to the largest value
SCENES = {"bar_elastic": example("bar_elastic"), "bar_j2": example("bar_j2"), "cantilever": example("cantilever"),
          "shaft": Path(__file__).resolve().parent / "shaft.yaml", "apart": Path(__file__).resolve().parent / "apart.yaml"}

# splines with not-a-knot ends; on 4 ranks MUMPS needs more workspace in the third step than it expects
OPEN = {"mpm_shape": "bspline2", "mpm_shape_edge": "open", "mpm_stabilization_ghost": 0.1, "mpm_solver": "direct",
        "mpm_time_end": 0.2, "snes_rtol": 1e-11}


def compare(test, label, one, other, ranks):
    steps = one.newton.size
    test.check(f"{label}.ranks", other.results.summary["ranks"], ranks, ranks)
    test.check(f"{label}.steps", other.newton.size, steps, steps)
    if other.newton.size == steps:
        test.check(f"{label}.newton_differs", (one.newton != other.newton).sum(), None, 0)
    test.check(f"{label}.ids_differ", (one.table("id") != other.table("id")).sum(), None, 0)
    for field in ("displacement", "stress", "volume"):
        test.check(f"{label}.{field}", difference(one.table(field), other.table(field)), None, REACH)


def run_on(test, scene, path, counts, **options):
    options = {"mpm_output_every": 1000, "mpm_quiet": None, **options}
    alone = test.run(path, **options)
    moved = difference(alone.table("position0", "first"), alone.table("position"))
    test.check(f"{scene}.points_move", moved, 0.05, None)
    for count in counts:
        other = test.run(path, ranks=count, **options)
        compare(test, f"{scene}_on_{count}", alone, other, count)
        test.check(f"{scene}_on_{count}.cuts", other.results.summary["step_cuts"], None, 0)


with Test() as test:
    for scene, path in SCENES.items():
        run_on(test, scene, path, (2, 3))
    run_on(test, "open", example("slump3d"), (4,), **OPEN)
