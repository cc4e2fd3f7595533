#!/usr/bin/env python3
"""Scenes with one thing wrong: each must end with exit status 2 and one line that names the option, and write nothing.

The table holds the change that spoils a good scene (None removes an option) and what the line must contain. Some cases
run on 2 ranks too, where the line must still appear once.
"""
import concurrent.futures
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import Run, Test  # noqa: E402

GOOD = {
    "mpm_dim": "2",
    "mpm_grid_lower": "0,0",
    "mpm_grid_upper": "4,4",
    "mpm_grid_cells": "4,4",
    "mpm_materials": "soil",
    "mpm_material_soil_type": "hencky",
    "mpm_material_soil_E": "1e6",
    "mpm_material_soil_nu": "0.3",
    "mpm_material_soil_density": "1000",
    "mpm_bodies": "block",
    "mpm_body_block_region": "box",
    "mpm_body_block_lower": "0,0",
    "mpm_body_block_upper": "2,2",
    "mpm_body_block_points_per_cell": "2,2",
    "mpm_body_block_material": "soil",
    "mpm_bcs": "base",
    "mpm_bc_base_region": "box",
    "mpm_bc_base_lower": "0,0",
    "mpm_bc_base_upper": "4,0",
    "mpm_bc_base_components": "x,y",
    "mpm_loads": "weight,push",
    "mpm_load_weight_type": "gravity",
    "mpm_load_weight_value": "0,-1",
    "mpm_load_push_type": "force",
    "mpm_load_push_at": "2,2",
    "mpm_load_push_nearest": "1",
    "mpm_load_push_value": "10,0",
    "mpm_time_step": "0.5",
    "mpm_tracks": "top",
    "mpm_track_top_at": "2,2",
    "mpm_output_prefix": "bad",
}
COULOMB = {"mpm_material_soil_type": "mohr_coulomb", "mpm_material_soil_friction": "30",
           "mpm_material_soil_dilation": "10", "mpm_material_soil_cohesion": "1e3"}
OGDEN = {"mpm_material_soil_type": "ogden", "mpm_material_soil_E": None, "mpm_material_soil_nu": "0.4",
         "mpm_material_soil_terms": "2:1e6"}
J2 = {"mpm_material_soil_type": "j2", "mpm_material_soil_yield_stress": "1e4"}
PRAGER = {"mpm_material_soil_type": "drucker_prager", "mpm_material_soil_friction": "30",
          "mpm_material_soil_dilation": "0", "mpm_material_soil_cohesion": "1e3"}
JAUMANN = {**PRAGER, "mpm_material_soil_type": "jaumann_elastic"}
FLUID = {"mpm_material_soil_type": "newtonian", "mpm_material_soil_E": None, "mpm_material_soil_nu": None,
         "mpm_material_soil_sound_speed": "50"}
CLAY = {"mpm_material_soil_type": "modified_cam_clay", "mpm_material_soil_E": None, "mpm_material_soil_nu": None,
        "mpm_material_soil_kappa": "0.02", "mpm_material_soil_lambda": "0.1", "mpm_material_soil_M": "1.2",
        "mpm_material_soil_G": "4e6"}
SAND = {**CLAY, "mpm_material_soil_type": "nor_sand", "mpm_material_soil_lambda": "0.02", "mpm_material_soil_v_c0": "1.9",
        "mpm_material_soil_h": "100", "mpm_material_soil_specific_volume": "1.7", "mpm_material_soil_image_pressure": "1e5",
        "mpm_material_soil_reference_pressure": "1e5"}
WET = {"mpm_physics": "poro", "mpm_material_soil_porosity": "0.4", "mpm_material_soil_permeability": "1e-12"}
NO_BOX = {"mpm_body_block_lower": None, "mpm_body_block_upper": None}
NORMAL = {"mpm_bc_base_components": None, "mpm_bc_base_normal": "1,2"}
PLANE = {"mpm_boundaries": "wall", "mpm_boundary_wall_type": "plane", "mpm_boundary_wall_point": "2,0",
         "mpm_boundary_wall_normal": "-1,0"}
PUSH = {"mpm_motions": "push", "mpm_motion_push_body": "block", "mpm_motion_push_components": "y",
        "mpm_motion_push_value": "-1"}
FOLLOW = {"mpm_grid_follow": "block", "mpm_grid_axes": "y"}
DISC = {"mpm_boundaries": "wall", "mpm_boundary_wall_type": "sphere", "mpm_boundary_wall_center": "3,1",
        "mpm_boundary_wall_radius": "1"}
BOX = {"mpm_boundaries": "wall", "mpm_boundary_wall_type": "box", "mpm_boundary_wall_lower": "2,0",
       "mpm_boundary_wall_upper": "3,3"}
CONE = {"mpm_boundaries": "wall", "mpm_boundary_wall_type": "cone", "mpm_boundary_wall_tip": "1,2.5",
        "mpm_boundary_wall_radius": "0.3"}
WALL_POINTS = {**PLANE, "mpm_boundary_wall_points_region": "box", "mpm_boundary_wall_points_lower": "3,3",
               "mpm_boundary_wall_points_upper": "4,4"}
SURFACE = {"mpm_surfaces": "top", "mpm_surface_top_body": "block", "mpm_surface_top_side": "+y", "mpm_surface_top_normal": "-1e3"}
ON_REGION = {"mpm_load_push_at": None, "mpm_load_push_nearest": None, "mpm_load_push_region": "box"}

STAGES = {"mpm_stages": "one,two"}
GEOSTATIC = {**STAGES, "mpm_stage_one_type": "geostatic", "mpm_stage_one_geostatic_method": "k0",
             "mpm_stage_one_geostatic_k0": "0.5"}
TOP = {"mpm_bodies": "block,top", "mpm_body_top_region": "box", "mpm_body_top_lower": "0,2",
       "mpm_body_top_upper": "2,3", "mpm_body_top_material": "soil"}
FROM_FILE = {**NO_BOX, "mpm_body_block_region": "file", "mpm_body_block_file": "points.csv",
             "mpm_body_block_points_per_cell": None, "mpm_loads": "weight", "mpm_load_push_type": None,
             "mpm_load_push_at": None, "mpm_load_push_nearest": None, "mpm_load_push_value": None}

