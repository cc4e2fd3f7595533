#!/usr/bin/env python3
"""A cavity expanded in sand by a boundary that grows: the pressure of an integration in r."""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import EXAMPLES, Test, call, example, read_table  # noqa: E402

FOLDER = EXAMPLES / "cavity_expansion"


def expand(test, cells, **options):
    """The example with so many cells to a radius; relative errors of the pressure at the wall."""
    place = test.folder()
    made = call([sys.executable, FOLDER / "points.py", "--cells", cells], place).stdout
    (place / "points.csv").write_text(made, encoding="utf-8")
    if cells == 2:
        ours, new = (np.genfromtxt(path, delimiter=",", skip_header=1) for path in (FOLDER / "points.csv", place / "points.csv"))
        test.check("example.points", np.abs(ours - new).max(), None, 1e-9)
    run = test.run(example("cavity_expansion"), mpm_body_ring_file=place / "points.csv", mpm_quiet=None, mpm_output_every=1000,
                   mpm_grid_refine=cells // 2, **options)
    label = f"cells_{cells}"
    values, table = test.check_example(label, run, "cavity_expansion"), read_table(FOLDER / "reference.csv")
    test.check(f"{label}.depth", run.results.column("depth_cavity")[-1] * cells, None, 0.01)
    return np.array([values[f"wall_at_{radius:g}"] / np.interp(radius, table["radius"], table["wall"]) - 1.0
                     for radius in (1.05, 1.1, 1.2)])


def reference(test):
    """The pressures that README.md states stand in the table."""
    table = read_table(FOLDER / "reference.csv")
    for radius, value in ((1.05, 3.415), (1.1, 4.598), (1.2, 6.523)):
        test.near(f"reference.wall_at_{radius:g}", np.interp(radius, table["radius"], table["wall"]), value, absolute=5e-4)


with Test() as test:
    reference(test)
    for cells in (2, 4):
        test.check(f"cells_{cells}.error", np.max(np.abs(expand(test, cells))), None, 0.03)
