#!/usr/bin/env python3
"""Bodies of one cell on more ranks than there are cells: some ranks have no points, some nodes of others only, some nothing.
Each feature runs on several ranks as on one: steps, history and last state.

By default each scene runs on 2, 3 or 4 ranks in turn; with --full on all of them.
"""
import sys
from pathlib import Path

import yaml

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from hostile import Ended, Hostile  # noqa: E402
from talus_test import ROOT  # noqa: E402

sys.path.insert(0, str(ROOT / "scripts"))
import ranks  # noqa: E402  (the folder has to be known first)

ONLY = [word[7:] for word in sys.argv if word.startswith("--only=")]  # scenes by name
sys.argv = [word for word in sys.argv if not word.startswith("--only=")]
LIMIT = 60.0  # s, for one run: a collective call that a rank leaves out hangs
COUNTS = (2, 3, 4)
REACH, REACH_CONTACT = 1e-9, 1e-8  # relative to the largest value

SOLID = """
mpm:
  dim: 2
  grid: {lower: "0,0", upper: "6,5", cells: "6,5"}
  materials: s
  material_s: {type: hencky, E: 1e5, nu: 0.3, density: 1000}
  bodies: b
  body_b: {region: box, lower: "2,1", upper: "3,2", points_per_cell: "3,3", material: s}
  bcs: base
  bc_base: {region: box, lower: "0,1", upper: "6,1", components: "x,y"}
  loads: weight
  load_weight: {type: gravity, value: "1,-10"}
  time: {end: 1, step: 0.5}
  tracks: t
  track_t: {at: "2.5,2", nearest: 3}
  output: {prefix: run, every: 10, grid: true}
"""
FREE = """
mpm:
  dim: 2
  grid: {lower: "0,0", upper: "6,5", cells: "6,5"}
  materials: s
  material_s: {type: hencky, E: 1e5, nu: 0.3, density: 1000}
  bodies: b
  body_b: {region: box, lower: "2,2", upper: "3,3", points_per_cell: "3,3", material: s, velocity: "0.5,-0.2"}
  loads: weight
  load_weight: {type: gravity, value: "0,-10"}
  time: {integrator: newmark, step: 0.01, end: 0.05}
  output: {prefix: run, every: 10}
"""
PORO = """
mpm:
  dim: 2
  physics: poro
  grid: {lower: "0,0", upper: "6,5", cells: "6,5"}
  water: {density: 1000, viscosity: 1e-3}
  materials: s
  material_s: {type: hencky, E: 1e6, nu: 0.3, density: 2000, porosity: 0.4, permeability: 1e-12}
  bodies: b
  body_b: {region: box, lower: "2,1", upper: "3,2", points_per_cell: "3,3", material: s}
  bcs: base
  bc_base: {region: box, lower: "0,1", upper: "6,1", components: "x,y"}
  surfaces: top
  surface_top: {body: b, side: "+y", drained: true, traction: "0,-1e3", ramp: "0:1"}
  time: {end: 200, step: 50}
  output: {prefix: run, every: 10}
"""
SPACE = """
mpm:
  dim: 3
  grid: {lower: "0,0,0", upper: "4,3,3", cells: "4,3,3"}
  materials: s
  material_s: {type: hencky, E: 1e5, nu: 0.3, density: 1000}
  bodies: b
  body_b: {region: box, lower: "1,1,1", upper: "2,2,2", points_per_cell: "2,2,2", material: s}
  bcs: base
  bc_base: {region: box, lower: "0,0,1", upper: "4,3,1", components: "x,y,z"}
  loads: weight
  load_weight: {type: gravity, value: "1,0,-10"}
  time: {end: 1, step: 0.5}
  output: {prefix: run, every: 10}
"""
PAIR = """
mpm:
  dim: 2
  grid: {lower: "0,0", upper: "6,5", cells: "6,5"}
  materials: s
  material_s: {type: hencky, E: 1e5, nu: 0.3, density: 1000}
  bodies: b,top
  body_b: {region: box, lower: "2,1", upper: "3,2", points_per_cell: "3,3", material: s}
  body_top: {region: box, lower: "2,2", upper: "3,3", points_per_cell: "3,3", material: s}
  bcs: base
  bc_base: {region: box, lower: "0,1", upper: "6,1", components: "x,y"}
  loads: weight
  load_weight: {type: gravity, value: "0,-10"}
  time: {end: 1, step: 0.5}
  output: {prefix: run, every: 10}
"""
BOX = 'region: box, lower: "2,1", upper: "3,2", points_per_cell: "3,3"'
FILE = SOLID.replace(BOX, "region: file, file: points.csv")  # the points of the box
SPHERE = SOLID.replace(BOX, 'region: sphere, center: "2.5,1.5", radius: 0.5, points_per_cell: "4,4"')
POINTS = "x,y,volume\n" + "".join(f"{2 + (i + 0.5) / 3},{1 + (j + 0.5) / 3},{1 / 9}\n" for i in range(3) for j in range(3))
CONTACT = "contacts=bt contact_bt_bodies=b,top contact_bt_friction=0.3"
SIDES = "bcs=base,side bc_side_region=box bc_side_lower=0,0 bc_side_upper=6,5 bc_side_components=x"
PUSH = "boundaries=p boundary_p_type=box boundary_p_lower=2,2 boundary_p_upper=3,2.5"
DEEP = "load_weight_ramp=0:1"

