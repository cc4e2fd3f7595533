#!/usr/bin/env python3
"""The equivalent plastic strain of all laws that flow, against total less elastic shear strain on triaxial paths; the total strain of
the points against the logarithm of the stretches, and of small strain against the displacement's gradient.

Quick.
"""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import Test, difference  # noqa: E402

FOLDER = Path(__file__).resolve().parent
SAND = {"E": 30e6, "nu": 0.25, "cohesion": 5e3, "friction": 30, "dilation": 0, "density": 1900}
LAWS = {
    "j2": ({"E": 30e6, "nu": 0.25, "yield_stress": 100e3, "density": 1900}, 12e6),
    "mohr_coulomb": (SAND, 12e6),
    "drucker_prager": ({**SAND, "fit": "compression"}, 12e6),
    "modified_cam_clay": ({"kappa": 0.02, "lambda": 0.1, "M": 1.2, "G": 4e6, "ocr": 1.5, "specific_volume": 2.1, "density": 1800}, 4e6),
    "nor_sand": ({"kappa": 0.0015, "G": 45e6, "M": 1.27, "N": 0.4, "beta": 1, "lambda": 0.02, "v_c0": 1.8911, "h": 120,
                  "specific_volume": 1.6, "image_pressure": 60e3, "reference_pressure": 100e3, "density": 2000}, 45e6),
}


def laboratory(test, name, parameters, shear_modulus):
    options = {f"mpm_material_soil_{key}": value for key, value in parameters.items()}
    run = test.run(FOLDER / "strains.yaml", mpm_quiet=None, mpm_material_soil_type=name, **options)
    alpha, q, eps_q = (run.results.column(key) for key in ("equivalent_plastic_strain", "q", "eps_q"))
    exact = eps_q - q / (3.0 * shear_modulus)
    test.check(f"{name}.flows", alpha[-1], 1e-3)
    test.check(f"{name}.plastic_strain", difference(alpha, exact), None, 1e-9)


def points(test, name, sheared):
    """A square of one cell that is stretched and sheared by its nodes."""
    run = test.run(FOLDER / "stretch_cell.yaml", mpm_quiet=None, mpm_material_soil_type=name)
    F = run.table("F").reshape(-1, 3, 3)
    if sheared:
        strain = np.array([0.5 * (f + f.T) - np.eye(3) for f in F])
    else:
        values, axes = np.linalg.eigh(F @ F.transpose(0, 2, 1))
        strain = axes @ (0.5 * np.log(values)[:, :, None] * axes.transpose(0, 2, 1))
    six = np.stack([strain[:, i, j] for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2))], axis=1)
    test.check(f"{name}.strain", difference(six, run.table("strain")), None, 1e-12)
    test.check(f"{name}.deforms", np.abs(six).max(), 0.05)


with Test() as test:
    for law, (values, modulus) in LAWS.items():
        laboratory(test, law, values, modulus)
    points(test, "hencky", False)
    points(test, "linear_elastic", True)