# name, change, what the line must contain
MOVES = {"mpm_time_integrator": "newmark"}
CASES = [
    # parameters by height, bodies and surfaces
    ("heights that decrease", {"mpm_material_soil_E": "3:1e6,1:2e6"}, "-mpm_material_soil_E 3:1e6,1:2e6: heights must not decrease"),
    ("a negative modulus at a height", {"mpm_material_soil_E": "0:1e6,1:-1"}, "-mpm_material_soil_E ... must be > 0 Pa"),
    ("one height", {"mpm_material_soil_E": "0:1e6"}, "-mpm_material_soil_E 0:1e6: two heights"),
    ("a field that is not there", {"mpm_material_soil_E": "nothing.csv"}, "-mpm_material_soil_E nothing.csv: cannot be read"),
    ("friction of a condition", {"mpm_bc_base_friction": "0.3"}, "-mpm_bc_base_friction ... boundary of type plane"),
    ("spin in a quasi-static scene", {"mpm_body_block_spin": "2"}, "-mpm_body_block_spin: no stage has inertia"),
    ("fill of a body that is there", {"mpm_body_block_fill": "true"}, "-mpm_body_block_fill true: the body joins no stage"),
    ("stress of two numbers", {"mpm_body_block_initial_stress": "1,2"}, "-mpm_body_block_initial_stress has 2 numbers: must be 1 or 4"),
    ("region of a surface without a face", {**SURFACE, "mpm_surface_top_region": "box", "mpm_surface_top_lower": "0.4,0.4",
                                            "mpm_surface_top_upper": "0.6,0.6"}, "-mpm_surface_top_region"),
    # motion
    ("velocity in a quasi-static scene", {"mpm_bc_base_quantity": "velocity"}, "-mpm_bc_base_quantity velocity ... quasi-static"),
    ("acceleration in a quasi-static scene", {"mpm_bc_base_quantity": "acceleration", "mpm_bc_base_value": "1,0"}, "-mpm_bc_base_quantity"),
    ("quantity that is none", {"mpm_bc_base_quantity": "force", **MOVES}, "-mpm_bc_base_quantity force"),
    ("absorbing base in a quasi-static scene", {"mpm_bc_base_absorbing": "true"}, "-mpm_bc_base_absorbing"),
    ("absorbing block", {"mpm_bc_base_absorbing": "true", "mpm_bc_base_upper": "4,2", **MOVES}, "-mpm_bc_base_absorbing ... plane"),
    ("table that is not there", {"mpm_bc_base_table": "nothing.csv", **MOVES}, "-mpm_bc_base_table nothing.csv: cannot be read"),
    ("option of another integrator", {"mpm_time_rho_inf": "0.9", **MOVES}, "-mpm_time_rho_inf ... generalized_alpha"),
    ("error of explicit steps", {"mpm_time_integrator": "explicit", "mpm_time_step": None, "mpm_time_error": "1e-3"}, "-mpm_time_error ... explicit"),
    ("negative damping", {"mpm_time_damping_mass": "-1", **MOVES}, "-mpm_time_damping_mass -1"),
    ("damping in a quasi-static scene", {"mpm_time_damping_mass": "1"}, "-mpm_time_damping_mass"),
    # names and words
    ("unknown option", {"mpm_colour": "red"}, "-mpm_colour"),
    ("unknown option by a dash", {"-mpm_title": "red"}, "--mpm_title: unknown option; did you mean -mpm_title?"),
    ("unknown option of a block", {"mpm_body_block_colour": "red"}, "-mpm_body_block_colour"),
    ("option with a slip", {"mpm_body_block_point_per_cell": "2,2"}, "-mpm_body_block_point_per_cell"),
    ("block that is not declared", {"mpm_material_rock_E": "1e9"}, "-mpm_material_rock_E"),
    ("parameter of another law", {"mpm_material_soil_yield_stress": "1e4"}, "-mpm_material_soil_yield_stress"),
    ("at with gravity", {"mpm_load_weight_at": "1,1"}, "-mpm_load_weight_at"),
    ("no dimension", {"mpm_dim": None}, "-mpm_dim"),
    ("one dimension", {"mpm_dim": "1"}, "-mpm_dim"),
    ("four dimensions", {"mpm_dim": "4"}, "-mpm_dim"),
    ("unknown physics", {"mpm_physics": "fluid"}, "-mpm_physics"),
    ("unknown shape", {"mpm_shape": "cubic"}, "-mpm_shape"),
    ("unknown solver", {"mpm_solver": "magic"}, "-mpm_solver"),
    ("unknown Jacobian", {"mpm_jacobian": "exact"}, "-mpm_jacobian"),
    ("unknown matrix type", {"mpm_mat_type": "round"}, "-mpm_mat_type"),
    ("neither true nor false", {"mpm_quiet": "perhaps"}, "-mpm_quiet"),
    ("empty name", {"mpm_materials": "soil,"}, "-mpm_materials"),
    ("equal names", {"mpm_materials": "soil,soil"}, "-mpm_materials"),
    ("names equal but for case", {"mpm_bodies": "block,Block"}, "-mpm_bodies"),
    ("name with a blank", {"mpm_tracks": "the top"}, "-mpm_tracks"),
    # materials
    ("no materials", {"mpm_materials": None}, "-mpm_materials"),
    ("empty list of materials", {"mpm_materials": ""}, "-mpm_materials"),
    ("material without a block", {"mpm_materials": "soil,rock"}, "-mpm_material_rock_type"),
    ("material without a type", {"mpm_material_soil_type": None}, "-mpm_material_soil_type"),
    ("unknown law", {"mpm_material_soil_type": "henky"}, "-mpm_material_soil_type"),
    ("no Young's modulus", {"mpm_material_soil_E": None}, "-mpm_material_soil_E"),
    ("Young's modulus zero", {"mpm_material_soil_E": "0"}, "-mpm_material_soil_E"),
    ("Young's modulus negative", {"mpm_material_soil_E": "-1e6"}, "-mpm_material_soil_E"),
    ("Young's modulus infinite", {"mpm_material_soil_E": "inf"}, "-mpm_material_soil_E"),
    ("Young's modulus with a unit", {"mpm_material_soil_E": "1 MPa"}, "-mpm_material_soil_E"),
    ("Young's modulus empty", {"mpm_material_soil_E": ""}, "-mpm_material_soil_E"),
    ("nu = 0.5", {"mpm_material_soil_nu": "0.5"}, "-mpm_material_soil_nu"),
    ("nu = -1", {"mpm_material_soil_nu": "-1"}, "-mpm_material_soil_nu"),
    ("nu is not a number", {"mpm_material_soil_nu": "third"}, "-mpm_material_soil_nu"),
    ("nu is NaN", {"mpm_material_soil_nu": "nan"}, "-mpm_material_soil_nu"),
    ("two values for nu", {"mpm_material_soil_nu": "0.3,0.3"}, "-mpm_material_soil_nu"),
    ("density negative", {"mpm_material_soil_density": "-1000"}, "-mpm_material_soil_density"),
    ("gravity without density", {"mpm_material_soil_density": None}, "-mpm_material_soil_density"),
    ("no yield stress", {**J2, "mpm_material_soil_yield_stress": None}, "-mpm_material_soil_yield_stress"),
    ("yield stress zero", {**J2, "mpm_material_soil_yield_stress": "0"}, "-mpm_material_soil_yield_stress"),
    ("hardening NaN", {**J2, "mpm_material_soil_hardening": "nan"}, "-mpm_material_soil_hardening"),
    ("friction of a right angle", {**PRAGER, "mpm_material_soil_friction": "90"}, "-mpm_material_soil_friction"),
    ("cohesion negative", {**PRAGER, "mpm_material_soil_cohesion": "-1"}, "-mpm_material_soil_cohesion"),
    ("unknown fit", {**PRAGER, "mpm_material_soil_fit": "tight"}, "-mpm_material_soil_fit"),
    ("Mohr-Coulomb's friction of a right angle", {**COULOMB, "mpm_material_soil_friction": "90"},
     "-mpm_material_soil_friction 90: must lie in [0, 89] degrees"),
    ("dilation above friction", {**COULOMB, "mpm_material_soil_dilation": "31"},
     "-mpm_material_soil_dilation 31: must lie in [0, 30] degrees"),
    ("friction without cohesion", {**JAUMANN, "mpm_material_soil_cohesion": None},
     "-mpm_material_soil_friction 30: must lie in [0, 0] degrees: without cohesion, which may be 0, nothing yields"),
    ("tension without cohesion", {**JAUMANN, "mpm_material_soil_cohesion": None, "mpm_material_soil_tension": "1e3"},
     "-mpm_material_soil: tension is given without cohesion"),
    ("neither cohesion nor friction", {**JAUMANN, "mpm_material_soil_cohesion": "0", "mpm_material_soil_friction": "0"},
     "-mpm_material_soil_cohesion 0: must be > 0 Pa: without friction there must be cohesion"),
    ("closing with dilation", {**JAUMANN, "mpm_material_soil_dilation": "5", "mpm_material_soil_closing": "1"}, "-mpm_material_soil_closing 1"),
    ("closing above 1", {**JAUMANN, "mpm_material_soil_closing": "1.5"}, "-mpm_material_soil_closing 1.5"),
    ("hypoelastic, dilation above friction", {**JAUMANN, "mpm_material_soil_dilation": "31"},
     "-mpm_material_soil_dilation 31: must lie in [0, 30] degrees"),
    ("fluid without a stiffness", {**FLUID, "mpm_material_soil_sound_speed": None},
     "-mpm_material_soil: bulk_modulus or sound_speed must be given"),
    ("fluid with two stiffnesses", {**FLUID, "mpm_material_soil_bulk_modulus": "2e9"},
     "-mpm_material_soil: bulk_modulus and sound_speed are given"),
    ("sound without density", {**FLUID, "mpm_material_soil_density": None, "mpm_loads": "push", "mpm_load_weight_type": None,
                               "mpm_load_weight_value": None}, "-mpm_material_soil_density 0: must be > 0"),
    ("exponent of a linear equation", {**FLUID, "mpm_material_soil_equation": "linear", "mpm_material_soil_gamma": "2"},
     "-mpm_material_soil_gamma 2: must lie in [7, 7]: it is that of equation tait"),
    ("least pressure above zero", {**FLUID, "mpm_material_soil_pressure_min": "1"}, "-mpm_material_soil_pressure_min 1: must be <= 0"),
    ("viscosity negative", {**FLUID, "mpm_material_soil_viscosity": "-1"}, "-mpm_material_soil_viscosity -1: must be >= 0"),
    ("tension beyond the apex", {**COULOMB, "mpm_material_soil_tension": "1733"},
     "-mpm_material_soil_tension 1733: must lie in [0, 1732.05"),
    ("residual cohesion above cohesion", {**COULOMB, "mpm_material_soil_cohesion_residual": "1001",
                                          "mpm_material_soil_softening_strain": "0.1"},
     "-mpm_material_soil_cohesion_residual 1001: must lie in [0, 1000] Pa"),
    ("residual friction without a strain", {**COULOMB, "mpm_material_soil_friction_residual": "25"},
     "-mpm_material_soil_friction_residual 25: must lie in [30, 30] degrees: without softening_strain"),
    ("softening strain zero", {**COULOMB, "mpm_material_soil_softening_strain": "0"},
     "-mpm_material_soil_softening_strain 0: must be > 0"),
    ("no terms", {**OGDEN, "mpm_material_soil_terms": None}, "-mpm_material_soil_terms"),
    ("terms of zero exponent", {**OGDEN, "mpm_material_soil_terms": "0:1e6,2:1e6"},
     "-mpm_material_soil: terms: no alpha may be 0"),
    ("terms without stiffness", {**OGDEN, "mpm_material_soil_terms": "2:-1e6"},
     "-mpm_material_soil: terms: the sum of alpha mu, twice the shear modulus, must be positive"),
    ("exponents that do not grow", {**OGDEN, "mpm_material_soil_terms": "2:1e6,-2:-1e6"}, "-mpm_material_soil_terms"),
    ("neither nu nor a bulk modulus", {**OGDEN, "mpm_material_soil_nu": None},
     "-mpm_material_soil_nu 0.5: must lie in (-1, 0.5)"),
    ("nu and a bulk modulus", {**OGDEN, "mpm_material_soil_bulk_modulus": "1e8"},
     "-mpm_material_soil_nu 0.4: must lie in [0.5, 0.5]: bulk_modulus is given"),
    ("unknown volumetric", {"mpm_material_soil_type": "neo_hookean", "mpm_material_soil_volumetric": "cubic"},
     "-mpm_material_soil_volumetric"),
    ("foreign parameter", {**COULOMB, "mpm_material_soil_yield_stress": "1e3"}, "-mpm_material_soil_yield_stress"),
    ("Drucker-Prager's dilation above friction", {**PRAGER, "mpm_material_soil_dilation": "31"},
     "-mpm_material_soil_dilation 31: must lie in [0, 30] degrees"),
    ("kappa of lambda", {**CLAY, "mpm_material_soil_kappa": "0.1"},
     "-mpm_material_soil_kappa 0.1: must lie in (0, 0.1): kappa must be less than lambda"),
    ("kappa above lambda", {**CLAY, "mpm_material_soil_kappa": "0.2"},
     "-mpm_material_soil_kappa 0.2: must lie in (0, 0.1): kappa must be less than lambda"),
    ("overconsolidation below one", {**CLAY, "mpm_material_soil_ocr": "0.9"}, "-mpm_material_soil_ocr 0.9: must be >= 1"),
    ("negative excess of preconsolidation", {**CLAY, "mpm_material_soil_pop": "-1"}, "-mpm_material_soil_pop -1: must be >= 0 Pa"),
    ("ocr and a preconsolidation", {**CLAY, "mpm_material_soil_ocr": "2", "mpm_material_soil_preconsolidation": "2e5"},
     "-mpm_material_soil_ocr 2: preconsolidation is given, too"),
    ("ocr and pop", {**CLAY, "mpm_material_soil_ocr": "2", "mpm_material_soil_pop": "5e4"},
     "-mpm_material_soil_pop 50000: ocr or preconsolidation is given, too"),
    ("pop and a preconsolidation", {**CLAY, "mpm_material_soil_pop": "5e4", "mpm_material_soil_preconsolidation": "2e5"},
     "-mpm_material_soil_pop 50000: ocr or preconsolidation is given, too"),
    ("ocr and a body's preconsolidation", {**CLAY, "mpm_material_soil_ocr": "2",
                                           "mpm_body_block_initial_preconsolidation": "0:3e5,2:2e5"},
     "-mpm_body_block_initial_preconsolidation: the value 300000 does not suit material soil: ocr 2: preconsolidation is given"),
    ("pop and a body's preconsolidation", {**CLAY, "mpm_material_soil_pop": "0",
                                           "mpm_body_block_initial_preconsolidation": "2e5"},
     "-mpm_body_block_initial_preconsolidation: the value 200000 does not suit material soil: pop 0: ocr or preconsolidation"),
    ("body's preconsolidation of zero", {**CLAY, "mpm_body_block_initial_preconsolidation": "0"},
     "-mpm_body_block_initial_preconsolidation: the value 0 does not suit material soil: preconsolidation 0: must be > 0 Pa"),
    ("body's specific volume below one", {**SAND, "mpm_body_block_initial_specific_volume": "0:0.9,2:1.6"},
     "-mpm_body_block_initial_specific_volume: the value 0.9 does not suit material soil: specific_volume 0.9: must be > 1"),
    ("profile that misses points", {**CLAY, "mpm_body_block_initial_preconsolidation": "1:2e5,2:1e5"},
     "-mpm_body_block_initial_preconsolidation: heights reach from 1 to 2 m, and there is a point at 0.75 m"),
    ("N of one", {**SAND, "mpm_material_soil_N": "1"}, "-mpm_material_soil_N 1: must lie in [0, 0.95]"),
    ("Nor-Sand's ocr and image pressure", {**SAND, "mpm_material_soil_ocr": "2"},
     "-mpm_material_soil_ocr 2: only one of image_pressure, preconsolidation, ocr and pop can be given"),
    ("Nor-Sand's pop and a body's image pressure", {**SAND, "mpm_material_soil_image_pressure": None,
                                                    "mpm_material_soil_pop": "1e4",
                                                    "mpm_body_block_initial_image_pressure": "1e5"},
     "-mpm_body_block_initial_image_pressure: the value 100000 does not suit material soil: pop 10000: only one of"),
    ("Nor-Sand without an image pressure", {**SAND, "mpm_material_soil_image_pressure": None},
     "-mpm_material_soil: one of image_pressure (Pa, > 0), preconsolidation (Pa, > 0), ocr (-, >= 1) and pop (Pa, >= 0)"),
    # grid
    ("no cells", {"mpm_grid_cells": None}, "-mpm_grid_cells"),
    ("zero cells", {"mpm_grid_cells": "0,4"}, "-mpm_grid_cells"),
    ("negative cells", {"mpm_grid_cells": "4,-4"}, "-mpm_grid_cells"),
    ("broken number of cells", {"mpm_grid_cells": "4.5,4"}, "-mpm_grid_cells"),
    ("cells on one axis only", {"mpm_grid_cells": "4"}, "-mpm_grid_cells"),
    ("cells on three axes in 2D", {"mpm_grid_cells": "4,4,4"}, "-mpm_grid_cells"),
    ("cells beyond counting", {"mpm_grid_cells": "99999999999999999999,4"}, "-mpm_grid_cells"),
    ("grid without extent", {"mpm_grid_upper": "4,0"}, "-mpm_grid_upper"),
    ("grid upside down", {"mpm_grid_upper": "4,-4"}, "-mpm_grid_upper"),
    ("refined by zero", {"mpm_grid_refine": "0"}, "-mpm_grid_refine"),
    # bodies
    ("no bodies", {"mpm_bodies": None}, "-mpm_bodies"),
    ("body without material", {"mpm_body_block_material": None}, "-mpm_body_block_material"),
    ("material that is not defined", {"mpm_body_block_material": "granite"}, "-mpm_body_block_material"),
    ("body outside the grid", {"mpm_body_block_lower": "10,10", "mpm_body_block_upper": "12,12"}, "-mpm_body_block"),
    ("body half outside the grid", {"mpm_body_block_upper": "5,2"}, "-mpm_body_block"),
    ("disc outside the grid", {**NO_BOX, "mpm_body_block_region": "sphere", "mpm_body_block_center": "4,4",
                               "mpm_body_block_radius": "1"}, "-mpm_body_block_region"),
    ("region between the points", {"mpm_body_block_lower": "0.1,0.1", "mpm_body_block_upper": "0.2,0.2"},
     "-mpm_body_block_region"),
    ("body upside down", {"mpm_body_block_upper": "2,-2"}, "-mpm_body_block_upper"),
    ("no points per cell", {"mpm_body_block_points_per_cell": "0,2"}, "-mpm_body_block_points_per_cell"),
    ("negative points per cell", {"mpm_body_block_points_per_cell": "-2,2"}, "-mpm_body_block_points_per_cell"),
    ("points per cell on one axis", {"mpm_body_block_points_per_cell": "2"}, "-mpm_body_block_points_per_cell"),
    ("unknown region", {"mpm_body_block_region": "ball"}, "-mpm_body_block_region"),
    ("geometry without a region", {"mpm_body_block_region": None}, "-mpm_body_block_region"),
    ("box without a corner", {"mpm_body_block_upper": None}, "-mpm_body_block_upper"),
    ("region clipped upside down", {"mpm_body_block_clip_lower": "1,1", "mpm_body_block_clip_upper": "2,0.5"},
     "-mpm_body_block_clip_upper 0.5 on axis y"),
    ("region clipped away", {"mpm_body_block_clip_lower": "2.5,2.5"}, "-mpm_body_block_region"),
    ("disc without a radius", {**NO_BOX, "mpm_body_block_region": "sphere", "mpm_body_block_center": "1,1"},
     "-mpm_body_block_radius"),
    ("disc of radius zero", {**NO_BOX, "mpm_body_block_region": "sphere", "mpm_body_block_center": "1,1",
                             "mpm_body_block_radius": "0"}, "-mpm_body_block_radius"),
    ("cylinder in 2D", {"mpm_body_block_region": "cylinder"}, "-mpm_body_block_region"),
    ("polygon of two vertices", {**NO_BOX, "mpm_body_block_region": "polygon", "mpm_body_block_vertices": "0,0,1,1"},
     "-mpm_body_block_vertices"),
    ("polygon that lacks a number", {**NO_BOX, "mpm_body_block_region": "polygon",
                                     "mpm_body_block_vertices": "0,0,2,0,2"}, "-mpm_body_block_vertices"),
    ("polygon that crosses itself", {**NO_BOX, "mpm_body_block_region": "polygon",
                                     "mpm_body_block_vertices": "0,0,2,2,2,0,0,2"}, "-mpm_body_block_vertices"),
    ("body from a file that is not there", FROM_FILE, "-mpm_body_block_file"),
    # conditions
    ("condition without a block", {"mpm_bcs": "base,wall"}, "-mpm_bc_wall"),
    ("condition without components", {"mpm_bc_base_components": None}, "-mpm_bc_base_components"),
    ("component z in 2D", {"mpm_bc_base_components": "z"}, "-mpm_bc_base_components"),
    ("pressure of a solid", {"mpm_bc_base_components": "p"}, "-mpm_bc_base_components"),
    ("component that does not exist", {"mpm_bc_base_components": "q"}, "-mpm_bc_base_components"),
    ("component twice", {"mpm_bc_base_components": "x,x"}, "-mpm_bc_base_components"),
    ("fewer values than components", {"mpm_bc_base_value": "0"}, "-mpm_bc_base_value"),
    ("value is not a number", {"mpm_bc_base_value": "0,down"}, "-mpm_bc_base_value"),
    ("condition between the nodes", {"mpm_bc_base_lower": "0.1,0.1", "mpm_bc_base_upper": "0.9,0.9"},
     "-mpm_bc_base_region"),
    ("condition outside the grid", {"mpm_bc_base_lower": "0,9", "mpm_bc_base_upper": "4,9"}, "-mpm_bc_base_region"),
    ("normal without length", {**NORMAL, "mpm_bc_base_normal": "0,0"}, "-mpm_bc_base_normal"),
    ("normal of infinite length", {**NORMAL, "mpm_bc_base_normal": "inf,0"}, "-mpm_bc_base_normal"),
    ("normal of three components in 2D", {**NORMAL, "mpm_bc_base_normal": "1,0,0"}, "-mpm_bc_base_normal"),
    ("normal and components", {"mpm_bc_base_normal": "1,2"}, "-mpm_bc_base_components"),
    ("two values along a normal", {**NORMAL, "mpm_bc_base_value": "1,2"}, "-mpm_bc_base_value"),
    # boundaries
    ("boundary without a block", {"mpm_boundaries": "wall"}, "-mpm_boundary_wall_type"),
    ("boundary of an unknown type", {**PLANE, "mpm_boundary_wall_type": "wavy"}, "-mpm_boundary_wall_type"),
    ("boundary with a condition's name", {**PLANE, "mpm_boundaries": "base"}, "-mpm_boundaries"),
    ("plane without a point", {**PLANE, "mpm_boundary_wall_point": None}, "-mpm_boundary_wall_point"),
    ("plane without a normal", {**PLANE, "mpm_boundary_wall_normal": None}, "-mpm_boundary_wall_normal"),
    ("plane with a normal of no length", {**PLANE, "mpm_boundary_wall_normal": "0,0"}, "-mpm_boundary_wall_normal"),
    ("plane with a radius", {**PLANE, "mpm_boundary_wall_radius": "1"}, "-mpm_boundary_wall_radius"),
    ("plane turned the wrong way", {**PLANE, "mpm_boundary_wall_normal": "1,0"}, "-mpm_boundary_wall_type"),
    ("plane through the body", {**PLANE, "mpm_boundary_wall_point": "1,0"}, "-mpm_boundary_wall_type"),
    ("cylinder as boundary in 2D", {**PLANE, "mpm_boundary_wall_type": "cylinder"}, "-mpm_boundary_wall_type"),
    ("polygon as boundary with two vertices", {**PLANE, "mpm_boundary_wall_type": "polygon",
                                               "mpm_boundary_wall_vertices": "2,0,2,2"}, "-mpm_boundary_wall_vertices"),
    ("disc as boundary with radius zero", {**PLANE, "mpm_boundary_wall_type": "sphere",
                                           "mpm_boundary_wall_center": "3,1", "mpm_boundary_wall_radius": "0"},
     "-mpm_boundary_wall_radius"),
    ("disc as boundary that shrinks to nothing", {**DISC, "mpm_boundary_wall_growth": "-1"}, "-mpm_boundary_wall_growth"),
    ("disc as boundary that shrinks to nothing on the way",
     {**DISC, "mpm_boundary_wall_growth": "0.5", "mpm_boundary_wall_ramp": "0:0,0.5:-2,1:0"}, "-mpm_boundary_wall_growth"),
    ("disc as boundary whose growth is no number", {**DISC, "mpm_boundary_wall_growth": "nan"},
     "-mpm_boundary_wall_growth"),
    ("plane that grows", {**PLANE, "mpm_boundary_wall_growth": "0.1"}, "-mpm_boundary_wall_growth"),
    ("polygon that grows", {**PLANE, "mpm_boundary_wall_point": None, "mpm_boundary_wall_normal": None,
                            "mpm_boundary_wall_type": "polygon", "mpm_boundary_wall_vertices": "2,0,2.5,0,2.5,2,2,2",
                            "mpm_boundary_wall_growth": "0.1"}, "-mpm_boundary_wall_growth"),
    ("box as boundary without an upper corner", {**BOX, "mpm_boundary_wall_upper": None}, "-mpm_boundary_wall_upper"),
    ("box as boundary without width", {**BOX, "mpm_boundary_wall_upper": "2,3"}, "-mpm_boundary_wall_upper 2 on axis x"),
    ("free boundary with a motion", {**BOX, "mpm_boundary_wall_free": "x", "mpm_boundary_wall_load": "-1,0",
                                     "mpm_boundary_wall_motion": "-0.1,0"}, "-mpm_boundary_wall_motion"),
    ("free boundary with a rotation", {**BOX, "mpm_boundary_wall_free": "rz", "mpm_boundary_wall_rotation": "1"},
     "-mpm_boundary_wall_rotation"),
    ("box as boundary that grows", {**BOX, "mpm_boundary_wall_growth": "0.1"}, "-mpm_boundary_wall_growth"),
    ("box as boundary within the body", {**BOX, "mpm_boundary_wall_lower": "1,0"}, "-mpm_boundary_wall_type"),
    ("cone without a tip", {**CONE, "mpm_boundary_wall_tip": None}, "-mpm_boundary_wall_tip"),
    ("cone without a radius", {**CONE, "mpm_boundary_wall_radius": None}, "-mpm_boundary_wall_radius"),
    ("cone with an angle of 180 degrees", {**CONE, "mpm_boundary_wall_angle": "180"}, "-mpm_boundary_wall_angle"),
    ("cone with an angle of zero", {**CONE, "mpm_boundary_wall_angle": "0"}, "-mpm_boundary_wall_angle"),
    ("cone with an axis of no length", {**CONE, "mpm_boundary_wall_axis": "0,0"}, "-mpm_boundary_wall_axis"),
    ("cone turned into the body", {**CONE, "mpm_boundary_wall_axis": "0,-1"}, "-mpm_boundary_wall_type"),
    ("triangles as boundary in 2D", {**PLANE, "mpm_boundary_wall_type": "stl"}, "-mpm_boundary_wall_type stl"),
    ("rotation of three components in 2D", {**BOX, "mpm_boundary_wall_rotation": "0,0,1"}, "-mpm_boundary_wall_rotation"),
    ("rotation that is no number", {**BOX, "mpm_boundary_wall_rotation": "nan"}, "-mpm_boundary_wall_rotation"),
    ("pivot of one component", {**BOX, "mpm_boundary_wall_pivot": "1"}, "-mpm_boundary_wall_pivot"),
    ("table of a motion that is not there", {**BOX, "mpm_boundary_wall_motion_table": "none.csv"},
     "-mpm_boundary_wall_motion_table none.csv: cannot be read"),
    ("penalty zero", {**PLANE, "mpm_boundary_wall_penalty": "0"}, "-mpm_boundary_wall_penalty"),
    ("unknown friction", {**PLANE, "mpm_boundary_wall_friction": "sticky"}, "-mpm_boundary_wall_friction"),
    ("adhesion without friction", {**PLANE, "mpm_boundary_wall_friction": "frictionless", "mpm_boundary_wall_adhesion": "1e3"},
     "-mpm_boundary_wall_adhesion 1000"),
    ("unknown contact", {**PLANE, "mpm_boundary_wall_contact": "loose"}, "-mpm_boundary_wall_contact"),
    ("boundary for the points of a file", {**PLANE, "mpm_boundary_wall_points_region": "file"},
     "-mpm_boundary_wall_points_region"),
    # motions, moving grid
    ("motion without a body", {**PUSH, "mpm_motion_push_body": None}, "-mpm_motion_push_body"),
    ("motion of an unknown body", {**PUSH, "mpm_motion_push_body": "pile"}, "-mpm_motion_push_body pile"),
    ("motion without components", {**PUSH, "mpm_motion_push_components": None}, "-mpm_motion_push_components"),
    ("motion along an unknown axis", {**PUSH, "mpm_motion_push_components": "z"}, "-mpm_motion_push_components z"),
    ("motion with too many values", {**PUSH, "mpm_motion_push_value": "1,2"}, "-mpm_motion_push_value"),
    ("motion of no points", {**PUSH, "mpm_motion_push_region": "box", "mpm_motion_push_lower": "3,3",
                             "mpm_motion_push_upper": "4,4"}, "-mpm_motion_push_region"),
    ("motion of the points of a file", {**PUSH, "mpm_motion_push_region": "file"}, "-mpm_motion_push_region file"),
    ("motion with a condition's name", {**PUSH, "mpm_motions": "base"}, "-mpm_motions base"),
    ("boundary with a motion's name", {**PUSH, **PLANE, "mpm_boundaries": "push"}, "-mpm_boundaries push"),
    ("motion in a geostatic stage", {**PUSH, **GEOSTATIC, "mpm_loads": "weight", "mpm_load_push_type": None,
                                     "mpm_load_push_at": None, "mpm_load_push_nearest": None,
                                     "mpm_load_push_value": None}, "-mpm_motion_push_value"),
    ("grid that follows nothing", {**FOLLOW, "mpm_grid_follow": "pile"}, "-mpm_grid_follow pile"),
    ("moving grid without axes", {**FOLLOW, "mpm_grid_axes": None}, "-mpm_grid_axes"),
    ("moving grid along an unknown axis", {**FOLLOW, "mpm_grid_axes": "z"}, "-mpm_grid_axes z"),
    ("moving grid of an unknown mode", {**FOLLOW, "mpm_grid_mode": "bend"}, "-mpm_grid_mode"),
    ("moving grid with an unknown side", {**FOLLOW, "mpm_grid_fixed": "left"}, "-mpm_grid_fixed left"),
    ("moving grid with too many sides", {**FOLLOW, "mpm_grid_fixed": "lower,upper"}, "-mpm_grid_fixed"),
    ("moving grid fixed at the side that moves", {**FOLLOW, "mpm_grid_fixed": "lower", "mpm_grid_at": "0"}, "-mpm_grid_at"),
    ("moving grid at a place outside", {**FOLLOW, "mpm_grid_at": "5"}, "-mpm_grid_at"),
    ("grid that shifts with a side that stays", {**FOLLOW, "mpm_grid_mode": "shift", "mpm_grid_fixed": "lower"},
     "-mpm_grid_fixed"),
    ("side that stays of a grid that does not move", {"mpm_grid_fixed": "lower"}, "-mpm_grid_fixed"),
    ("boundary for no points", WALL_POINTS, "-mpm_boundary_wall_points_region"),
    ("boundary that holds no points", {**PLANE, "mpm_boundary_wall_point": "3,0",
                                       "mpm_boundary_wall_contact": "bilateral"}, "-mpm_boundary_wall_contact"),
    # contacts of bodies
    ("two contacts of the same bodies", {**TOP, "mpm_contacts": "a,b", "mpm_contact_a_bodies": "block,top", "mpm_contact_b_bodies": "top,block"},
     "-mpm_contact_b_bodies top,block: contact a is that of the same bodies"),
    # surfaces of bodies
    ("surface without a body", {**SURFACE, "mpm_surface_top_body": None}, "-mpm_surface_top_body"),
    ("surface of an unknown body", {**SURFACE, "mpm_surface_top_body": "clay"}, "-mpm_surface_top_body clay"),
    ("surface without a side", {**SURFACE, "mpm_surface_top_side": None}, "-mpm_surface_top_side"),
    ("surface on an unknown side", {**SURFACE, "mpm_surface_top_side": "up"}, "-mpm_surface_top_side"),
    ("surface on a side that 2D has not", {**SURFACE, "mpm_surface_top_side": "+z"}, "-mpm_surface_top_side +z"),
    ("surface on which nothing acts", {**SURFACE, "mpm_surface_top_normal": None}, "-mpm_surface_top_traction is missing"),
    ("surface with two stresses", {**SURFACE, "mpm_surface_top_traction": "0,1"}, "-mpm_surface_top_normal"),
    ("surface with a traction of one component", {**SURFACE, "mpm_surface_top_normal": None, "mpm_surface_top_traction": "1"},
     "-mpm_surface_top_traction"),
    ("surface whose stress is no number", {**SURFACE, "mpm_surface_top_normal": "nan"}, "-mpm_surface_top_normal"),
    ("surface that is not in the list", {**SURFACE, "mpm_surfaces": None}, "-mpm_surface_top_"),
    ("surface that drains what has no water", {**SURFACE, "mpm_surface_top_drained": "true"}, "-mpm_surface_top_drained"),
    ("pressure of water where there is none", {**SURFACE, "mpm_surface_top_pressure": "1e3"}, "-mpm_surface_top_pressure"),
    ("drained boundary where there is no water", {**PLANE, "mpm_boundary_wall_drained": "true"}, "-mpm_boundary_wall_drained"),
    ("boundary with a pressure where there is no water", {**PLANE, "mpm_boundary_wall_pressure": 0}, "-mpm_boundary_wall_pressure"),
    ("boundary that is drained and has a pressure", {**PLANE, "mpm_boundary_wall_drained": "true", "mpm_boundary_wall_pressure": 0},
     "-mpm_boundary_wall_pressure"),
    ("well where there is no water", {"mpm_load_push_type": "flux", "mpm_load_push_value": "1"}, "-mpm_load_push_type flux"),
    # loads, ramps, tracks
    ("load without a type", {"mpm_load_push_type": None}, "-mpm_load_push_type"),
    ("unknown type of load", {"mpm_load_push_type": "kick"}, "-mpm_load_push_type"),
    ("load without a value", {"mpm_load_push_value": None}, "-mpm_load_push_value"),
    ("load with too many values", {"mpm_load_push_value": "1,0,0"}, "-mpm_load_push_value"),
    ("load with an infinite value", {"mpm_load_push_value": "inf,0"}, "-mpm_load_push_value"),
    ("load at a place and in a region", {"mpm_load_push_region": "all"}, "-mpm_load_push_region"),
    ("load at no place", {"mpm_load_push_at": None, "mpm_load_push_nearest": None}, "-mpm_load_push_at"),
    ("load on zero points", {"mpm_load_push_nearest": "0"}, "-mpm_load_push_nearest"),
    ("load on more points than there are", {"mpm_load_push_nearest": "17"}, "-mpm_load_push_nearest"),
    ("load on an empty region", {**ON_REGION, "mpm_load_push_lower": "3,3", "mpm_load_push_upper": "4,4"},
     "-mpm_load_push_region"),
    ("traction without a region", {"mpm_load_push_type": "traction"}, "-mpm_load_push_region"),
    ("traction where there is no face", {**ON_REGION, "mpm_load_push_type": "traction", "mpm_load_push_lower": "0,3",
                                         "mpm_load_push_upper": "4,3"}, "-mpm_load_push_region"),
    ("ramp without pairs", {"mpm_load_push_ramp": "0,1"}, "-mpm_load_push_ramp"),
    ("ramp of words", {"mpm_load_push_ramp": "start:0,end:1"}, "-mpm_load_push_ramp"),
    ("ramp back in time", {"mpm_load_push_ramp": "1:0,0:1"}, "-mpm_load_push_ramp"),
    ("ramp to NaN", {"mpm_load_push_ramp": "0:0,1:nan"}, "-mpm_load_push_ramp"),
    ("ramp with a loose end", {"mpm_load_push_ramp": "0:0,1:1,"}, "-mpm_load_push_ramp"),
    ("empty ramp", {"mpm_load_push_ramp": ""}, "-mpm_load_push_ramp"),
    ("track at no place", {"mpm_track_top_at": None}, "-mpm_track_top_at"),
    ("track without a block", {"mpm_tracks": "top,toe"}, "-mpm_track_toe_at"),
    # units, and commas too many: the line says what is accepted
    ("number with a unit", {"mpm_material_soil_E": "12e6 Pa"}, "-mpm_material_soil_E 12e6 Pa: not a number: Young's modulus (Pa), > 0"),
    ("number with a unit that touches it", {"mpm_time_step": "0.5s"}, "-mpm_time_step 0.5s: not a number: length of a step; explicit: by default as long as cfl allows (s), > 0"),
    ("number with a comma", {"mpm_material_soil_E": "12e6,"}, "12e6,: must have 1 value, has 2: Young's modulus (Pa), > 0"),
    ("number with a decimal comma", {"mpm_time_step": "0,5"}, "-mpm_time_step 0,5: must have 1 value, has 2: length of"),
    ("whole number with a unit", {"mpm_dim": "2D"}, "-mpm_dim 2D: not a whole number: dimension"),
    ("whole number with a comma", {"mpm_output_every": "1,"}, "-mpm_output_every 1,: must have 1 value, has 2: steps between"),
    ("list with a comma behind it", {"mpm_grid_lower": "0,0,"}, "-mpm_grid_lower 0,0,: must have 2 values, has 3: "),
    ("list with a comma before it", {"mpm_grid_lower": ",0,0"}, "-mpm_grid_lower ,0,0: must have 2 values, has 3: "),
    ("list with two commas", {"mpm_grid_lower": "0,,0"}, "-mpm_grid_lower 0,,0: must have 2 values, has 3: "),
    ("list with an empty part", {"mpm_grid_lower": "0,"}, "-mpm_grid_lower 0,: not a list of numbers: "),
    ("list with a unit", {"mpm_load_push_value": "10,0 N"}, "-mpm_load_push_value 10,0 N: not a list of numbers: "),
    ("list without commas", {"mpm_grid_cells": "4 4"}, "-mpm_grid_cells 4 4: must have 2 values, has 1: "),
    ("vertices with a comma", {**NO_BOX, "mpm_body_block_region": "polygon", "mpm_body_block_vertices": "0,0,2,0,2,2,"},
     "-mpm_body_block_vertices 0,0,2,0,2,2,: not a list of numbers: "),
    ("word with a comma", {"mpm_shape": "gimp,"}, "-mpm_shape gimp,: must be one of linear, gimp"),
    ("true with a comma", {"mpm_quiet": "true,"}, "-mpm_quiet true,: must be true or false"),
    ("names with two commas", {"mpm_bc_base_components": "x,,y"}, "-mpm_bc_base_components x,,y: a name is empty"),
    ("ramp with a unit", {"mpm_load_push_ramp": "0s:0,1s:1"}, "-mpm_load_push_ramp 0s:0,1s:1: must be time:factor pairs of numbers"),
    ("ramp with two commas", {"mpm_load_push_ramp": "0:0,,1:1"}, "-mpm_load_push_ramp 0:0,,1:1: must be time:factor pairs"),
    ("ghost penalty without a number", {"mpm_stabilization_ghost": ""}, "-mpm_stabilization_ghost : must be auto, off or a factor >= 0"),
    ("points divided over no length", {"mpm_stabilization_divide": "0.01"}, "-mpm_stabilization_divide 0.01: must be auto, off or a number of cells in [0.1, 10]"),
    ("points divided by a word", {"mpm_stabilization_divide": "often"}, "-mpm_stabilization_divide often: must be auto, off or a number"),
    ("divided points that move", {**MOVES, "mpm_stabilization_divide": "0.6"}, "-mpm_stabilization_divide 0.6: must be auto or off with inertia"),
    ("divided porous ground", {**WET, "mpm_stabilization_divide": "0.6"}, "-mpm_stabilization_divide 0.6: must be auto or off with poro"),
    ("smoothing without the points' own strain", {"mpm_stabilization_smooth": "1"}, "-mpm_stabilization_smooth 1: must be auto or a share in [0, 0.9]"),
    ("ghost penalty with a comma", {"mpm_stabilization_ghost": "1e-4,"}, "-mpm_stabilization_ghost 1e-4,: must be auto, off or"),
    ("materials of a stage with a comma", {**STAGES, "mpm_stage_two_materials": "block:soil,"},
     "-mpm_stage_two_materials block:soil,: must be body:material pairs"),
    ("materials of a stage with two commas", {**STAGES, **TOP, "mpm_stage_two_materials": "block:soil,,top:soil"},
     "-mpm_stage_two_materials block:soil,,top:soil: must be body:material pairs"),
    ("body of a stage twice", {**STAGES, "mpm_stage_two_materials": "block:soil,block:soil"}, "body block stands there twice"),
    ("number of PETSc's with a unit", {"ksp_rtol": "1e-8 -"}, "-ksp_rtol 1e-8 -: must be a number >= 0"),
    ("whole number of PETSc's with a comma", {"snes_max_it": "20,"}, "-snes_max_it 20,: must be a number >= 1"),
    # history to start with
    ("history of another law", {"mpm_body_block_initial_equivalent_plastic_strain": "0.1"}, "-mpm_body_block_initial_equivalent_plastic_strain"),
    ("history that misses points", {**J2, "mpm_body_block_initial_equivalent_plastic_strain": "0:0,1:0.1"},
     "-mpm_body_block_initial_equivalent_plastic_strain: heights reach from 0 to 1 m, and there is a point at 1.75 m"),
    ("history at one height", {**J2, "mpm_body_block_initial_equivalent_plastic_strain": "0:0"},
     "-mpm_body_block_initial_equivalent_plastic_strain 0:0: two heights"),
    ("history at falling heights", {**J2, "mpm_body_block_initial_equivalent_plastic_strain": "2:0,0:1"},
     "-mpm_body_block_initial_equivalent_plastic_strain 2:0,0:1: heights must not decrease"),
    ("history that is a word", {**J2, "mpm_body_block_initial_equivalent_plastic_strain": "much"},
     "-mpm_body_block_initial_equivalent_plastic_strain much: must be a number"),
    # stages
    ("empty list of stages", {"mpm_stages": ""}, "-mpm_stages"),
    ("equal stages", {"mpm_stages": "one,one"}, "-mpm_stages"),
    ("stage that is not declared", {"mpm_stages": "one", "mpm_stage_two_type": "load"}, "-mpm_stage_two_type"),
    ("unknown type of stage", {**STAGES, "mpm_stage_two_type": "rest"}, "-mpm_stage_two_type"),
    ("stage with an empty list", {**STAGES, "mpm_stage_two_loads": ""}, "-mpm_stage_two_loads"),
    ("stage with a load without a block", {**STAGES, "mpm_stage_two_loads": "kick"}, "-mpm_load_kick_type"),
    ("stage with a condition without a block", {**STAGES, "mpm_stage_two_bcs": "side"}, "-mpm_bc_side"),
    ("stage that removes nothing known", {**STAGES, "mpm_stage_two_remove": "rock"}, "-mpm_stage_two_remove"),
    ("stage that removes everything", {**STAGES, "mpm_stage_two_remove": "block"}, "-mpm_stage_two_remove"),
    ("stage that removes a body again", {**STAGES, **TOP, "mpm_stage_one_remove": "top", "mpm_stage_two_remove": "top"},
     "-mpm_stage_two_remove"),
    ("body that comes back", {**STAGES, **TOP, "mpm_stage_one_remove": "top", "mpm_stage_two_bodies": "top"},
     "-mpm_stage_one_remove"),
    ("body that joins twice", {**STAGES, **TOP, "mpm_stage_one_bodies": "top", "mpm_stage_two_bodies": "top"},
     "-mpm_stage_two_bodies"),
    ("stage that begins with nothing", {**STAGES, "mpm_stage_two_bodies": "block"}, "no body"),
    ("load on points that have gone", {**STAGES, **TOP, "mpm_stage_two_remove": "top", "mpm_stage_one_loads": "weight",
                                       **ON_REGION, "mpm_load_push_lower": "0,2", "mpm_load_push_upper": "2,3"},
     "-mpm_load_push_region"),
    ("materials of a stage without a colon", {**STAGES, "mpm_stage_two_materials": "soil"}, "-mpm_stage_two_materials"),
    ("materials of an unknown body", {**STAGES, "mpm_stage_two_materials": "rock:soil"}, "-mpm_stage_two_materials"),
    ("unknown material of a stage", {**STAGES, "mpm_stage_two_materials": "block:rock"}, "-mpm_stage_two_materials"),
    ("material of a body that has gone", {**STAGES, **TOP, "mpm_stage_one_remove": "top",
                                          "mpm_stage_two_materials": "top:soil"}, "-mpm_stage_two_materials"),
    ("stage without a step", {**STAGES, "mpm_time_step": None, "mpm_stage_one_time_step": "0.5"},
     "-mpm_stage_two_time_step"),
    ("smallest step of a stage above its step", {**STAGES, "mpm_stage_two_time_step_min": "0.7"},
     "-mpm_stage_two_time_step_min"),
    ("geostatic option of another stage", {**STAGES, "mpm_stage_two_geostatic_k0": "0.5"}, "-mpm_stage_two_geostatic_k0"),
    ("reduction of nothing", {**STAGES, "mpm_stage_two_reduction": "0:1,1:2"},
     "-mpm_stage_two_reduction: no material has a strength"),
    ("reduction by zero", {**STAGES, **COULOMB, "mpm_stage_two_reduction": "0:1,1:0"},
     "-mpm_stage_two_reduction: the factor 0 must be > 0"),
    ("negative reduction", {**STAGES, **J2, "mpm_stage_two_reduction": "0:-1"},
     "-mpm_stage_two_reduction: the factor -1 must be > 0"),
    ("reduction without a time", {**STAGES, **J2, "mpm_stage_two_reduction": "2"}, "-mpm_stage_two_reduction 2"),
    ("geostatic reduction", {**GEOSTATIC, **J2, "mpm_stage_one_reduction": "0:1,1:2"},
     "-mpm_stage_one_reduction: a geostatic stage"),
    ("more strength than tension allows", {**STAGES, **COULOMB, "mpm_material_soil_tension": "1.5e3",
                                           "mpm_stage_two_reduction": "0:0.5,1:2"},
     "-mpm_stage_two_reduction: 0.5 leaves material soil tension 3000: must"),
    ("reduction that passes an angle's range", {**STAGES, **PRAGER, "mpm_stage_two_reduction": "0:0.001"},
     "-mpm_stage_two_reduction: 0.001 leaves material soil friction"),
    ("limit of a reduction at zero", {**STAGES, **J2, "mpm_stage_two_reduction": "0:2", "mpm_stage_two_reduction_limit": "0"},
     "-mpm_stage_two_reduction_limit"),
    ("limit without a reduction", {**STAGES, **J2, "mpm_stage_two_reduction_limit": "0.1"}, "-mpm_stage_two_reduction_limit"),
    ("k0 missing", {**GEOSTATIC, "mpm_stage_one_geostatic_k0": None}, "-mpm_stage_one_geostatic_k0"),
    ("k0 negative", {**GEOSTATIC, "mpm_stage_one_geostatic_k0": "-0.5"}, "-mpm_stage_one_geostatic_k0"),
    ("k0 NaN", {**GEOSTATIC, "mpm_stage_one_geostatic_k0": "nan"}, "-mpm_stage_one_geostatic_k0"),
    ("k0 of an unknown body", {**GEOSTATIC, "mpm_stage_one_geostatic_k0": "rock:0.5"}, "there is no body or material rock"),
    ("k0 that leaves a body out", {**GEOSTATIC, **TOP, "mpm_stage_one_geostatic_k0": "block:0.5"}, "body top has none"),
    ("k0 of a body twice", {**GEOSTATIC, "mpm_stage_one_geostatic_k0": "block:0.5,soil:0.4"}, "body block stands there twice"),
    ("k0 in words", {**GEOSTATIC, "mpm_stage_one_geostatic_k0": "block:much"}, "-mpm_stage_one_geostatic_k0 block:much: must be a number"),
    ("k0 that the law does not know", {**GEOSTATIC, "mpm_stage_one_geostatic_k0": "ocr"},
     "-mpm_stage_one_geostatic_k0 ocr: hencky does not know"),
    ("k0 without gravity", {**GEOSTATIC, "mpm_stage_one_loads": "push"}, "-mpm_stage_one_geostatic_method"),
    ("k0 with oblique gravity", {**GEOSTATIC, "mpm_load_weight_value": "1,-1"}, "-mpm_stage_one_geostatic_method"),
    ("unknown geostatic method", {**GEOSTATIC, "mpm_stage_one_geostatic_method": "guess"},
     "-mpm_stage_one_geostatic_method"),
    ("geostatic tolerance zero", {**GEOSTATIC, "mpm_stage_one_geostatic_tolerance": "0"},
     "-mpm_stage_one_geostatic_tolerance"),
    ("geostatic stage that is pushed", {**GEOSTATIC, "mpm_bc_base_value": "0,0.1"}, "-mpm_bc_base_value"),
    # saturated ground
    ("water without permeability", {**WET, "mpm_material_soil_permeability": None},
     "-mpm_material_soil_permeability is missing: must be given"),
    ("permeability twice", {**WET, "mpm_material_soil_conductivity": "1e-5"},
     "-mpm_material_soil_conductivity: permeability is given, too, must be one of them"),
    ("permeability zero", {**WET, "mpm_material_soil_permeability": "0"}, "-mpm_material_soil_permeability 0: must be > 0"),
    ("permeability negative along an axis", {**WET, "mpm_material_soil_permeability": "1e-12,-1e-12"},
     "-mpm_material_soil_permeability -1e-12: must be > 0"),
    ("permeability of three axes in a plane", {**WET, "mpm_material_soil_permeability": "1e-12,1e-12,1e-12"},
     "-mpm_material_soil_permeability has 3 numbers: must be one, or one an axis"),
    ("permeability NaN", {**WET, "mpm_material_soil_permeability": "nan"}, "-mpm_material_soil_permeability"),
    ("conductivity of light water", {**WET, "mpm_material_soil_permeability": None, "mpm_material_soil_conductivity": "1e-5",
                                     "mpm_water_density": "0"}, "-mpm_material_soil_conductivity: -mpm_water_density is 0"),
    ("unknown permeability law", {**WET, "mpm_material_soil_permeability_law": "linear"}, "-mpm_material_soil_permeability_law"),
    ("growth below one", {"mpm_time_growth": "0.9"}, "-mpm_time_growth 0.9: must lie in [1, 100]"),
    ("error of zero", {**WET, "mpm_time_error": "0"}, "-mpm_time_error 0: must be"),
    ("error below zero", {**WET, "mpm_time_error": "-1e-3"}, "-mpm_time_error -1e-3: must be > 0"),
    ("error of backward Euler", {**WET, "mpm_time_error": "1e-3", "mpm_time_scheme": "euler"}, "-mpm_time_scheme euler"),
    ("scheme that is none", {**WET, "mpm_time_scheme": "third"}, "-mpm_time_scheme third"),
    ("two stages of a solid", {"mpm_time_scheme": "second"}, "-mpm_time_scheme second"),
    ("level without gravity", {**WET, "mpm_loads": "push", "mpm_load_weight_type": None, "mpm_load_weight_value": None,
                             "mpm_water_level": "1"}, "-mpm_water_level: needs a load of type gravity"),
    ("level above the grid", {**WET, "mpm_water_level": "4.5"}, "-mpm_water_level 4.5: the level, with its ramp, must be"),
    ("level that a ramp lifts out", {**WET, "mpm_water_level": "3", "mpm_water_ramp": "0:1,1:2"}, "-mpm_water_level 3"),
    ("level in slanting gravity", {**WET, "mpm_load_weight_value": "3,-10", "mpm_water_level": "3"}, "-mpm_water_level"),
    ("level without water", {"mpm_water_level": "3"}, "mpm_water_level"),
    ("water above that is none", {**WET, "mpm_water_level": "3", "mpm_water_above": "wet"}, "-mpm_water_above wet"),
    ("pressure in dry ground", {"mpm_body_block_initial_pressure": "1"}, "mpm_body_block_initial_pressure"),
    ("band with two fields", {**WET, "pc_type": "band"}, "-pc_type band: is for one field"),
    ("multigrid for a saddle point", {**WET, "mpm_solver": "amg"}, "-mpm_solver amg: needs a definite Jacobian"),
    ("blocks of one field", {"mpm_solver": "poro-fieldsplit"}, "-mpm_solver poro-fieldsplit: needs a displacement and a pressure"),
    ("porosity missing", {**WET, "mpm_material_soil_porosity": None}, "-mpm_material_soil_porosity is missing"),
    ("porosity zero", {**WET, "mpm_material_soil_porosity": "0"}, "-mpm_material_soil_porosity 0: must lie in (0, 1)"),
    ("porosity one", {**WET, "mpm_material_soil_porosity": "1"}, "-mpm_material_soil_porosity 1: must lie in (0, 1)"),
    ("porosity negative", {**WET, "mpm_material_soil_porosity": "-0.5"}, "-mpm_material_soil_porosity -0.5: must lie in (0, 1)"),
    ("porosity minus one", {**WET, "mpm_material_soil_porosity": "-1"}, "-mpm_material_soil_porosity -1: must lie in (0, 1)"),
    ("porosity beside a specific volume", {**CLAY, **WET, "mpm_material_soil_ocr": "2", "mpm_material_soil_specific_volume": "2",
                                           "mpm_material_soil_reference_pressure": "1e5"},
     "-mpm_material_soil_porosity: specific_volume is given, too"),
    ("porosity beside sand's specific volume", {**SAND, **WET}, "-mpm_material_soil_porosity: specific_volume is given, too"),
    ("porosity of dry ground", {"mpm_material_soil_porosity": "0.4"}, "mpm_material_soil_porosity"),
    ("water without viscosity", {**WET, "mpm_water_viscosity": "0"}, "-mpm_water_viscosity 0: must be > 0"),
    ("water without modulus", {**WET, "mpm_water_modulus": "0"}, "-mpm_water_modulus 0: must be > 0"),
    ("water of negative density", {**WET, "mpm_water_density": "-1"}, "-mpm_water_density -1: must be"),
    ("smoothed porous ground", {**WET, "mpm_stabilization_smooth": "0.5"}, "-mpm_stabilization_smooth 0.5: not available for physics poro"),
    ("negative pressure projection", {**WET, "mpm_stabilization_ppp": "-1"}, "-mpm_stabilization_ppp -1: must be"),
    # points from files
    ("body from a file without a name", {**FROM_FILE, "mpm_body_block_file": None}, "-mpm_body_block_file"),
    # time and output
    ("no step", {"mpm_time_step": None}, "-mpm_time_step"),
    ("step zero", {"mpm_time_step": "0"}, "-mpm_time_step"),
    ("step negative", {"mpm_time_step": "-0.1"}, "-mpm_time_step"),
    ("step NaN", {"mpm_time_step": "nan"}, "-mpm_time_step"),
    ("end zero", {"mpm_time_end": "0"}, "-mpm_time_end"),
    ("smallest step above the step", {"mpm_time_step_min": "1"}, "-mpm_time_step_min"),
    ("largest step below the step", {"mpm_time_adaptive": "true", "mpm_time_step_max": "0.1"}, "-mpm_time_step_max"),
    ("growth that shrinks", {"mpm_time_growth": "0.5"}, "-mpm_time_growth"),
    ("output every minus one steps", {"mpm_output_every": "-1"}, "-mpm_output_every"),
    ("results in a folder that is not there", {"mpm_output_prefix": "nowhere/bad"}, "-mpm_output_prefix"),
    ("no prefix", {"mpm_output_prefix": ""}, "-mpm_output_prefix"),
    # further than options go
    ("unknown linear solver of PETSc", {"ksp_type": "magic"}, "-ksp_type"),
    ("unknown preconditioner of PETSc", {"pc_type": "magic"}, "-pc_type"),
    ("line search without a name", {"snes_linesearch_type": ""}, "-snes_linesearch_type"),
    ("factorisation without a name", {"pc_factor_mat_solver_type": ""}, "-pc_factor_mat_solver_type"),
]