# what a scene adds to one of those above: options without their mpm_
SCENES = {
    **{shape: (SOLID, f"shape={shape}") for shape in ("linear", "gimp", "bspline2", "bspline3", "gimp_bspline2")},
    **{f"jacobian_{kind}": (SOLID, f"jacobian={kind}") for kind in ("coloring", "matfree", "dense", "fd")},
    "matfree_tangents": (SOLID, "jacobian=matfree matfree_tangents=true"),
    **{f"solver_{kind}": (SOLID, f"solver={kind}") for kind in ("direct", "amg", "boomeramg")},
    "observe": (SOLID, "sections=c,r section_c_point=2.5,1.5 section_c_normal=0,1 section_r_point=2.1,1.5 section_r_end=2.9,1.5 "
                "section_r_count=4 section_r_body=b profiles=l profile_l_from=2.1,1.5 profile_l_to=2.9,1.5 profile_l_count=5 "
                "profile_l_normal=0,1 profile_l_body=b tracks=t,u track_u_region=box track_u_lower=2,1 track_u_upper=3,1.5 "
                "output_every=1 view=ascii:view.txt"),
    "fbar": (SOLID, "material_s_type=j2 material_s_yield_stress=1e3 material_s_hardening=1e4 stabilization_fbar=true"),
    "smooth": (SOLID, "shape=bspline2 stabilization_smooth=0.5"),
    "divide": (SOLID, "stabilization_divide=0.5 bcs=base,top bc_top_region=box bc_top_lower=0,2 bc_top_upper=6,2 "
               "bc_top_components=y bc_top_value=0.6 bc_top_ramp=0:0,1:1"),
    "moved_nodes": (SOLID, "bcs=base,top bc_top_region=box bc_top_lower=0,2 bc_top_upper=6,2 bc_top_components=y "
                    "bc_top_value=-0.05 bc_top_ramp=0:0,1:1"),
    "inclined": (SOLID, "bcs=base,i bc_i_region=box bc_i_lower=0,2 bc_i_upper=6,2 bc_i_normal=1,1 bc_i_value=-0.02"),
    "motion": (SOLID, "motions=m motion_m_body=b motion_m_region=box motion_m_lower=2,1.6 motion_m_upper=3,2 "
               "motion_m_components=y motion_m_value=-0.05 bc_base_components=x"),
    "force": (SOLID, "loads=weight,f,t load_f_type=force load_f_at=2.5,2 load_f_nearest=2 load_f_value=0,-100 load_t_type=traction "
              "load_t_region=box load_t_lower=2,2 load_t_upper=3,2 load_t_value=100,0"),
    "surface": (SOLID, "surfaces=s surface_s_body=b surface_s_side=all surface_s_normal=-1e3"),
    **{f"stage_{method}": (SOLID, f"stages=rest,hold stage_rest_type=geostatic stage_rest_geostatic_method={method} "
                           "load_weight_value=0,-10 bcs=base,side bc_side_region=box bc_side_lower=2,0 bc_side_upper=3,5 "
                           "bc_side_components=x bc_base_components=y stage_hold_reset_displacement=true"
                           + (" stage_rest_geostatic_k0=0.5" if method == "k0" else "")) for method in ("gravity", "k0")},
    "stage_bodies": (PAIR, "stages=one,two,three stage_one_bodies=b stage_two_bodies=top stage_three_remove=top"),
    "stage_material": (SOLID, f"materials=s,w material_w_type=hencky material_w_E=5e4 material_w_nu=0.3 material_w_density=1000 "
                       f"stages=one,two stage_two_materials=b:w {DEEP}"),
    "reduction": (SOLID, "material_s_type=mohr_coulomb material_s_cohesion=1e4 material_s_friction=30 material_s_dilation=0 "
                  f"stages=one,two stage_two_reduction=0:1,1:1.5 {DEEP}"),
    "relaxation": (SOLID, f"stages=r stage_r_type=relaxation stage_r_time_end=5 stage_r_relaxation_tolerance=0.05 {DEEP}"),
    "relaxation_scaled": (SOLID, "stages=r stage_r_type=relaxation stage_r_time_end=100 stage_r_time_step=1 "
                          f"stage_r_relaxation_tolerance=0.05 stage_r_relaxation_nodal_mass=scaled {DEEP}"),
    **{f"free_{kind}": (FREE, f"time_integrator={kind}") for kind in ("backward_euler", "newmark", "generalized_alpha", "explicit")},
    **{f"explicit_{kind}": (FREE, f"time_integrator=explicit time_update={kind} sections=c section_c_point=2.5,2.5 "
                            "section_c_normal=0,1 output_every=1") for kind in ("musl", "usl", "usf")},
    "explicit_flip": (FREE, "time_integrator=explicit time_transfer=flip time_pic=0.1 time_viscosity_linear=0.06 "
                      "time_viscosity_quadratic=1.2 time_damping_mass=1"),
    "explicit_linear": (FREE, "time_integrator=explicit shape=linear"),
    "newmark_flip": (FREE, "time_transfer=flip time_damping_mass=1 time_damping_stiffness=1e-3 time_viscosity_linear=0.06"),
    "newmark_lumped": (FREE, "time_mass=lumped"),
    "newmark_error": (FREE, "time_error=1e-3"),
    "outflow": (FREE, "time_integrator=explicit grid_outflow=true body_b_velocity=-60,0 time_end=0.1"),
    **{f"shaken_{kind}": (FREE, f"time_integrator={kind} bcs=base bc_base_region=box bc_base_lower=0,2 bc_base_upper=6,2 "
                          "bc_base_components=x,y bc_base_value=0.1,0 bc_base_quantity=velocity") for kind in ("newmark", "explicit")},
    **{f"driven_{kind}": (FREE, f"time_integrator={kind} motions=m motion_m_body=b motion_m_region=box motion_m_lower=2,2 "
                          "motion_m_upper=3,2.4 motion_m_components=x,y motion_m_value=0.1,0 bcs=side bc_side_region=box "
                          "bc_side_lower=0,4 bc_side_upper=6,4 bc_side_components=x") for kind in ("newmark", "explicit")},
    **{f"absorbing_{kind}": (FREE, f"time_integrator={kind} bcs=base bc_base_region=box bc_base_lower=0,2 bc_base_upper=6,2 "
                             "bc_base_absorbing=true bc_base_components=x,y") for kind in ("newmark", "explicit")},
    "free_thrown": (FREE, "load_weight_value=0,0 time_integrator=generalized_alpha"),
    "pushed": (SOLID, f"{PUSH} boundary_p_motion=0.02,-0.05 boundary_p_friction=0.3"),
    "pushed_stick": (SOLID, f"{PUSH} boundary_p_motion=0,-0.05 boundary_p_friction=stick boundary_p_contact=bilateral"),
    "pushed_augmented": (SOLID, f"{PUSH} boundary_p_motion=0,-0.05 boundary_p_method=augmented"),
    "pushed_round": (SOLID, "boundaries=p boundary_p_type=sphere boundary_p_center=2.5,2.5 boundary_p_radius=0.5 "
                     "boundary_p_motion=0,-0.05 boundary_p_friction=0.2"),
    "free_rigid": (SOLID, f"{PUSH} boundary_p_free=y boundary_p_load=0,-1e3"),
    "free_rigid_turning": (SOLID, f"{PUSH} boundary_p_free=y,rz boundary_p_load=0,-1e3 boundary_p_friction=0.5"),
    "rigid_mass": (FREE, "bcs=base bc_base_region=box bc_base_lower=0,2 bc_base_upper=6,2 bc_base_components=x,y "
                   "boundaries=p boundary_p_type=box boundary_p_lower=2,3 boundary_p_upper=3,3.5 boundary_p_free=y "
                   "boundary_p_mass=100 boundary_p_load=0,-1e3 body_b_velocity=0,0"),
    "explicit_boundary": (FREE, "time_integrator=explicit boundaries=p boundary_p_type=plane boundary_p_point=0,2 "
                          "boundary_p_normal=0,1 boundary_p_friction=0.3"),
    "newmark_boundary": (FREE, "boundaries=p boundary_p_type=plane boundary_p_point=0,2 boundary_p_normal=0,1 "
                         "boundary_p_friction=0.3"),
    "welded": (PAIR, ""),
    **{f"contact_{kind}": (PAIR, f"{CONTACT} {SIDES} contact_bt_method={kind}") for kind in ("penalty", "augmented", "barrier")},
    "contact_newmark": (PAIR, f"{CONTACT} time_integrator=newmark time_step=0.01 time_end=0.05"),
    "contact_explicit": (PAIR, f"{CONTACT} time_integrator=explicit time_step=0.02 time_end=0.1"),
    "follow_boundary": (SOLID, "body_b_lower=2,0 body_b_upper=3,1 bc_base_lower=0,0 bc_base_upper=6,0 boundaries=p boundary_p_type=box "
                        "boundary_p_lower=2,1 boundary_p_upper=3,1.5 boundary_p_motion=0,-0.1 grid_follow=p grid_axes=y "
                        "grid_mode=stretch track_t_at=2.5,1"),
    "follow_body": (FREE, "grid_follow=b grid_axes=x,y grid_mode=shift time_integrator=explicit"),
    "poro": (PORO, ""),
    "poro_second": (PORO, "time_scheme=second"),
    "poro_error": (PORO, "time_scheme=second time_error=1e-2 time_step=1"),
    "poro_fieldsplit": (PORO, "solver=poro-fieldsplit ksp_rtol=1e-13"),
    "poro_nodes": (PORO, "bcs=base,p bc_p_region=box bc_p_lower=0,1 bc_p_upper=6,1 bc_p_components=p bc_p_value=500"),
    "poro_level": (PORO, "water_level=3 loads=weight load_weight_type=gravity load_weight_value=0,-10"),
    "poro_dry": (PORO, "water_level=1.5 water_above=dry loads=weight load_weight_type=gravity load_weight_value=0,-10"),
    # a rank that no condition touches has nodes in dry ground
    "poro_column": (PORO, "body_b_upper=3,5 water_level=3 loads=weight load_weight_type=gravity load_weight_value=0,-10"),
    "poro_initial": (PORO, "body_b_initial_pressure=1e3"),
    "poro_boundary": (PORO, "surfaces=s,top surface_s_body=b surface_s_side=+x surface_s_drained=true boundaries=p "
                      "boundary_p_type=box boundary_p_lower=2,2 boundary_p_upper=3,2.5 boundary_p_motion=0,-0.01 "
                      "boundary_p_drained=true"),
    "poro_contact": (PORO, "bodies=b,top body_top_region=box body_top_lower=2,2 body_top_upper=3,3 body_top_points_per_cell=3,3 "
                     "body_top_material=s contacts=bt contact_bt_bodies=b,top contact_bt_friction=0.3 surface_top_body=top"),
    "file": (FILE, ""),
    "sphere": (SPHERE, ""),
    "follow_motion": (SOLID, "motions=m motion_m_body=b motion_m_region=box motion_m_lower=2,1.6 motion_m_upper=3,2 "
                      "motion_m_components=x,y motion_m_value=0.1,0.05 bc_base_lower=0,0 bc_base_upper=6,0 bc_base_components=x "
                      "grid_follow=m grid_axes=x grid_mode=shift"),
    "pushed_polygon": (SOLID, "boundaries=p boundary_p_type=polygon boundary_p_vertices=2,2,3,2,3,3,2,3 boundary_p_motion=0,-0.05"),
    "bilateral_disc": (SPHERE, "bc_base_lower=0,0 bc_base_upper=6,0 bc_base_components=x boundaries=p "
                       "boundary_p_type=sphere boundary_p_center=2.5,1.5 boundary_p_radius=0.5 boundary_p_side=inside "
                       "boundary_p_contact=bilateral boundary_p_friction=stick boundary_p_motion=0.02,0"),
    "rescue": (PAIR, f"{CONTACT} time_rescue=relaxation"),
    "space": (SPACE, ""),
    "space_push": (SPACE, "boundaries=p boundary_p_type=box boundary_p_lower=1,1,2 boundary_p_upper=2,2,2.5 boundary_p_free=z "
                   "boundary_p_load=0,0,-1e3"),
    "space_explicit": (SPACE, "time_integrator=explicit time_step=1e-3 time_end=5e-3 body_b_velocity=1,0,0"),
}

