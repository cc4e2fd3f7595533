#!/usr/bin/env python3
"""Out-of-plane stress of level ground in plane strain: k0 times the vertical one for every law, at rest and through a change of material.

Elastic laws carry it beside F, which has no component across the plane: in plane strain nothing works on it. Bound: 1e-8 of the stress.
"""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import ROOT, Test  # noqa: E402

SCENE = Path(__file__).parent / "k0_across.yaml"
K0, SAME = 0.8, 1e-8
SOIL = {"E": 1e7, "nu": 0.3, "cohesion": 5e3, "friction": 30, "dilation": 5}
LAWS = {"hencky": {"E": 1e7, "nu": 0.3}, "linear_elastic": {"E": 1e7, "nu": 0.3}, "neo_hookean": {"E": 1e7, "nu": 0.3},
        "ogden": {"terms": "2:4e6", "bulk_modulus": 1e7},
        "jaumann_elastic": {"E": 1e7, "nu": 0.3}, "j2": {"E": 1e7, "nu": 0.3, "yield_stress": 1e6}, "mohr_coulomb": SOIL, "drucker_prager": SOIL,
        "modified_cam_clay": {"kappa": 0.02, "lambda": 0.1, "M": 1.2, "G": 4e6, "ocr": 3, "specific_volume": 2.1, "pressure_min": 1e3},
        "nor_sand": {"kappa": 0.0015, "G": 45e6, "M": 1.27, "N": 0.4, "beta": 1, "lambda": 0.02, "v_c0": 1.8911, "h": 70,
                     "specific_volume": 1.6, "image_pressure": 4e5, "reference_pressure": 1e5},
        "nacc": {"E": 1e7, "nu": 0.3, "M": 2.36, "beta": 0.5, "xi": 30, "alpha_0": -0.05}}
STRAIN = {"linear_elastic": 2e-3}  # its geometry stands still: a law of finite strain after it is out of balance by the strain
FLUIDS = ("newtonian",)  # k0 = 1 is all that they bear


def block(name, law):
    return {f"mpm_material_{name}_{key}": value for key, value in ({"type": law, "density": 2000} | LAWS[law]).items()}


def ratios(test, name, run, steps):
    for step in steps:
        stress = run.results.state(step)["stress"]
        for c, component in ((0, "xx"), (2, "zz")):
            test.check(f"{name}.{step}.{component}", np.max(np.abs(stress[:, c] - K0 * stress[:, 1])) / np.max(np.abs(stress)),
                       upper=STRAIN.get(name.removeprefix("to_"), SAME) if step == 4 else SAME)


with Test() as test:
    laws = {path.stem for path in (ROOT / "materials").glob("*.c")}
    test.check("laws", len(laws ^ set(LAWS) ^ set(FLUIDS)), 0, 0)
    for law in LAWS:
        ratios(test, law, test.run(SCENE, mpm_quiet=None, **block("s", law)), (1, 2, 3, 4))
        other = block("s", law) | {"mpm_stage_soil_materials": "b:s", "mpm_body_b_material": "other"}
        ratios(test, f"to_{law}", test.run(SCENE, mpm_quiet=None, **other), (4,))
    ratios(test, "ranks", test.run(SCENE, ranks=3, mpm_quiet=None, **block("s", "hencky")), (1, 4))
    ground = test.run(SCENE, mpm_quiet=None, mpm_stage_soil_materials="b:s", **block("s", "hencky"))
    lines = [line for line in SCENE.read_text(encoding="utf-8").splitlines() if "stage_rest" not in line and "stage_soil" not in line]
    again = test.folder() / "again.yaml"
    text = "\n".join(lines).replace("rest,wait,soil", "wait").replace('region: box, lower: "0,0", upper: "2,4"', "region: file")
    again.write_text(text + "\n", encoding="utf-8")
    ratios(test, "file", test.run(again, mpm_quiet=None, mpm_body_b_file=f"{ground.prefix}.h5", **block("s", "hencky")), (1, 2))