# name, text of the scene file (None: there is none), what the line must contain
FILES = [
    ("scene that is not there", None, "scene.yaml"),
    ("empty scene", "", "-mpm_dim"),
    ("broken YAML", "mpm:\n  dim: 2\n grid: {cells: [1, 2\n", "scene.yaml: line 3 is no YAML"),
    ("not YAML", "\x01\x02\x03 { [ : \n", "scene.yaml"),
]

# name, lines before and behind the good scene's (which has an option a line), what the line must contain
TWICE = [
    ("option twice", "", 'mpm_dim: 2\n', "line 32: mpm_dim stands here for the second time, the first is in line 1"),
    ("option twice but for case", "", 'MPM_Dim: 2\n', "MPM_Dim"),
    ("option twice in braces", "", "mpm_material_soil: {x: 1, x: 2}\n", "line 32: mpm_material_soil_x"),
    ("block twice", "", "mpm:\n  title: one\nmpm:\n  quiet: false\n", "line 34: mpm stands"),
    ("block of a block twice", "", "mpm:\n  a: {b: 1}\n  # remark\n  a: {c: 1}\n", "line 35: mpm_a stands"),
    ("option twice in lines and blocks", "", "mpm:\n  dim: 2\n", "line 33: mpm_dim"),
    ("option of PETSc's twice", "snes: {rtol: 1e-8}\n", "snes_rtol: 1e-9\n", "line 33: snes_rtol"),
    ("option twice in a list of maps", "", "snes: [{rtol: 1e-8}, {rtol: 1e-9}]\n", "snes_rtol"),
    ("block that holds itself", "", "mpm_block: &block {inner: *block}\n", "nested more than 100 deep"),
    ("blocks by the million", "".join(f"$$k{i}: &k{i} {{{', '.join(f'a{j}: *k{i - 1}' for j in range(9)) if i else 'a: 1'}}}\n"
                                      for i in range(9)), "mpm_x: *k8\n", "10000"),
]
# the same, of files in which nothing stands twice
ONCE = [
    ("equal keys of two blocks", "", "snes: {rtol: 1e-8}\nksp: {rtol: 1e-8}\n"),
    ("merged block that is overridden", "$$few: &few {rtol: 1e-8, max_it: 20}\n", "snes: {<<: *few, rtol: 1e-9}\n"),
    ("remarks and a second document", "# mpm_dim: 2\n", "---\nmpm_dim: 2\n"),
]