RESTARTED = {"poro_second": 100, "newmark_boundary": 0.02}  # with the time of the restart


def options_of(text):
    """Options by name; a list without members is left out."""
    pairs = (word.split("=", 1) for word in text.split())
    return {name if name.startswith("ksp_") else f"mpm_{name}": value for name, value in pairs}


def run(test, label, count, folder=None, **more):
    """A scene on some ranks, with further options; None where it fails or hangs."""
    scene, text = SCENES[label]
    folder = folder or test.folder()
    (folder / "scene.yaml").write_text(scene, encoding="utf-8")
    (folder / "points.csv").write_text(POINTS, encoding="utf-8")
    found = Ended(test.program, folder / "scene.yaml", count, {**options_of(text), "mpm_quiet": None, **more}, folder, LIMIT)
    test.check(f"{label}.{count}.status", -1 if found.hung else found.status, 0, 0)
    if not found.hung and found.status == 0:
        return found
    print(f"    {' '.join(found.command)}\n    {found.errors.strip()[:600]}", flush=True)
    return None


def compare(test, label, one, other):
    """Steps, history and last state of a run on several ranks."""
    scene, text = SCENES[label.split(".")[0]]
    reach = REACH_CONTACT if "boundar" in text or "contacts=" in text else REACH
    steps = len(one.newton)
    test.check(f"{label}.steps", len(other.newton), steps, steps)
    if len(other.newton) == steps:
        name, worst = max(ranks.compare(one.results, other.results, yaml.safe_load(scene)["mpm"]).items(),
                          key=lambda item: item[1])
        test.check(f"{label}.{name}", worst, None, reach)


def restart(test, label, half):
    """The first half of a run on one number of ranks, the second on another."""
    whole = run(test, label, 1)
    for before, after in ((1, 3), (4, 2)):
        first = run(test, label, before, mpm_checkpoint_every=1, mpm_time_end=half)
        second = first and run(test, label, after, first.folder, mpm_checkpoint_every=1, mpm_restart="run_checkpoint.h5")
        if second:
            compare(test, f"{label}.{before}_{after}", whole, second)


with Hostile(LIMIT) as test:
    for name, half in () if ONLY else RESTARTED.items():
        restart(test, name, half)
    for place, name in enumerate(SCENES):
        if ONLY and name not in ONLY:
            continue
        alone = run(test, name, 1)
        for number in COUNTS if test.full else COUNTS[place % 3:place % 3 + 1]:
            several = alone and run(test, name, number)
            if several:
                compare(test, f"{name}.{number}", alone, several)
