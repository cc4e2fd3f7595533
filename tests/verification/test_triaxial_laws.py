#!/usr/bin/env python3
"""Drained triaxial and biaxial tests on every law, default measures: no step is cut, lateral strains of a triaxial test are equal, and
Mohr-Coulomb fails at its exact stress, (sigma_3 N + 2 c sqrt(N)) with N = tan^2(45 + phi/2), on the Kirchhoff stress. Quick."""
import sys
from math import radians, sqrt, tan
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import ROOT, Test  # noqa: E402

SCENE = Path(__file__).parent / "triaxial.yaml"
ELASTIC = {"E": 30e6, "nu": 0.3}
LAWS = {"hencky": ELASTIC, "linear_elastic": ELASTIC, "neo_hookean": ELASTIC, "jaumann_elastic": ELASTIC,
        "ogden": {"terms": "2:4e6", "bulk_modulus": 1e7}, "j2": ELASTIC | {"yield_stress": 60e3},
        "modified_cam_clay": {"kappa": 0.02, "lambda": 0.1, "M": 1.2, "G": 4e6, "ocr": 1.5, "specific_volume": 2.1,
                              "reference_pressure": 1e5, "pressure_min": 1e3},
        "nor_sand": {"kappa": 0.0015, "G": 45e6, "M": 1.27, "N": 0.4, "beta": 1, "lambda": 0.02, "v_c0": 1.8911, "h": 120,
                     "specific_volume": 1.5676, "image_pressure": 1e5, "reference_pressure": 1e5},
        "nacc": {"E": 3e6, "nu": 0.3, "M": 2.36, "beta": 0.5, "xi": 30, "alpha_0": -0.1}}
FRICTIONAL, FLUIDS = {"mohr_coulomb", "drucker_prager"}, {"newtonian"}  # a fluid bears no difference of stresses
STRENGTHS = ((33, 10, 5e3), (33, 0, 5e3), (33, 33, 5e3), (33, 10, 0), (30, 0, 0), (0, 0, 50e3))  # friction, dilation, cohesion


def compress(test, name, law, parameters, path, end):
    options = {f"mpm_material_s_{key}": value for key, value in parameters.items()}
    run = test.run(SCENE, mpm_quiet=None, mpm_material_s_type=law, mpm_point_path=path, mpm_point_end=end, **options)
    test.check(f"{name}.{path}.{end}.cuts", run.results.column("cuts").sum(), 0, 0)
    last = {key: values[-1] for key, values in run.results.history.items()}
    if path == "triaxial_drained":
        test.check(f"{name}.{end}.lateral", abs(last["strain_xx"] - last["strain_zz"]), upper=1e-9)
    return last


def extend(test):
    """Softening sand is pulled at constant lateral stress: its tension strength, then both planes of shear, with the strengths of its
    equivalent plastic strain k. Where one follows the other all three meet, and the point has no stiffness."""
    soft = {"cohesion": 5e3, "cohesion_residual": 1e3, "friction": 35, "friction_residual": 30, "dilation": 8, "dilation_residual": 0,
            "softening_strain": 0.05, "tension": 2e3}
    options = {f"mpm_material_s_{key}": value for key, value in (ELASTIC | soft).items()}
    run = test.run(SCENE, mpm_quiet=None, mpm_material_s_type="mohr_coulomb", mpm_point_path="triaxial_drained", mpm_point_end=0.02,
                   mpm_point_measure="kirchhoff", mpm_point_stress="-10e3,-30e3,-10e3,0,0,0", **options)
    part = run.results.column("equivalent_plastic_strain") / 0.05
    c, phi = 5e3 - 4e3 * part, np.radians(35 - 5 * part)
    shear = (2 * c * np.cos(phi) - 1e4 * (1 - np.sin(phi))) / (1 + np.sin(phi))
    error = np.abs(run.results.column("stress_yy") - np.minimum(0.4 * c, shear))[part > 0]
    test.check("extension.strength", error.max(), None, 1e-3)
    test.check("extension.sheared", np.count_nonzero(shear < 0.4 * c), 3, None)


with Test() as test:
    extend(test)
    laws = {path.stem for path in (ROOT / "materials").glob("*.c")}
    test.check("laws", len(laws ^ set(LAWS) ^ FRICTIONAL ^ FLUIDS), 0, 0)
    for path in ("triaxial_drained", "biaxial_drained"):
        for law, parameters in LAWS.items():
            compress(test, law, law, parameters, path, -0.1)
        for friction, dilation, cohesion in STRENGTHS:
            for law in sorted(FRICTIONAL):
                values = ELASTIC | {"friction": friction, "dilation": dilation, "cohesion": cohesion}
                name = f"{law}.{friction}.{dilation}.{cohesion:g}"
                last = compress(test, name, law, values, path, -0.1)
                if path == "triaxial_drained" and law == "mohr_coulomb":
                    N, J = tan(radians(45 + friction / 2)) ** 2, np.exp(last["eps_v"])
                    test.near(f"{name}.axial", -last["stress_yy"], 1e5 * N + 2 * cohesion * sqrt(N) / J, relative=3e-4)
                compress(test, name, law, values, path, 0.1)