# name, text of points.csv, what the line must contain besides the option
POINTS = [
    ("file of points without points", "x,y,volume\n", "no point"),
    ("empty file of points", "", "there is no x"),
    ("points without a volume", "x,y\n1,1\n", "volume"),
    ("points without y", "x,volume\n1,1\n", "position"),
    ("points with a short line", "x,y,volume\n1,1,1\n1,2\n", "line 3"),
    ("points with a long line", "x,y,volume\n1,1,1,1\n", "line 2"),
    ("points with a word", "# remark\nx,y,volume\n1,high,1\n", "line 3, column y"),
    ("points with NaN", "x,y,volume\n1,1,1\n1,nan,1\n", "point 1"),
    ("points outside the grid", "x,y,volume\n1,1,1\n1,4.5,1\n", "4.5) is outside the grid"),
    ("points without size", "x,y,volume\n1,1,0\n", "volume that is not positive"),
    ("points larger than the grid", "x,y,volume\n1,1,1e30\n", "volume that is more than the grid"),
    ("points with a part of the stress", "x,y,volume,stress_xx,stress_yy\n1,1,1,0,0\n", "stress_xx"),
    ("points turned inside out", "x,y,volume,F_xx,F_xy,F_yx,F_yy\n1,1,1,-1,0,0,1\n", "determinant"),
    ("points with an infinite stress", "x,y,volume,stress_xx,stress_yy,stress_zz,stress_xy\n1,1,1,0,-inf,0,0\n", "stress"),
    ("points of several materials", "x,y,volume,material\n1,1,1,0\n1,2,1,1\n", "file_material"),
]

