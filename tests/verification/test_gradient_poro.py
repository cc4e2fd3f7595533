#!/usr/bin/env python3
"""Derivatives of runs with water in closed form: both methods, ranks, identities, and twins, whole runs of changed scenes.

Quick.
"""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import Test, example  # noqa: E402

SCENE = Path(__file__).resolve().parent / "gradient_poro.yaml"
RATE = Path(__file__).resolve().parent / "gradient_rate.yaml"
RATIOS = {0.1: 0.50004, 0.3: 0.53154, 1: 0.75008, 3: 0.90000, 10: 0.96774}  # E/F dF/dE by time factor
EXACT = {"snes_rtol": 1e-13, "snes_stol": 0, "mpm_quiet": None, "mpm_output_every": 0}
NUMBERS = "clay.E,clay.nu,clay.permeability,water.viscosity,clay.porosity,water.modulus,strip.factor"
FINITE = {"mpm_material_clay_type": "neo_hookean", "mpm_material_clay_permeability_law": "kozeny_carman"}
WEIGHT = {"mpm_loads": "strip,weight", "mpm_load_weight_type": "gravity", "mpm_load_weight_value": "0,-9.81",
          "mpm_material_clay_density": 1800}
TOP = {"mpm_bcs": "base,axis", "mpm_surfaces": "top", "mpm_surface_top_body": "clay", "mpm_surface_top_side": "+y",
       "mpm_surface_top_drained": "true", "mpm_surface_top_traction": "1e3,-5e3", "mpm_load_strip_upper": "1,1"}
REST = {"mpm_stages": "rest,load", "mpm_stage_rest_type": "geostatic", "mpm_stage_rest_geostatic_method": "k0",
        "mpm_stage_rest_geostatic_k0": 0.5, "mpm_stage_rest_loads": "weight", "mpm_stage_load_time_end": 100,
        "mpm_stage_load_time_step": 50, "mpm_stage_load_reset_displacement": "true"}
HEAVY = "clay.E,clay.permeability,clay.porosity,water.viscosity,water.density,clay.density"
SIZES = np.array([1e6, 1e-12, 0.4, 1e-3, 1000.0, 1800.0])  # of HEAVY
SEVERAL = ("small.means", "finite.spread", "weight", "rest", "flow", "fill")  # on three ranks: what they exchange differs
LAWS = {
    "small": ({"mpm_stabilization_fbar": "false"}, NUMBERS),
    "small.means": ({"mpm_stabilization_fbar": "true"}, NUMBERS),
    "finite": ({**FINITE, "mpm_stabilization_fbar": "false", "mpm_shape": "gimp_bspline2"}, NUMBERS),
    "finite.means": ({**FINITE, "mpm_stabilization_fbar": "true"}, NUMBERS),
    "finite.spread": ({"mpm_material_clay_type": "neo_hookean", "mpm_material_clay_permeability_law": "uzuoka_borja",
                       "mpm_stabilization_fbar": "spread"}, NUMBERS),
    "second.small": ({"mpm_stabilization_fbar": "false", "mpm_time_scheme": "second"}, NUMBERS),
    "weight": ({**FINITE, **WEIGHT, **TOP, "mpm_stabilization_fbar": "true", "mpm_time_scheme": "second"}, HEAVY),
    "rest": ({**WEIGHT, **TOP, **REST}, HEAVY),
    "axial": ({**WEIGHT, "mpm_kinematics": "axisymmetric", "mpm_material_clay_type": "neo_hookean"}, HEAVY),
    "plastic": ({"mpm_material_clay_type": "mohr_coulomb", "mpm_material_clay_cohesion": 8e3, "mpm_material_clay_friction": 20,
                 "mpm_material_clay_dilation": 5, "mpm_stabilization_fbar": "true"},
                "clay.cohesion,clay.friction,clay.permeability,water.viscosity"),
}


def differentiate(test, parameters, method, ranks=1, column="track_edge_uy", scene=SCENE, **options):
    """Last value of a column, its gradient and the method of each derivative."""
    run = test.run(scene, ranks=ranks, mpm_task="gradient", mpm_gradient_parameters=parameters, mpm_gradient_method=method,
                   mpm_objectives="u", mpm_objective_u_column=column, mpm_objective_u_kind="value", **{**EXACT, **options})
    summary = run.results.summary
    return summary["objective"], np.array(summary["gradient"]), summary["gradient_method"]


