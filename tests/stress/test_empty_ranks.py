#!/usr/bin/env python3
"""Bodies of one cell on more ranks than there are cells: ranks without points, with nodes of others only, with nothing.
Each feature runs on several ranks as on one: steps, history and last state.

By default each scene runs on 2 or 3 ranks in turn, restarts on 4 too; with --full on 2, 3 and 4. --only=NAME: one scene.
"""
import re
import sys
from pathlib import Path

import yaml

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from hostile import Ended, Hostile  # noqa: E402
from talus_test import FULL, ROOT  # noqa: E402

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
POINTS = "x,y,volume\n" + "".join(f"{2 + (k % 3 + 0.5) / 3},{1 + (k // 3 + 0.5) / 3},{1 / 9}\n" for k in range(9))
BASES = {"solid": SOLID, "free": FREE, "poro": PORO, "space": SPACE, "pair": PAIR, "file": FILE, "sphere": SPHERE}

# Name, base, and what the scene adds to it: options without their mpm_.
TABLE = """
linear: solid shape=linear
gimp: solid shape=gimp
bspline2: solid shape=bspline2
bspline3: solid shape=bspline3
gimp_bspline2: solid shape=gimp_bspline2
jacobian_coloring: solid jacobian=coloring
jacobian_matfree: solid jacobian=matfree
jacobian_dense: solid jacobian=dense
jacobian_fd: solid jacobian=fd
matfree_tangents: solid jacobian=matfree matfree_tangents=true
solver_direct: solid solver=direct
solver_amg: solid solver=amg
solver_boomeramg: solid solver=boomeramg
observe: solid sections=c,r section_c_point=2.5,1.5 section_c_normal=0,1 section_r_point=2.1,1.5 section_r_end=2.9,1.5
    section_r_count=4 section_r_body=b profiles=l profile_l_from=2.1,1.5 profile_l_to=2.9,1.5 profile_l_count=5
    profile_l_normal=0,1 profile_l_body=b tracks=t,u track_u_region=box track_u_lower=2,1 track_u_upper=3,1.5
    output_every=1 view=ascii:view.txt
fbar: solid material_s_type=j2 material_s_yield_stress=1e3 material_s_hardening=1e4 stabilization_fbar=true
smooth: solid shape=bspline2 stabilization_smooth=0.5
divide: solid stabilization_divide=0.5 bcs=base,top bc_top_region=box bc_top_lower=0,2 bc_top_upper=6,2
    bc_top_components=y bc_top_value=0.6 bc_top_ramp=0:0,1:1
moved_nodes: solid bcs=base,top bc_top_region=box bc_top_lower=0,2 bc_top_upper=6,2 bc_top_components=y
    bc_top_value=-0.05 bc_top_ramp=0:0,1:1
inclined: solid bcs=base,i bc_i_region=box bc_i_lower=0,2 bc_i_upper=6,2 bc_i_normal=1,1 bc_i_value=-0.02
motion: solid motions=m motion_m_body=b motion_m_region=box motion_m_lower=2,1.6 motion_m_upper=3,2
    motion_m_components=y motion_m_value=-0.05 bc_base_components=x
force: solid loads=weight,f,t load_f_type=force load_f_at=2.5,2 load_f_nearest=2 load_f_value=0,-100
    load_t_type=traction load_t_region=box load_t_lower=2,2 load_t_upper=3,2 load_t_value=100,0
surface: solid surfaces=s surface_s_body=b surface_s_side=all surface_s_normal=-1e3
stage_gravity: solid stages=rest,hold stage_rest_type=geostatic stage_rest_geostatic_method=gravity
    load_weight_value=0,-10 bcs=base,side bc_side_region=box bc_side_lower=2,0 bc_side_upper=3,5 bc_side_components=x
    bc_base_components=y stage_hold_reset_displacement=true
stage_k0: solid stages=rest,hold stage_rest_type=geostatic stage_rest_geostatic_method=k0 load_weight_value=0,-10
    bcs=base,side bc_side_region=box bc_side_lower=2,0 bc_side_upper=3,5 bc_side_components=x bc_base_components=y
    stage_hold_reset_displacement=true stage_rest_geostatic_k0=0.5
stage_bodies: pair stages=one,two,three stage_one_bodies=b stage_two_bodies=top stage_three_remove=top
stage_material: solid materials=s,w material_w_type=hencky material_w_E=5e4 material_w_nu=0.3 material_w_density=1000
    stages=one,two stage_two_materials=b:w load_weight_ramp=0:1
reduction: solid material_s_type=mohr_coulomb material_s_cohesion=1e4 material_s_friction=30 material_s_dilation=0
    stages=one,two stage_two_reduction=0:1,1:1.5 load_weight_ramp=0:1
relaxation: solid stages=r stage_r_type=relaxation stage_r_time_end=5 stage_r_relaxation_tolerance=0.05
    load_weight_ramp=0:1
relaxation_scaled: solid stages=r stage_r_type=relaxation stage_r_time_end=100 stage_r_time_step=1
    stage_r_relaxation_tolerance=0.05 stage_r_relaxation_nodal_mass=scaled load_weight_ramp=0:1
free_backward_euler: free time_integrator=backward_euler
free_newmark: free time_integrator=newmark
free_generalized_alpha: free time_integrator=generalized_alpha
free_explicit: free time_integrator=explicit
explicit_musl: free time_integrator=explicit time_update=musl sections=c section_c_point=2.5,2.5 section_c_normal=0,1
    output_every=1
explicit_usl: free time_integrator=explicit time_update=usl sections=c section_c_point=2.5,2.5 section_c_normal=0,1
    output_every=1
explicit_usf: free time_integrator=explicit time_update=usf sections=c section_c_point=2.5,2.5 section_c_normal=0,1
    output_every=1
explicit_flip: free time_integrator=explicit time_transfer=flip time_pic=0.1 time_viscosity_linear=0.06
    time_viscosity_quadratic=1.2 time_damping_mass=1
explicit_linear: free time_integrator=explicit shape=linear
newmark_flip: free time_transfer=flip time_damping_mass=1 time_damping_stiffness=1e-3 time_viscosity_linear=0.06
newmark_lumped: free time_mass=lumped
newmark_error: free time_error=1e-3
outflow: free time_integrator=explicit grid_outflow=true body_b_velocity=-60,0 time_end=0.1
shaken_newmark: free time_integrator=newmark bcs=base bc_base_region=box bc_base_lower=0,2 bc_base_upper=6,2
    bc_base_components=x,y bc_base_value=0.1,0 bc_base_quantity=velocity
shaken_explicit: free time_integrator=explicit bcs=base bc_base_region=box bc_base_lower=0,2 bc_base_upper=6,2
    bc_base_components=x,y bc_base_value=0.1,0 bc_base_quantity=velocity
driven_newmark: free time_integrator=newmark motions=m motion_m_body=b motion_m_region=box motion_m_lower=2,2
    motion_m_upper=3,2.4 motion_m_components=x,y motion_m_value=0.1,0 bcs=side bc_side_region=box bc_side_lower=0,4
    bc_side_upper=6,4 bc_side_components=x
driven_explicit: free time_integrator=explicit motions=m motion_m_body=b motion_m_region=box motion_m_lower=2,2
    motion_m_upper=3,2.4 motion_m_components=x,y motion_m_value=0.1,0 bcs=side bc_side_region=box bc_side_lower=0,4
    bc_side_upper=6,4 bc_side_components=x
absorbing_newmark: free time_integrator=newmark bcs=base bc_base_region=box bc_base_lower=0,2 bc_base_upper=6,2
    bc_base_absorbing=true bc_base_components=x,y
absorbing_explicit: free time_integrator=explicit bcs=base bc_base_region=box bc_base_lower=0,2 bc_base_upper=6,2
    bc_base_absorbing=true bc_base_components=x,y
free_thrown: free load_weight_value=0,0 time_integrator=generalized_alpha
pushed: solid boundaries=p boundary_p_type=box boundary_p_lower=2,2 boundary_p_upper=3,2.5
    boundary_p_motion=0.02,-0.05 boundary_p_friction=0.3
pushed_stick: solid boundaries=p boundary_p_type=box boundary_p_lower=2,2 boundary_p_upper=3,2.5
    boundary_p_motion=0,-0.05 boundary_p_friction=stick boundary_p_contact=bilateral
pushed_augmented: solid boundaries=p boundary_p_type=box boundary_p_lower=2,2 boundary_p_upper=3,2.5
    boundary_p_motion=0,-0.05 boundary_p_method=augmented
pushed_round: solid boundaries=p boundary_p_type=sphere boundary_p_center=2.5,2.5 boundary_p_radius=0.5
    boundary_p_motion=0,-0.05 boundary_p_friction=0.2
free_rigid: solid boundaries=p boundary_p_type=box boundary_p_lower=2,2 boundary_p_upper=3,2.5 boundary_p_free=y
    boundary_p_load=0,-1e3
free_rigid_turning: solid boundaries=p boundary_p_type=box boundary_p_lower=2,2 boundary_p_upper=3,2.5
    boundary_p_free=y,rz boundary_p_load=0,-1e3 boundary_p_friction=0.5
rigid_mass: free bcs=base bc_base_region=box bc_base_lower=0,2 bc_base_upper=6,2 bc_base_components=x,y boundaries=p
    boundary_p_type=box boundary_p_lower=2,3 boundary_p_upper=3,3.5 boundary_p_free=y boundary_p_mass=100
    boundary_p_load=0,-1e3 body_b_velocity=0,0
explicit_boundary: free time_integrator=explicit boundaries=p boundary_p_type=plane boundary_p_point=0,2
    boundary_p_normal=0,1 boundary_p_friction=0.3
newmark_boundary: free boundaries=p boundary_p_type=plane boundary_p_point=0,2 boundary_p_normal=0,1
    boundary_p_friction=0.3
welded: pair
contact_penalty: pair contacts=bt contact_bt_bodies=b,top contact_bt_friction=0.3 bcs=base,side bc_side_region=box
    bc_side_lower=0,0 bc_side_upper=6,5 bc_side_components=x contact_bt_method=penalty
contact_augmented: pair contacts=bt contact_bt_bodies=b,top contact_bt_friction=0.3 bcs=base,side bc_side_region=box
    bc_side_lower=0,0 bc_side_upper=6,5 bc_side_components=x contact_bt_method=augmented
contact_barrier: pair contacts=bt contact_bt_bodies=b,top contact_bt_friction=0.3 bcs=base,side bc_side_region=box
    bc_side_lower=0,0 bc_side_upper=6,5 bc_side_components=x contact_bt_method=barrier
contact_newmark: pair contacts=bt contact_bt_bodies=b,top contact_bt_friction=0.3 time_integrator=newmark
    time_step=0.01 time_end=0.05
contact_explicit: pair contacts=bt contact_bt_bodies=b,top contact_bt_friction=0.3 time_integrator=explicit
    time_step=0.02 time_end=0.1
follow_boundary: solid body_b_lower=2,0 body_b_upper=3,1 bc_base_lower=0,0 bc_base_upper=6,0 boundaries=p
    boundary_p_type=box boundary_p_lower=2,1 boundary_p_upper=3,1.5 boundary_p_motion=0,-0.1 grid_follow=p grid_axes=y
    grid_mode=stretch track_t_at=2.5,1
follow_body: free grid_follow=b grid_axes=x,y grid_mode=shift time_integrator=explicit
poro: poro
poro_second: poro time_scheme=second
poro_error: poro time_scheme=second time_error=1e-2 time_step=1
poro_fieldsplit: poro solver=poro-fieldsplit ksp_rtol=1e-13
poro_nodes: poro bcs=base,p bc_p_region=box bc_p_lower=0,1 bc_p_upper=6,1 bc_p_components=p bc_p_value=500
poro_level: poro water_level=3 loads=weight load_weight_type=gravity load_weight_value=0,-10
poro_dry: poro water_level=1.5 water_above=dry loads=weight load_weight_type=gravity load_weight_value=0,-10
poro_column: poro body_b_upper=3,5 water_level=3 loads=weight load_weight_type=gravity load_weight_value=0,-10
poro_initial: poro body_b_initial_pressure=1e3
poro_boundary: poro surfaces=s,top surface_s_body=b surface_s_side=+x surface_s_drained=true boundaries=p
    boundary_p_type=box boundary_p_lower=2,2 boundary_p_upper=3,2.5 boundary_p_motion=0,-0.01 boundary_p_drained=true
poro_contact: poro body_b_upper=4,2 bodies=b,top body_top_region=box body_top_lower=2,2 body_top_upper=4,3 body_top_points_per_cell=3,3
    body_top_material=s contacts=bt contact_bt_bodies=b,top contact_bt_friction=0.3 surface_top_body=top time_end=100
file: file
sphere: sphere
follow_motion: solid motions=m motion_m_body=b motion_m_region=box motion_m_lower=2,1.6 motion_m_upper=3,2
    motion_m_components=x,y motion_m_value=0.1,0.05 bc_base_lower=0,0 bc_base_upper=6,0 bc_base_components=x
    grid_follow=m grid_axes=x grid_mode=shift
pushed_polygon: solid boundaries=p boundary_p_type=polygon boundary_p_vertices=2,2,3,2,3,3,2,3
    boundary_p_motion=0,-0.05
bilateral_disc: sphere bc_base_lower=0,0 bc_base_upper=6,0 bc_base_components=x boundaries=p boundary_p_type=sphere
    boundary_p_center=2.5,1.5 boundary_p_radius=0.5 boundary_p_side=inside boundary_p_contact=bilateral
    boundary_p_friction=stick boundary_p_motion=0.02,0
rescue: pair contacts=bt contact_bt_bodies=b,top contact_bt_friction=0.3 time_rescue=relaxation
space: space
space_push: space boundaries=p boundary_p_type=box boundary_p_lower=1,1,2 boundary_p_upper=2,2,2.5 boundary_p_free=z
    boundary_p_load=0,0,-1e3
space_explicit: space time_integrator=explicit time_step=1e-3 time_end=5e-3 body_b_velocity=1,0,0
"""
RESTARTED = {"poro_second": 100, "newmark_boundary": 0.02}  # with the time of the restart