# The good scene in 3D, with a surface from a file beside it.
SURFACE = {
    "mpm_dim": "3", "mpm_grid_lower": "0,0,0", "mpm_grid_upper": "4,4,4", "mpm_grid_cells": "4,4,4",
    "mpm_body_block_lower": "0,0,0", "mpm_body_block_upper": "2,2,2", "mpm_body_block_points_per_cell": "2,2,2",
    "mpm_bc_base_lower": "0,0,0", "mpm_bc_base_upper": "4,4,0", "mpm_bc_base_components": "x,y,z",
    "mpm_load_weight_value": "0,0,-1", "mpm_load_push_at": "2,2,2", "mpm_load_push_value": "10,0,0",
    "mpm_track_top_at": "2,2,2", "mpm_time_end": "0.5", "mpm_boundaries": "wall", "mpm_boundary_wall_type": "stl",
    "mpm_boundary_wall_file": "surface.stl",
}
TETRAHEDRON = (("2.5 0 0", "2.5 0 1", "2.5 1 0"), ("2.5 0 0", "2.5 1 0", "3.5 0 0"), ("2.5 0 0", "3.5 0 0", "2.5 0 1"),
               ("2.5 0 1", "3.5 0 0", "2.5 1 0"))


def facets(triangles, turned=()):
    """An ASCII STL file; those `turned` look inwards."""
    lines = ["solid surface"]
    for number, corners in enumerate(triangles):
        corners = corners[::-1] if number in turned else corners
        lines += ["facet normal 0 0 0", "outer loop", *(f"vertex {corner}" for corner in corners), "endloop", "endfacet"]
    return "\n".join([*lines, "endsolid surface", ""])