def compare(test, label, parameters, twins=1e-6, sizes=None, **options):
    """The adjoint's gradient, which the tangent, three ranks (of SEVERAL), and twins have, too.

    Derivatives of a geostatic start are differences over 1e-3 of states known to 1e-13: a parameter whose effect, its
    size times its derivative, is small has them to that part of the largest effect only (`sizes`).
    """
    value, gradient, methods = differentiate(test, parameters, "adjoint", **options)
    test.check(f"{label}.closed", sum(method == "adjoint" for method in methods), len(gradient), len(gradient))
    for method, ranks, bound in (("tangent", 1, 1e-10), ("adjoint", 3, 1e-8), ("twins", 1, twins)):
        if ranks > 1 and label not in SEVERAL:
            continue
        _, other, _ = differentiate(test, parameters, method, ranks, **options)
        scale = abs(gradient) if sizes is None or ranks == 1 else abs(gradient * sizes).max() / sizes
        test.near(f"{label}.{method}.ranks={ranks}", (abs(other - gradient) / scale).max(), 0.0, absolute=bound)
    return value, gradient


with Test() as test:
    for label, (options, parameters) in LAWS.items():
        value, gradient = compare(test, label, parameters, sizes=SIZES if label == "rest" else None, **options)
        names = parameters.split(",")
        time = gradient[names.index("clay.permeability")] * 1e-12 + gradient[names.index("water.viscosity")] * 1e-3
        test.near(label + ".time", time, 0.0, absolute=1e-9 * abs(gradient[names.index("water.viscosity")]) * 1e-3)
        if "strip.factor" in names:
            forces = gradient[names.index("clay.E")] * 1e6 + gradient[names.index("strip.factor")] + \
                gradient[names.index("water.modulus")] * 1e8 - gradient[names.index("clay.permeability")] * 1e-12
            test.near(label + ".forces", forces, 0.0, absolute=1e-9 * abs(value))
    # the flow out of the nodes at which the pressure is held, a sum known to 3e-12: twins differ over 1e-6
    compare(test, "flow", "clay.E,clay.permeability,strip.factor", twins=1e-5, column="reaction_top_p",
            mpm_time_scheme="second", mpm_stabilization_fbar="spread")
    # loads that follow the surface of a solid that turns
    beam = {"mpm_grid_cells": "30,30", "mpm_body_beam_points_per_cell": "3,3", "mpm_time_step": 0.5, "mpm_surfaces": "upper",
            "mpm_surface_upper_body": "beam", "mpm_surface_upper_side": "+y", "mpm_surface_upper_traction": "500,-2e3"}
    compare(test, "surface", "beam.E,beam.nu", column="track_tip_ux", scene=example("cantilever"), **beam)
    # compression at a constant rate, with M in proportion to E, and T = c_v t/H^2 too:
    #   F/(M eps) = 1 + 1/(3 T) - (2/(pi^2 T)) sum exp(-n^2 pi^2 T)/n^2    Wissa et al. (1971), J. Soil Mech. Found. Div. 97
    for time, exact in RATIOS.items():
        end = time / 1.2e-3
        force, gradient, _ = differentiate(test, "clay.E,clay.permeability,water.viscosity", "adjoint", scene=RATE,
                                           column="reaction_base_y", mpm_time_end=end, mpm_time_step=end / 60,
                                           mpm_bc_base_ramp=f"0:0,{end}:1")
        test.near(f"rate.{time}", gradient[0] * 1e6 / force, exact, relative=2e-3)
        test.near(f"rate.{time}.water", gradient[1] * 1e-12, -gradient[2] * 1e-3, relative=1e-9)
    # a fill that joins in the first step after a geostatic stage
    scene = test.folder() / "fill.yaml"
    scene.write_text((SCENE.parent / "fill_on_clay.yaml").read_text(encoding="utf-8").replace(", level: 3", ""), encoding="utf-8")
    compare(test, "fill", "c.E,f.density,c.density", column="track_t_uy", scene=scene, mpm_stage_wait_time_end=1e6,
            mpm_stabilization_ghost=0)
    # conductivity in place of permeability: the viscosity is in it, the density of the water divides it
    scene = test.folder() / "conductivity.yaml"
    scene.write_text(SCENE.read_text(encoding="utf-8").replace("permeability: 1e-12", "conductivity: 1e-8"), encoding="utf-8")
    _, gradient = compare(test, "conductivity", "clay.conductivity,water.density", scene=scene)
    test.near("conductivity.density", gradient[0] * 1e-8, -gradient[1] * 1e3, relative=1e-9)
