#!/usr/bin/env python3
"""A cavity expanded in sand by a boundary that grows: the pressure of an integration in r."""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import EXAMPLES, Test, call, example, read_table  # noqa: E402

FOLDER = EXAMPLES / "cavity_expansion"
sys.path.insert(0, str(FOLDER))
import reference as formula  # noqa: E402


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
    test.check(f"{label}.depth", run.results.column("depth_cavity")[-1] * cells, None, 0.002)
    pressure = {name: np.array([values[f"{name}_at_{radius:g}"] / np.interp(radius, table["radius"], table[name]) - 1.0
                                for radius in (1.05, 1.1, 1.2)]) for name in ("wall", "rim")}
    return pressure["wall"], pressure["rim"], np.array([values[f"stress_{name}"] for name in ("radial", "round", "along")])


def reference(test):
    """The pressures that README.md states stand in the table."""
    table = read_table(FOLDER / "reference.csv")
    for radius, value in ((1.05, 3.415), (1.1, 4.598), (1.2, 6.523)):
        test.near(f"reference.wall_at_{radius:g}", np.interp(radius, table["radius"], table["wall"]), value, absolute=5e-4)


def ellipticity(test):
    """What README.md says of the acoustic tensor: below 0 with psi = 10 degrees, 0 with psi = phi."""
    least, normals = formula.ellipticity(np.radians(10.0))
    test.near("ellipticity.least", least, -0.0156, absolute=1e-4)
    test.near("ellipticity.from", normals[0], 50.0, absolute=0.1)
    test.near("ellipticity.to", normals[1], 60.0, absolute=0.1)
    test.near("ellipticity.associated", formula.ellipticity(formula.FRICTION)[0], 0.0, absolute=1e-9)


with Test() as test:
    reference(test)
    ellipticity(test)
    (coarse, coarse_rim, coarse_stress), (fine, fine_rim, fine_stress) = (expand(test, cells) for cells in (2, 4))
    test.check("cells_4.error", np.max(np.abs(fine)), None, 0.005)
    test.check("falls.wall", np.max(np.abs(fine)) / np.max(np.abs(coarse)), None, 0.25)
    test.check("falls.wall_mean", np.mean(np.abs(fine)) / np.mean(np.abs(coarse)), None, 0.25)
    test.check("falls.rim", np.max(np.abs(fine_rim)) / np.max(np.abs(coarse_rim)), None, 0.8)
    test.check("falls.stress", np.max(fine_stress / coarse_stress), None, 0.95)
