#!/usr/bin/env python3
"""A cavity expanded in sand by a boundary that grows: the pressure of an integration in r."""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import EXAMPLES, Test, call, example, read_table  # noqa: E402

FOLDER = EXAMPLES / "cavity_expansion"


def expand(test, cells, **options):
    """The example with so many cells to a radius; relative errors of the pressures at the wall, at the rim, and of stresses."""
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
    pressure = {name: np.array([values[f"{name}_at_{radius:g}"] / np.interp(radius, table["radius"], table[name]) - 1.0
                                for radius in (1.05, 1.1, 1.2)]) for name in ("wall", "rim")}
    return pressure["wall"], pressure["rim"], np.array([values[f"stress_{name}"] for name in ("radial", "round", "along")])


def reference(test):
    """The pressures that README.md states stand in the table."""
    table = read_table(FOLDER / "reference.csv")
    for radius, value in ((1.05, 3.415), (1.1, 4.598), (1.2, 6.523)):
        test.near(f"reference.wall_at_{radius:g}", np.interp(radius, table["radius"], table["wall"]), value, absolute=5e-4)


with Test() as test:
    reference(test)
    (coarse, coarse_rim, coarse_stress), (fine, fine_rim, fine_stress) = (expand(test, cells) for cells in (2, 4))
    for cells, error in ((2, coarse), (4, fine)):
        test.check(f"cells_{cells}.error", np.max(np.abs(error)), None, 0.01)
    test.check("falls.rim", np.max(np.abs(fine_rim) / np.abs(coarse_rim)), None, 0.8)
    test.check("falls.stress", np.max(fine_stress / coarse_stress), None, 0.95)
