#!/usr/bin/env python3
"""Steps in time of saturated ground: orders of the schemes from a sudden load on, and the error that chooses the steps, on any
number of ranks, with a moving grid, and over a restart.

Quick.
"""
import importlib.util
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import EXAMPLES, Test, difference, example  # noqa: E402

TERZAGHI, FINITE = example("terzaghi"), example("consolidation_finite")
END = 1.12e7  # s, T = 0.2


def checker(name):
    """An example's check.py as a module."""
    spec = importlib.util.spec_from_file_location(name, EXAMPLES / name / "check.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


terzaghi, finite = checker("terzaghi"), checker("consolidation_finite")


def orders(test):
    """Errors fall with the power of the step that they should, whether steps are equal or alternate."""
    for scheme, order, bound in (("euler", 1.0, 5e-3), ("second", 2.0, 1.5e-4)):
        errors = []
        for step in (1.6e6, 8e5, 4e5):
            run = test.run(TERZAGHI, mpm_time_end=END, mpm_time_step=step, mpm_time_scheme=scheme, mpm_output_every=1000)
            errors.append(terzaghi.pressure_error(run.results, terzaghi.Theory(run.results), run.results.steps[-1]))
        test.check(f"{scheme}.order", np.log2(errors[0] / errors[1]), order - 0.2)
        test.check(f"{scheme}.error", errors[-1], None, bound)
    fine = test.run(TERZAGHI, mpm_time_end=END, mpm_time_step=1e5, mpm_output_every=1000)
    growing = [test.run(TERZAGHI, mpm_time_end=END, mpm_time_step=step, mpm_time_growth=growth, mpm_time_step_max=1e7,
                        mpm_output_every=1000) for step, growth in ((2e5, 1.5), (1e5, np.sqrt(1.5)))]
    exact = fine.table("pressure")
    errors = [np.max(np.abs(run.table("pressure") - exact)) for run in growing]
    test.check("growing.order", np.log2(errors[0] / errors[1]), 1.5)


def chosen(test):
    """The error chooses steps within growth and step_max; a smaller one costs more and is kept."""
    steps, wrong = [], []
    for bound in (1e-2, 1e-3, 1e-4):
        run = test.run(FINITE, mpm_time_error=bound, mpm_output_every=0, mpm_time_growth=3)
        theory = finite.Theory(run.results)
        time, settled = run.results.column("time"), run.results.column("outflow_top") / theory.width
        late = theory.rate * time > 1e-3
        wrong.append(np.max(np.abs(settled - theory.settlement(theory.decay(time)))[late]) / theory.last)
        steps.append(len(time))
        length = run.results.column("dt")
        test.check(f"error_{bound:g}.growth", np.max(length[1:] / length[:-1]), None, 3.0 + 1e-9)
        test.check(f"error_{bound:g}.longest", np.max(length), None, 1000.001)
        test.check(f"error_{bound:g}.kept", wrong[-1], None, bound + 2e-4)  # the grid's own
    test.check("steps.more", min(np.diff(steps)), 5)
    # too long a first step is refused until the error is what it should be
    run = test.run(FINITE, mpm_time_step=500, mpm_output_every=0)
    test.check("refused.cuts", np.sum(run.results.column("cuts")), 3)
    test.check("refused.first", run.results.column("dt")[0], None, 20.0)


def example_runs(test):
    """The example on one rank, on three, and from the middle on on two; steps that grow to a longest one."""
    alone = test.run(FINITE, snes_rtol=1e-12, mpm_checkpoint_every=20)
    test.check_example("finite", alone, "consolidation_finite")
    several = test.run(FINITE, ranks=3, snes_rtol=1e-12)
    test.check("on_3.same", difference(alone.table("pressure"), several.table("pressure")), None, 1e-8)
    again = test.run(FINITE, ranks=2, snes_rtol=1e-12,
                     mpm_restart=min(alone.folder.glob("consolidation_checkpoint_*20.h5")))
    test.check("again.same", difference(alone.table("pressure"), again.table("pressure")), None, 1e-10)
    test.check("again.outflow", alone.results.column("outflow_top")[-1] / again.results.column("outflow_top")[-1] - 1, -1e-10, 1e-10)
    plain = {"mpm_time_scheme": "euler", "mpm_time_growth": 1.2, "mpm_time_step_max": 85.0562, "mpm_output_every": 5}
    scene = test.folder() / "plain.yaml"
    scene.write_text(FINITE.read_text(encoding="utf-8").replace("error: 1e-3, ", ""), encoding="utf-8")
    run = test.run(scene, **plain)
    test.check_example("euler", run, "consolidation_finite")
    length = run.results.column("dt")
    test.near("growth.first", length[1] / length[0], 1.2, 1e-9)
    test.near("growth.steps", len(length), 120, 0)
    test.near("growth.longest", np.max(length[:-1]), 85.0562, 1e-6)
    text = scene.read_text(encoding="utf-8").replace(", follow: cap, axes: y, at: 9.975", "")
    scene.write_text(text.replace('upper: "0.1,10", cells: "1,100"', 'upper: "0.1,10.2", cells: "1,102"'), encoding="utf-8")
    for scheme in ("euler", "second"):
        fixed = test.run(scene, **{**plain, "mpm_time_scheme": scheme})
        test.check_example(f"fixed_{scheme}", fixed, "consolidation_finite")
    settled = run.results.column("outflow_top") / 0.1
    for step, value in zip((21, 31, 38, 46, 61, 120), (0.220045, 0.552855, 1.044897, 1.538637, 1.917991, 2.077970)):
        test.check(f"euler.{step}", abs(settled[step - 1] - value) / 2.07936, None, 1e-3)
    run = test.run(TERZAGHI)
    test.check_example("terzaghi", run, "terzaghi")
    test.check("terzaghi.base", difference(run.results.column("reaction_base_y"), np.full(140, 100.0)), None, 1e-9)


def main():
    with Test() as test:
        orders(test)
        chosen(test)
        example_runs(test)


if __name__ == "__main__":
    main()
