#!/usr/bin/env python3
"""The equivalent plastic strain of all laws that flow, against total less elastic shear strain on triaxial paths; the total strain of
the points against the logarithm of the stretches, and of small strain against the displacement's gradient; derived fields against
numpy's, from F, stress and pressure.

Quick.
"""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import Test, difference, example  # noqa: E402

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


PAIRS = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2))


def six(tensor):
    """Components of symmetric tensors as the results have them."""
    return np.stack([tensor[:, i, j] for i, j in PAIRS], axis=1)


def expected(F, stress):
    """Derived fields of deformation gradients and stresses, (n, 3, 3)."""
    stretch, axes = np.linalg.eigh(F @ F.transpose(0, 2, 1))
    logarithm = axes @ (0.5 * np.log(stretch)[:, :, None] * axes.transpose(0, 2, 1))
    principal = np.linalg.eigvalsh(stress)[:, ::-1]
    p = principal.mean(axis=1)
    deviator = logarithm - logarithm.trace(axis1=1, axis2=2)[:, None, None] * np.eye(3) / 3
    sine = (principal[:, 0] - principal[:, 2]) / -(principal[:, 0] + principal[:, 2])
    return {"green_lagrange_strain": six(0.5 * (F.transpose(0, 2, 1) @ F - np.eye(3))), "logarithmic_strain": six(logarithm),
            "volumetric_strain": np.log(np.linalg.det(F)), "deviatoric_strain": np.sqrt(2 / 3) * np.linalg.norm(deviator, axis=(1, 2)),
            "principal_stress": principal, "p": p,
            "q": np.sqrt(1.5) * np.linalg.norm(stress - p[:, None, None] * np.eye(3), axis=(1, 2)),
            "mobilised_friction": np.degrees(np.arcsin(np.where((0 <= sine) & (sine < 1), sine, 1)))}


def derived(test, label, run, pressure=None):
    """All derived fields of the last state; `pressure`: that of water at rest, at the points."""
    state = run.results.state("last").fields
    stress = state["stress"][:, [0, 3, 5, 3, 1, 4, 5, 4, 2]].reshape(-1, 3, 3)
    fields = expected(state["F"].reshape(-1, 3, 3), stress)
    if pressure:
        fields["excess_pressure"] = state["pressure"] - pressure(state["position"])
    for name, values in fields.items():
        test.check(f"{label}.{name}", difference(values, state[name]), None, 1e-9)
    test.check(f"{label}.moves", np.abs(fields["deviatoric_strain"]).max() * np.abs(fields["q"]).max(), 1e-9)
    test.check(f"{label}.excess", "excess_pressure" in state, int(pressure is not None), int(pressure is not None))


def check_derived(test):
    """In the plane, in space, with axial symmetry and in saturated ground; in the list of fields, too, and not unasked."""
    wanted = {"mpm_output_derived": "all", "mpm_quiet": None}
    derived(test, "plane", test.run(example("collapse"), mpm_time_end=0.3, **wanted))
    derived(test, "space", test.run(example("slump3d"), ranks=2, mpm_time_end=0.1, **wanted))
    ring = {"mpm_kinematics": "axisymmetric", "mpm_bc_base_components": "y", "mpm_bc_top_components": "y", "mpm_bc_top_value": "0.2"}
    derived(test, "axial", test.run(FOLDER / "stretch_cell.yaml", **ring, **wanted))
    derived(test, "water", test.run(FOLDER / "wet_stages.yaml", mpm_stage_work_time_end=20, mpm_output_every=1, **wanted),
            lambda x: 1e4 * np.maximum(3.5 - x[:, 1], 0))
    some = test.run(example("bar_elastic"), mpm_output_fields="stress,q", mpm_output_derived="p", mpm_quiet=None)
    fields = set(some.results.state("last").fields)
    test.check("chosen", fields == {"id", "position", "stress", "p", "q"}, 1, 1)
    refused = test.run(example("bar_elastic"), status=2, mpm_output_derived="p,von_mises")
    test.check("refused", "-mpm_output_derived von_mises: there is no such field" in refused.errors, 1, 1)


with Test() as test:
    for law, (values, modulus) in LAWS.items():
        laboratory(test, law, values, modulus)
    points(test, "hencky", False)
    points(test, "linear_elastic", True)
    check_derived(test)
