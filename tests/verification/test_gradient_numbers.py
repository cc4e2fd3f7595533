#!/usr/bin/env python3
"""Every number of a scene has a derivative, or a refusal that names it, in one line.

Numbers are those of the options in force of a block of few points. Closed forms are compared with twins.

Quick.
"""
import re
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import FULL, Test  # noqa: E402

SCENE = Path(__file__).resolve().parent / "one_block.yaml"
NAMED = ("material", "body", "bc", "load", "motion", "contact", "boundary", "track", "surface", "stage")
NUMBER = re.compile(r"[-+]?[0-9.]+(e[-+]?[0-9]+)?")
QUIET = {"mpm_output_every": 0, "mpm_quiet": None}
ASK = {"mpm_task": "gradient", "mpm_objectives": "u", "mpm_objective_u_column": "track_top_uy", "mpm_objective_u_kind": "value"}
WET = {"mpm_physics": "poro", "mpm_water_density": 1000, "mpm_water_viscosity": 1e-3, "mpm_water_modulus": 1e8, "mpm_boundaries": "",
       "mpm_material_soil_porosity": 0.4, "mpm_material_soil_permeability": 1e-10, "mpm_bcs": "wall,base",
       "mpm_bc_base_region": "box", "mpm_bc_base_lower": "0,0.5", "mpm_bc_base_upper": "1,0.5", "mpm_bc_base_components": "y"}
MOVING = {"mpm_time_integrator": "newmark", "mpm_time_damping_mass": 0.1}


def parameter(option, values):
    """The name of an option's number: of its second value, where there are several."""
    words = option.split("_")
    block = 2 if words[0] in NAMED and len(words) > 2 else 1
    return "_".join(words[:block]) + "." + "_".join(words[block:]) + (":2" if len(values) > 1 else "")


def numbers(test, options):
    """Names of all numbers among the options in force of a scene."""
    run = test.run(SCENE, **QUIET, **options)
    for line in Path(f"{run.prefix}_options.yaml").read_text().splitlines():
        found = re.match(r'(?:# )?mpm_(\w+_\w+): "(.*)"', line)
        values = re.split("[,:]", found[2]) if found else []
        if values and all(NUMBER.fullmatch(value) for value in values):
            yield parameter(found[1], values)


def check_number(test, label, name, options):
    """A derivative, by twins too where it is in closed form; or a refusal."""
    command = {**QUIET, **ASK, "mpm_gradient_parameters": name, **options}
    run = test.run(SCENE, status=None, **command)
    if run.status:
        lines = [line for line in run.errors.strip().splitlines() if "warning:" not in line]
        test.check(f"{label}.{name}.refused", run.status in (2, 3) and len(lines) == 1 and name in lines[0], 1, 1)
        return 0
    summary = run.results.summary
    test.check(f"{label}.{name}", abs(summary["gradient"][0]), 0.0, np.finfo(float).max)
    if summary["gradient_method"] == ["adjoint"]:
        twins = test.run(SCENE, **command, mpm_gradient_method="twins").results.summary
        test.near(f"{label}.{name}.twins", summary["gradient"][0], twins["gradient"][0], relative=1e-5,
                  absolute=10 * abs(twins["gradient_error"][0]))
    return 1


with Test() as test:
    scenes = {"contact": {}}
    if FULL:
        scenes |= {"solid": {key: value for key, value in WET.items() if "bc" in key or "boundaries" in key}, "wet": WET, "moving": MOVING}
    for label, options in scenes.items():
        found = [check_number(test, label, name, options) for name in numbers(test, options)]
        print(f"{label}: {sum(found)} of {len(found)} numbers have a derivative")
        test.check(f"{label}.numbers", sum(found), 5, len(found))