# name, text of surface.stl (None: not there), what the line must contain besides option and file
SURFACES = [
    ("surface that is not there", None, "cannot be read"),
    ("empty surface", "", "is no STL file"),
    ("surface without triangles", facets(()), "has no triangles"),
    ("open surface", facets(TETRAHEDRON[:3]), "open: the edge from (2.5, 0, 1) to (2.5, 1, 0) belongs to triangle 1 alone"),
    ("inverted surface", facets(TETRAHEDRON, range(4)), "the part with triangle 4, at (2.5, 1, 0), is inverted"),
    ("surface with one triangle turned", facets(TETRAHEDRON, [2]), "disagree about the outside"),
    ("surface with a triangle twice", facets(TETRAHEDRON + TETRAHEDRON[:1]), "belongs to 3 triangles"),
    ("surface with a triangle without area", facets(TETRAHEDRON[:3] + (("2.5 0 1", "3 0 0.5", "3.5 0 0"),)), "triangle 4"),
    ("surface with a word for a number", facets(TETRAHEDRON).replace("vertex 3.5 0 0", "vertex 3.5 o 0", 1), "line 13, 'vertex"),
    ("surface that breaks off", facets(TETRAHEDRON)[:200], "is not what an ASCII STL file has there"),
]

# name, text of table.csv, quantity, what the line must contain besides option and file
TABLES = [
    ("record with a hole", "time,value\n0,0\n0.1,1\n0.2,0\n0.5,1\n0.6,0\n", "acceleration", "a hole in time: nothing between 0.2 s and 0.5 s"),
    ("record of one row", "time,value\n0,0\n", "acceleration", "has a single row"),
    ("record that lacks one row", "time,value\n0,0\n0.1,1\n0.3,0\n0.4,1\n", "velocity", "a hole in time"),
    ("record that goes back", "time,value\n0,0\n0.2,1\n0.1,0\n", "acceleration", "time must grow from row to row"),
    ("table that stands still", "time,value\n0,0\n0.2,1\n0.2,0\n", "displacement", "time must grow from row to row"),
    ("table with another column", "time,a\n0,0\n1,1\n", "displacement", "must have the columns time and value"),
    ("table without rows", "time,value\n", "displacement", "has no rows"),
    ("table with a word", "time,value\n0,x\n", "displacement", ""),
    ("table with NaN", "time,value\n0,0\n1,nan\n", "displacement", ""),
]