def read_table():
    """Base and options of each scene, by name."""
    scenes = {}
    for entry in re.split(r"\n(?=\S)", TABLE.strip()):
        name, _, text = entry.partition(": ")
        base, *options = text.split()
        scenes[name] = BASES[base], " ".join(options)
    return scenes


SCENES = read_table()


def options_of(text):
    """Options by name; PETSc's own stay as they are."""
    pairs = (word.split("=", 1) for word in text.split())
    return {name if name.startswith("ksp_") else f"mpm_{name}": value for name, value in pairs}


def run(test, label, count, folder=None, **more):
    """A scene on some ranks, with further options; None where it fails or hangs."""
    scene, text = SCENES[label]
    folder = folder or test.folder()
    (folder / "scene.yaml").write_text(scene, encoding="utf-8")
    (folder / "points.csv").write_text(POINTS, encoding="utf-8")
    options = {**options_of(text), "mpm_quiet": None, **more}
    found = Ended(test.program, folder / "scene.yaml", count, options, folder, LIMIT)
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
        second = first and run(test, label, after, first.folder, mpm_checkpoint_every=1,
                               mpm_restart="run_checkpoint.h5")
        if second:
            compare(test, f"{label}.{before}_{after}", whole, second)


with Hostile(LIMIT) as test:
    for name, half in () if ONLY else RESTARTED.items():
        restart(test, name, half)
    for place, name in enumerate(SCENES):
        if ONLY and name not in ONLY:
            continue
        alone = run(test, name, 1)
        for number in COUNTS if FULL else COUNTS[place % 2:place % 2 + 1]:
            several = alone and run(test, name, number)
            if several:
                compare(test, f"{name}.{number}", alone, several)
