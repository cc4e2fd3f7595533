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


with Test() as test:
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