SUFFIXES = {"table": "table.csv", "scene": "scene.yaml", "points": "points.csv", "surface": "surface.stl"}

TWO_RANKS = {"open surface", "surface that is not there", "points with NaN", "points with a short line", "points outside the grid", "file of points without points",
             "stage that removes everything", "unknown option", "nu = 0.5", "region between the points", "load on more points than there are",
             "condition between the nodes", "normal without length", "plane through the body",
             "boundary for no points", "motion of no points", "results in a folder that is not there", "broken YAML", "option twice"}


def write_scene(folder, options):
    path = folder / "scene.yaml"
    path.write_text("".join(f'{name}: "{value}"\n' for name, value in options.items()), encoding="utf-8")
    return path


def changed(change):
    return {name: value for name, value in {**GOOD, **change}.items() if value is not None}


def faults(run, expected, ranks):
    """What is wrong with the way in which a run refused its scene."""
    lines = [line for line in run.errors.splitlines() if line.strip()]
    told = [line for line in lines if line.startswith("talus: error:")]
    if run.status != 2:
        yield f"exit status {run.status}"
    if len(told) != 1:
        yield f"{len(told)} lines 'talus: error:'"
    if ranks == 1 and len(lines) != len(told):  # mpiexec adds lines of its own
        yield "more on stderr"
    for words in expected.split(" ... "):
        if told and words not in told[0]:
            yield f"no {words}"
    if "PETSC ERROR" in run.errors + run.output or "Caught signal" in run.errors:
        yield "traceback"
    extra = [name for name in run.files if name not in SUFFIXES.values()]
    if extra:
        yield "wrote " + ", ".join(extra)


