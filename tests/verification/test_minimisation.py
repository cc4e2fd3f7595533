#!/usr/bin/env python3
"""Steps as minimisations: far too long ones end where the material would go, and others take no more iterations than before."""
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))
from talus_test import Test, example  # noqa: E402

COLUMN = HERE / "slender_column.yaml"
LINE = "each step minimises a potential"


def column(test):
    """
    In steps of any length it buckles to the side to which it is pushed. By its residual alone Newton's method found the straight
    column in steps of 1/4 and 1, which is not stable, and the other side in steps of 1/2; all these are balanced. What is left of the step's length is that
    of the points' domains and weights.
    """
    fine = test.run(COLUMN, mpm_time_step=0.05)
    test.check("column.told", fine.output.count(LINE), 1, 1)
    top = fine.results.column("track_top_ux")[-1]
    test.near("column.fine", top, 7.1, relative=0.02)
    for name, more in (("quarter", {}), ("half", {"mpm_time_step": 0.5}), ("ranks", {"ranks": 2}), ("amg", {"mpm_solver": "amg"})):
        run = test.run(COLUMN, **more)
        test.near(f"column.{name}", run.results.column("track_top_ux")[-1], top, relative=0.04)
        if name == "quarter":
            test.check("column.iterations", run.results.summary["newton_iterations"], None, 320)  # of which 220 as it falls to the side


def cantilever(test):
    """The whole load in one step, 50 times as long as the example's, without a cut; it took 4 cuts and 93 iterations."""
    run = test.run(example("cantilever"), mpm_time_step=1, mpm_output_every=0)
    test.check("cantilever.cuts", run.results.summary["step_cuts"], 0, 0)
    test.check("cantilever.iterations", run.results.summary["newton_iterations"], None, 40)
    usual = test.run(example("cantilever"), mpm_output_every=0)
    test.check("cantilever.usual", usual.results.summary["newton_iterations"], None, 160)
    test.near("cantilever.tip", run.results.column("track_tip_uy")[-1], usual.results.column("track_tip_uy")[-1], relative=0.02)


def petsc(test):
    """PETSc's own backtracking is given the objective, too."""
    run = test.run(example("cantilever"), mpm_time_step=0.25, mpm_output_every=0, snes_linesearch_type="bt", snes_linesearch_monitor=None)
    test.check("petsc.objective", "obj" in run.output.lower(), 1, 1)
    test.near("petsc.tip", run.results.column("track_tip_uy")[-1], -8.25, relative=0.02)


def none(test):
    """Where there is plastic flow nothing is minimised."""
    test.check("none.told", test.run(example("bar_j2"), mpm_time_end=0.1, mpm_output_every=0).output.count(LINE), 0, 0)


with Test() as test:
    column(test)
    cantilever(test)
    petsc(test)
    none(test)
