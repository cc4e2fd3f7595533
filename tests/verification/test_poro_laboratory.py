#!/usr/bin/env python3
"""A cube of saturated ground, drained or not, is a specimen of the laboratory: effective stress, history and porosity of every point are
those of one point without a grid, for laws that yield, in triaxial and oedometer tests, with and without F-bar.
"""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import Test  # noqa: E402

CLOSE = 1e-8  # of the largest stress
STEPS = 10
SYM = ("xx", "yy", "zz", "xy", "yz", "xz")
WATER = {"porosity": 0.4}
LAWS = {
    "mohr_coulomb": ({"E": 30e6, "nu": 0.25, "cohesion": 20e3, "friction": 30, "dilation": 10}, WATER, 0.0),
    "modified_cam_clay": ({"kappa": 0.02, "lambda": 0.1, "M": 1.2, "G": 4e6, "ocr": 1.5, "specific_volume": 2.1,
                           "reference_pressure": 100e3}, {}, -100e3),
    "nor_sand": ({"kappa": 0.0015, "G": 45e6, "M": 1.27, "N": 0.4, "lambda": 0.02, "v_c0": 1.8911, "h": 120,
                  "specific_volume": 1.5676, "image_pressure": 534472, "reference_pressure": 425e3}, {}, -425e3),
}
PATHS = {"triaxial_drained": -0.05, "triaxial_undrained": -0.05, "oedometer": -0.02}


def cube(path, law, end):
    """The scene of the cube, under the stress at which the law is at rest, all round in the triaxial tests."""
    numbers, water, rest = LAWS[law]
    held = path != "triaxial_undrained"
    # room beside the cube, whose free sides lie inside cells
    upper, cells = ("1,1,1", "2,2,2") if path == "oedometer" else ("1.2,1,1.2", "3,2,3")
    lines = {
        "dim": 3, "physics": "poro", "grid_lower": "0,0,0", "grid_upper": upper, "grid_cells": cells,
        "grid_follow": "cube", "grid_axes": "y", "grid_at": 0.5,
        "materials": "soil", "material_soil_type": law, "material_soil_permeability": 1e-14,
        "bodies": "cube", "body_cube_region": "box", "body_cube_lower": "0,0,0", "body_cube_upper": "1,1,1",
        "body_cube_material": "soil", "body_cube_points_per_cell": "2,2,2",
        "bcs": "x,y,z,top" + (",dry" if held else "") + (",x1,z1" if path == "oedometer" else ""),
        "time_end": 1, "time_step": 1.0 / STEPS, "output_prefix": "cube", "output_every": STEPS, "quiet": "true"}
    boxes = {"x": ("0,0,0", "0,1,2", "x"), "y": ("0,0,0", "2,0,2", "y"), "z": ("0,0,0", "2,1,0", "z"),
             "top": ("0,1,0", "2,1,2", "y"), "dry": ("0,0,0", "2,1,2", "p"), "x1": ("1,0,0", "1,1,2", "x"),
             "z1": ("0,0,1", "2,1,1", "z")}
    for name in lines["bcs"].split(","):
        for option, value in zip(("lower", "upper", "components"), boxes[name]):
            lines[f"bc_{name}_{option}"] = value
        lines[f"bc_{name}_region"] = "box"
    lines.update({"bc_top_value": end, "bc_top_ramp": "0:0,1:1"})
    if path != "oedometer" and rest < 0.0:
        lines["surfaces"] = "east,front"
        for name, side in (("east", "+x"), ("front", "+z")):
            lines.update({f"surface_{name}_{option}": value
                          for option, value in (("body", "cube"), ("side", side), ("normal", rest), ("ramp", "0:1"))})
    lines.update({f"material_soil_{name}": value for name, value in {**numbers, **water}.items()})
    return lines


def laboratory(path, law, end):
    numbers, _, rest = LAWS[law]
    lines = {"dim": 3, "physics": "stress_point", "materials": "soil", "material_soil_type": law, "point_material": "soil",
             "point_stress": ",".join(f"{rest:g}" for _ in range(3)) + ",0,0,0", "point_path": path, "point_end": end,
             "point_steps": STEPS, "point_measure": "cauchy", "point_strain": "engineering", "output_prefix": "lab",
             "quiet": "true"}
    lines.update({f"material_soil_{name}": value for name, value in numbers.items()})
    return lines


def run_lines(test, lines, ranks=1, **options):
    scene = test.folder() / "scene.yaml"
    scene.write_text("".join(f'mpm_{name}: "{value}"\n' for name, value in lines.items()), encoding="utf-8")
    return test.run(scene, ranks=ranks, **options)


def compare(test, path, law, ranks=1, **options):
    end, label = PATHS[path], f"{law}.{path}" + "".join(f".{name}" for name in options) + (f".{ranks}" if ranks > 1 else "")
    one = run_lines(test, laboratory(path, law, end), snes_rtol=1e-13).results
    run = run_lines(test, cube(path, law, end), ranks, snes_rtol=1e-11, **options)
    points = run.results.state("last")
    expected = np.array([one.column(f"stress_{name}")[-1] for name in SYM])
    size = np.abs(expected).max()
    test.check(label + ".stress", np.abs(points["stress"] - expected).max() / size, None, CLOSE)
    test.check(label + ".sheared", size, 1.1 * abs(LAWS[law][2]) + 1e3, None)
    for name in ("preconsolidation", "image_pressure", "specific_volume"):
        if name in points:
            state = one.column(name)[-1]
            test.check(f"{label}.{name}", np.abs(points[name] / state - 1.0).max(), None, CLOSE)
    # F of the end, and the porosity that goes with it
    volume = one.column("eps_v")[-1] + 1.0
    porosity = LAWS[law][1].get("porosity", 1.0 - 1.0 / LAWS[law][0].get("specific_volume", 1.0))
    test.check(label + ".porosity", np.abs(points["porosity"] - (1.0 - (1.0 - porosity) / volume)).max(), None, CLOSE)
    if path == "triaxial_undrained":  # what the lateral stress, which is held, leaves
        pressure = expected[0] - LAWS[law][2]
        test.check(label + ".pressure", np.abs(points["pressure"] - pressure).max() / size, None, CLOSE)
    test.check(label + ".step_cuts", run.results.summary["step_cuts"], None, 0)


with Test() as test:
    for law in LAWS:
        for path in PATHS:
            compare(test, path, law)
    compare(test, "triaxial_undrained", "modified_cam_clay", mpm_stabilization_fbar="false")
    compare(test, "triaxial_drained", "nor_sand", ranks=2)