class Refusals:
    """Runs of spoilt scenes, several at a time: most of a refused run's time goes by while MPI starts and ends."""

    def __init__(self, test):
        self.test, self.pool, self.waiting = test, concurrent.futures.ThreadPoolExecutor(4), []

    def add(self, name, expected, options=None, **files):
        """A case on one rank or, if TWO_RANKS has it, on both numbers; files by their stems, None: not there."""
        for count in (1, 2) if name in TWO_RANKS else (1,):
            folder = self.test.folder()
            if options is not None:
                write_scene(folder, changed(options))
            for stem, text in files.items():
                if text is not None:
                    (folder / SUFFIXES[stem]).write_text(text, encoding="utf-8")
            run = self.pool.submit(Run, self.test.program, folder / "scene.yaml", count, {}, folder)
            self.waiting.append((name, expected, count, run))

    def finish(self):
        for name, expected, count, future in self.waiting:
            run = future.result()
            found = list(faults(run, expected, count))
            label = name.replace(" ", "_") + ("" if count == 1 else f"_on_{count}_ranks")
            self.test.check(label, len(found), None, 0)
            if found:
                print(f"    {'; '.join(found)}: {run.errors.strip()[:400]}")
        self.pool.shutdown()


with Test() as test:
    place = test.folder()
    good = Run(test.program, write_scene(place, GOOD), 1, {}, place)
    test.check("the_good_scene", good.status, 0, 0)
    refusals = Refusals(test)
    for case, change, contains in CASES:
        refusals.add(case, contains, change)
    for case, text, contains in FILES:
        refusals.add(case, contains, scene=text)
    lines = write_scene(place, GOOD).read_text(encoding="utf-8")
    for case, head, tail, contains in TWICE:
        refusals.add(case, contains, scene=head + lines + tail)
    for case, text, contains in POINTS:
        refusals.add(case, contains, FROM_FILE, points=text)
    for case, text, quantity, contains in TABLES:
        refusals.add(case, f"-mpm_bc_base_table table.csv ... {contains}", {"mpm_bc_base_table": "table.csv", "mpm_bc_base_quantity": quantity,
                                                                            **MOVES}, table=text)
    (place / "surface.stl").write_text(facets(TETRAHEDRON), encoding="utf-8")
    surface = Run(test.program, write_scene(place, changed(SURFACE)), 1, {}, place)
    lacking = "this build cannot search triangles" if surface.status == 2 else None  # built without Embree
    if lacking:
        refusals.add("triangles without the library", lacking, SURFACE, surface=facets(TETRAHEDRON))
    else:
        test.check("the_good_surface", surface.status, 0, 0)
    for case, text, contains in () if lacking else SURFACES:
        refusals.add(case, f"-mpm_boundary_wall_file surface.stl ... {contains}", SURFACE, surface=text)
    refusals.finish()
    for case, head, tail in ONCE:
        (place / "scene.yaml").write_text(head + lines + tail, encoding="utf-8")
        once = Run(test.program, place / "scene.yaml", 1, {"mpm_dim": 2}, place)  # the command line overrides
        test.check(case.replace(" ", "_"), once.status, 0, 0)
