#!/usr/bin/env python3
"""Level Cam-Clay with its preconsolidation by height rests, its stress that of weight and OCR; a wide load settles it as the oedometer
says, a strip load less.
"""
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import EXAMPLES, Test, call, example  # noqa: E402

LONG = {"mpm_stage_load_time_step": 0.1, "mpm_quiet": None}
WIDE = EXAMPLES / "clay_rest" / "wide.yaml"


def settle(test, label, ranks=1, **options):
    run = test.run(example("clay_rest"), ranks=ranks, **LONG, **options)
    values = test.check_example(label, run, "clay_rest")
    test.check(f"{label}.step_cuts", run.results.summary["step_cuts"], None, 0)
    test.check(f"{label}.newton_max", run.newton.max(), None, 8)
    return values["settlement"]


with Test() as test:
    strip = settle(test, "strip", 2, mpm_grid_cells="20,11", mpm_body_ground_points_per_cell="2,2")
    wide = settle(test, "wide", options_file=WIDE)
    test.check("strip_over_wide", strip / wide, 0.2, 0.4)
    # clay that cannot bear the stress of its OCR yields, and rests with another
    run = test.run(example("clay_rest"), options_file=WIDE, mpm_body_ground_initial_preconsolidation="0:120e3,10:120e3", **LONG)
    process = call([sys.executable, EXAMPLES / "clay_rest" / "check.py", run.prefix], run.folder)
    test.check("difference_seen", int(process.returncode == 1 and "ratio_error" in process.stderr), 1, 1)
    lines = dict(line.split()[:2] for line in process.stdout.splitlines())
    test.check("yielding.moved_over_height", float(lines["moved_over_height"]), None, 1e-9)
