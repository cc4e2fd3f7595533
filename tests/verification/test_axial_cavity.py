#!/usr/bin/env python3
"""Axial symmetry: a spherical and a cylindrical cavity expanded in sand, against an integration in r. Quick."""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import EXAMPLES, Test, call, read_table  # noqa: E402

FOLDER = EXAMPLES / "cavity_axisymmetric"
RADII = (1.05, 1.1, 1.2)


def errors(test, label, scene, table, **options):
    """Relative errors of the wall's pressure."""
    run = test.run(FOLDER / scene, mpm_quiet=None, mpm_output_every=1000, **options)
    values, exact = test.check_example(label, run, FOLDER.name), read_table(EXAMPLES / table / "reference.csv")
    return np.array([values[f"wall_at_{radius:g}"] / np.interp(radius, exact["radius"], exact["wall"]) - 1 for radius in RADII])


with Test() as test:
    made = call([sys.executable, FOLDER / "points.py"], test.folder()).stdout.split()
    ours = (FOLDER / "points.csv").read_text(encoding="utf-8").split()
    test.check("points", np.abs(np.genfromtxt(made[1:], delimiter=",") - np.genfromtxt(ours[1:], delimiter=",")).max(), None, 1e-9)
    test.check("sphere.wall", np.abs(errors(test, "sphere", "case.yaml", FOLDER.name)).max(), None, 0.02)
    fine = errors(test, "slice", "slice.yaml", "cavity_expansion")
    finer = errors(test, "slice_8", "slice.yaml", "cavity_expansion", mpm_grid_refine=2)
    test.check("slice.wall", np.abs(fine).max(), None, 2e-3)
    test.check("slice.falls", np.abs(finer).max() / np.abs(fine).max(), None, 0.25)
