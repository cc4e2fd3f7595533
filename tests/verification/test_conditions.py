#!/usr/bin/env python3
"""Conditions on nodes and boundaries that do not follow the grid, against statics and closed forms.

Reactions are the forces of the supports on the body: with the loads they make zero.
"""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import EXAMPLES, Test, difference, example  # noqa: E402

BLOCK = Path(__file__).resolve().parent / "block.yaml"
ROLLERS = BLOCK.parent / "rollers.yaml"
RING = BLOCK.parent / "ring.yaml"
YOUNG, POISSON, DENSITY, CELL = 1e6, 0.25, 1000.0, 0.5
PENALTY = 500.0  # default of a boundary, E/h
CONSTRAINED = YOUNG * (1.0 - POISSON) / ((1.0 + POISSON) * (1.0 - 2.0 * POISSON))
BALANCE = 1e-8  # of the load
TILT = np.pi / 6.0


def text(*values):
    return ",".join(f"{value:.15g}" for value in values)


def nodes(name, lower, upper, **what):
    """Options of a condition on the nodes of a box."""
    return {f"mpm_bc_{name}_{key}": value for key, value in
            {"region": "box", "lower": text(*lower), "upper": text(*upper), **what}.items()}


def plane(name, point, normal, **what):
    """Options of a boundary that is a plane."""
    return {f"mpm_boundary_{name}_{key}": value for key, value in
            {"type": "plane", "point": text(*point), "normal": text(*normal), **what}.items()}


def reaction(run, name, row=-1, dim=2):
    return np.array([run.results.column(f"reaction_{name}_{axis}")[row] for axis in "xyz"[:dim]])


def check_vector(test, name, value, expected, scale):
    test.check(name, np.max(np.abs(np.asarray(value) - np.asarray(expected))) / scale, None, BALANCE)


SIDES = {**nodes("left", (1, 0), (1, 4), components="x"), **nodes("right", (3, 0), (3, 4), components="x")}


def prescribed_compression(test):
    """Nodes of the upper face go down by 0.4 m in one step, the sides slide: uniaxial strain, sigma = M ln f / f."""
    options = {**SIDES, **nodes("base", (0, 1), (4, 1), components="y"),
               **nodes("top", (0, 3), (4, 3), components="y", value="-0.4")}
    stretch = 0.8
    stress = CONSTRAINED * np.log(stretch) / stretch
    for shape in ("gimp", "bspline2", "bspline3", "gimp_bspline2", "linear"):
        run = test.run(BLOCK, mpm_bcs="left,right,base,top", mpm_time_step=1, mpm_shape=shape, snes_rtol=1e-13,
                       **options)
        test.near(f"prescribed_{shape}.reaction", run.results.column("reaction_top_y")[-1], 2.0 * stress, 1e-9)
        test.near(f"prescribed_{shape}.balance", run.results.column("reaction_base_y")[-1], -2.0 * stress, 1e-9)
        test.check(f"prescribed_{shape}.stress", difference(run.table("stress")[:, 1], stress), None, 1e-9)


def prescribed_total(test):
    """Values are totals whatever the steps, the ramp at time 0 and cut steps: the clamp's points move with its nodes."""
    options = {**nodes("root", (0, 0), (1.5, 4), components="x,y"), **nodes("clamp", (2.5, 0), (4, 4), components="x,y")}
    for ramp, step, way, most in (("0:0,1:1", 0.3, (0.3, 0.05), None), ("0:0.5,1:1", 0.1, (0.3, 0.05), None),
                                  ("0:1", 1, (0.3, 0.05), None), ("0:0,1:1", 1, (0.1, 0.9), 3)):
        extra = {"snes_max_it": most} if most else {}
        run = test.run(BLOCK, mpm_bcs="root,clamp", mpm_bc_clamp_ramp=ramp, mpm_bc_clamp_value=text(*way), mpm_time_step=step,
                       **options, **extra)
        last = run.results.state("last")
        held = run.results.initial["position0"][:, 0] > 2.5
        label = f"total_{ramp.replace(',', '_')}_{step}" + ("_cut" if most else "")
        test.check(f"{label}.clamp", np.max(np.abs(last["displacement"][held] - way)), None, 1e-12)
        test.check(f"{label}.cuts", run.results.summary["step_cuts"], 1 if most else 0, None if most else 0)
        test.check(f"{label}.balance", np.max(np.abs(reaction(run, "root") + reaction(run, "clamp"))) /
                   np.max(np.abs(reaction(run, "clamp"))), None, BALANCE)


def drawn_across(test):
    """Material that prescribed nodes have drawn across their plane keeps its domains: the force stays as it was."""
    options = {**nodes("root", (0, 0), (1, 4), components="x"), **nodes("pin", (1, 2), (1, 2), components="y"),
               **nodes("end", (3, 0), (4, 4), components="x", value="0.4")}
    run = test.run(BLOCK, mpm_bcs="root,pin,end", mpm_material_block_nu=0, snes_rtol=1e-12, **options)
    pull = run.results.column("reaction_end_x")
    for step in (0, -1):
        test.near(f"drawn.force_{step}", pull[step], 2.0 * YOUNG * np.log(1.2) / 1.2, 1e-9)
    test.check("drawn.balance", abs(pull[-1] + run.results.column("reaction_root_x")[-1]) / pull[-1], None, BALANCE)


def inclined_roller(test):
    """A beam on a pin and a roller at an angle: reactions by statics."""
    weight = DENSITY * 10.0 * 4.0
    for angle in (10.0, 30.0, -60.0):
        n = np.array([np.sin(np.radians(angle)), np.cos(np.radians(angle))])
        options = {**nodes("pin", (1, 1), (1, 1), components="x,y"),
                   **nodes("roller", (3, 1), (3, 1), normal=text(*(3.0 * n)))}
        runs = [test.run(BLOCK, ranks=ranks, mpm_bcs="pin,roller", mpm_time_step=1, mpm_jacobian=jacobian,
                         mpm_material_block_type="linear_elastic", mpm_loads="weight", mpm_load_weight_type="gravity",
                         mpm_load_weight_value="0,-10", snes_rtol=1e-13, mpm_stabilization_ghost="off",
                         **options)
                for ranks, jacobian in ((1, "local"), (2, "matfree"), (4, "coloring"))]
        support = weight / 2.0 / n[1]
        for k, run in enumerate(runs):
            label = f"roller_{angle:g}_{k}"
            check_vector(test, f"{label}.roller", reaction(run, "roller"), support * n, weight)
            check_vector(test, f"{label}.pin", reaction(run, "pin"), (-support * n[0], 0.5 * weight), weight)
            test.near(f"{label}.along", run.results.column("reaction_roller_n")[-1], support, BALANCE)
            test.check(f"{label}.same", difference(runs[0].table("displacement"), run.table("displacement")), None, 1e-9)


def two_rollers(test):
    """Two rollers across each other hold what two components hold; an axis as normal is that component. Without ghost
    penalty: components make a wall, beyond which there is no edge of the material, and rollers none."""
    value, c, s = np.array([0.05, -0.2]), np.cos(TILT), np.sin(TILT)
    base = {**nodes("base", (0, 1), (4, 1), components="x,y"), "mpm_stabilization_ghost": "off"}
    plain = test.run(BLOCK, mpm_bcs="base,top", **base,
                     **nodes("top", (0, 3), (4, 3), components="x,y", value=text(*value)))
    turned = test.run(BLOCK, mpm_bcs="base,one,two", **base,
                      **nodes("one", (0, 3), (4, 3), normal=text(c, s), value=text(value @ (c, s))),
                      **nodes("two", (0, 3), (4, 3), normal=text(-s, c), value=text(value @ (-s, c))))
    skew = test.run(BLOCK, mpm_bcs="base,one,two", **base,
                    **nodes("one", (0, 3), (4, 3), normal=text(c, s), value=text(value @ (c, s))),
                    **nodes("two", (0, 3), (4, 3), components="x", value=text(value[0])))
    scale = np.max(np.abs(reaction(plain, "top")))
    for label, run in (("across", turned), ("skew", skew)):
        test.check(f"rollers_{label}.displacement", difference(plain.table("displacement"), run.table("displacement")),
                   None, 1e-9)
    check_vector(test, "rollers_across.reaction", reaction(turned, "one") + reaction(turned, "two"),
                 reaction(plain, "top"), scale)
    check_vector(test, "rollers_skew.reaction",
                 reaction(skew, "one") + (skew.results.column("reaction_two_x")[-1], 0.0), reaction(plain, "top"), scale)
    test.check("rollers_across.direction", abs(reaction(turned, "one") @ (-s, c)) / scale, None, 1e-12)


def rotated_body(test):
    """A block and its supports turned by 30 degrees: statics, and the stresses of the upright one.

    Nodes hold as steps of the grid would, so the order is one; the penalty's planes stand where the block ends.
    """
    normal, down = np.array([np.sin(TILT), np.cos(TILT)]), np.array([np.cos(TILT), -np.sin(TILT)])
    errors = []
    for refine, ranks in ((1, 1), (2, 2), (2, 1)):
        run = test.run(ROLLERS, ranks=ranks, mpm_grid_refine=refine, mpm_time_step=1, mpm_quiet=None,
                       **({"mpm_solver": "amg"} if ranks == 1 and refine == 2 else {}))
        weight = 10.0 * run.table("mass").sum()
        place = run.table("position0", "first") - (2.0, 4.0)
        stress = np.einsum("i,pij,j->p", normal, run.table("stress")[:, [[0, 3], [3, 1]]], normal) / 20e3
        errors.append(np.mean(np.abs(stress + np.cos(TILT) * (2.0 - place @ normal))) / (2.0 * np.cos(TILT)))
        label = f"rotated_{refine}_on_{ranks}"
        check_vector(test, f"{label}.slope", reaction(run, "slope"), weight * np.cos(TILT) * normal, weight)
        check_vector(test, f"{label}.stop", reaction(run, "stop"), -weight * np.sin(TILT) * down, weight)
    test.check("rotated.error", errors[1], None, 0.1)
    test.check("rotated.order", np.log2(errors[0] / errors[1]), 0.8, None)
    test.check("rotated.solvers", abs(errors[2] / errors[1] - 1.0), None, 0.05)
    fine = [test.check_example(f"incline_{refine}", test.run(example("incline"), mpm_grid_refine=refine, mpm_time_step=1,
                                                             mpm_quiet=None), "incline") for refine in (2, 4)]
    test.check("incline.order", np.log2(fine[0]["stress_across"] / fine[1]["stress_across"]), 0.8, None)


def penalty_compression(test):
    """A plate comes down by 0.4 m in steps on a block between frictionless planes: uniform stress, depth p h/(PENALTY E)."""
    for dim, ranks, more in ((2, 1, {}), (2, 2, {"mpm_jacobian": "matfree"}), (2, 4, {"snes_max_it": 2, "mpm_time_step": 1}),
                             (3, 2, {"mpm_jacobian": "coloring", "mpm_time_step": 0.5})):
        tail = (0,) * (dim - 2)
        options = {**plane("floor", (0, 1) + tail, (0, 1) + tail),
                   **plane("plate", (0, 3) + tail, (0, -1) + tail, motion=text(*((0, -0.4) + tail)))}
        if dim == 2:
            options.update(SIDES, mpm_bcs="left,right")
        else:
            whole = {"lower": "0,0,0", "upper": "4,4,1"}
            options.update({f"mpm_grid_{key}": value for key, value in whole.items()}, mpm_dim=3, mpm_grid_cells="8,8,2",
                           mpm_body_block_lower="1,1,0", mpm_body_block_upper="3,3,1",
                           mpm_body_block_points_per_cell="2,2,2", mpm_bcs="left,right,ends",
                           **nodes("left", (1, 0, 0), (1, 4, 1), components="x"),
                           **nodes("right", (3, 0, 0), (3, 4, 1), components="x"),
                           **nodes("ends", (0, 0, 0), (4, 4, 1), components="z"))
        run = test.run(BLOCK, ranks=ranks, mpm_boundaries="floor,plate", snes_rtol=1e-12, **options, **more)
        label = f"penalty_{dim}d_on_{ranks}"
        depth = run.results.column("depth_floor")[-1]
        stretch = (2.0 - 0.4 + 2.0 * depth) / 2.0
        stress = CONSTRAINED * np.log(stretch) / stretch
        force = 2.0 * stress
        test.near(f"{label}.depth", depth, -stress * CELL / (PENALTY * YOUNG), 1e-8)
        test.check(f"{label}.stress", difference(run.table("stress")[:, 1], stress), None, 1e-8)
        check_vector(test, f"{label}.plate", reaction(run, "plate", dim=dim), (0, force) + tail, abs(force))
        check_vector(test, f"{label}.floor", reaction(run, "floor", dim=dim), (0, -force) + tail, abs(force))
        if "snes_max_it" in more:
            test.check(f"{label}.cuts", run.results.summary["step_cuts"], 1, None)
    stiff = test.run(BLOCK, mpm_boundaries="floor,plate", mpm_bcs="left,right", mpm_time_step=1, **SIDES,
                     **plane("floor", (0, 1), (0, 1), penalty="5e4"),
                     **plane("plate", (0, 3), (0, -1), motion="0,-0.4", penalty="5e4"))
    test.near("penalty_stiffer.depth", stiff.results.column("depth_floor")[-1], depth / 100.0, 0.02)


def free_sides(test):
    """The same with free sides: points that straddle cells, uniform stress, E/(1 - nu^2) ln f over the widened block."""
    modulus = YOUNG / (1.0 - POISSON**2)
    for shape, ranks in (("gimp", 1), ("gimp_bspline2", 2)):
        run = test.run(BLOCK, ranks=ranks, mpm_shape=shape, mpm_boundaries="floor,plate", mpm_bcs="left", snes_rtol=1e-12,
                       mpm_stabilization_ghost="off", **nodes("left", (1, 0), (1, 4), components="x"),
                       **plane("floor", (0, 1), (0, 1)), **plane("plate", (0, 3), (0, -1), motion="0,-0.4"))
        depth = run.results.column("depth_floor")[-1]
        log_y = np.log((2.0 - 0.4 + 2.0 * depth) / 2.0)
        log_x = -POISSON / (1.0 - POISSON) * log_y
        stress, force = modulus * log_y / np.exp(log_x + log_y), 2.0 * modulus * log_y / np.exp(log_y)
        label = f"free_{shape}"
        test.check(f"{label}.stress", difference(run.table("stress")[:, 1], stress), None, 1e-8)
        test.check(f"{label}.lateral", np.max(np.abs(run.table("stress")[:, 0])) / abs(stress), None, 1e-8)
        test.near(f"{label}.force", run.results.column("reaction_plate_y")[-1], force, 1e-8)
        # the area of contact is that of the last step's start
        before = np.log((2.0 - 0.36 + 2.0 * run.results.column("depth_floor")[-2]) / 2.0)
        area = 2.0 * np.exp(-POISSON / (1.0 - POISSON) * before)
        test.near(f"{label}.depth", depth, -force / area * CELL / (PENALTY * YOUNG), 1e-8)


def stick(test):
    """What sticks keeps its slip: one step or four, and a plane that carries a block along."""
    weight = {"mpm_loads": "push", "mpm_load_push_type": "force", "mpm_load_push_region": "all",
              "mpm_load_push_value": "1e4,-2e4"}
    far = []
    for step in (1.0, 0.25):
        run = test.run(BLOCK, mpm_time_step=step, mpm_boundaries="floor", mpm_tracks="all", mpm_track_all_region="all",
                       **plane("floor", (0, 1), (0, 1), friction="stick", contact="bilateral", penalty=1), **weight)
        far.append(run.results.column("track_all_ux")[-1])
        check_vector(test, f"stick_{step}.reaction", reaction(run, "floor"), (-1e4, 2e4), 2e4)
    test.near("stick.steps", far[1], far[0], 0.05)
    test.check("stick.slip", far[0], 1e4 * CELL / (2.0 * YOUNG), None)
    run = test.run(BLOCK, ranks=2, mpm_time_step=0.25, mpm_boundaries="floor",
                   **plane("floor", (0, 1), (0, 1), friction="stick", contact="bilateral", motion="0.3,0.2", ramp="0:0.5,1:1"))
    test.check("stick.carried", np.max(np.abs(run.table("displacement") - (0.3, 0.2))), None, 1e-9)


def bowl(test):
    """A block in a round bowl, a disc between two polygons: the boundaries carry the weight."""
    weight = {"mpm_loads": "weight", "mpm_load_weight_type": "gravity", "mpm_load_weight_value": "0,-10"}
    total = 10.0 * DENSITY * 4.0
    radius = np.hypot(1.0, 1.0)
    runs = [test.run(BLOCK, ranks=ranks, mpm_boundaries="bowl", mpm_boundary_bowl_type="sphere",
                     mpm_boundary_bowl_center="2,2", mpm_boundary_bowl_radius=radius, mpm_boundary_bowl_side="inside",
                     mpm_boundary_bowl_friction="stick", mpm_time_step=0.25, **weight) for ranks in (1, 2, 4)]
    for run in runs:
        check_vector(test, "bowl.reaction", reaction(run, "bowl"), (0.0, total), total)
        test.check("bowl.same", difference(runs[0].table("displacement"), run.table("displacement")), None, 1e-8)
    run = test.run(BLOCK, mpm_boundaries="ledge", mpm_boundary_ledge_type="polygon",
                   mpm_boundary_ledge_vertices="0,0,4,0,4,1,0,1", mpm_boundary_ledge_friction="stick", **weight)
    check_vector(test, "ledge.reaction", reaction(run, "ledge"), (0.0, total), total)


def turned_cup(test):
    """A block that sticks to the inside of a box or a polygon turns with it as one, its corners too, which stand out of their domains then."""
    turn = np.array([[0.0, -1.0], [1.0, 0.0]])  # by 90 degrees
    shapes = {"box": {"type": "box", "lower": "1,1", "upper": "3,3"}, "polygon": {"type": "polygon", "vertices": "1,1,3,1,3,3,1,3"}}
    for name, what in shapes.items():
        for contact in ("unilateral", "bilateral"):
            options = {"side": "inside", "friction": "stick", "contact": contact, "rotation": 90, "ramp": "0:0,1:1", **what}
            for shape in ("gimp", "gimp_bspline2"):
                run = test.run(BLOCK, mpm_time_step=0.01, mpm_shape=shape, mpm_boundaries="cup",
                               **{f"mpm_boundary_cup_{key}": value for key, value in options.items()})
                arm = run.results.initial["position0"] - 2.0
                error = np.max(np.abs(run.table("displacement") - (arm @ turn.T - arm)))
                test.check(f"cup.{name}_{contact}_{shape}", error, None, 1e-7)


def closing_ring(test):
    """A disc in a ring that closes by a tenth and moves: 2 (lambda + mu) ln f / f^2, stuck or not, whatever the steps, over a
    restart; and a slab in a cylinder, between two planes. Little friction holds the smooth one against turning: without any its
    residual can fall no further than the grid's share in a moment, some 1e-6."""
    motion, stretch, errors = np.array([0.1, 0.05]), 0.9, {}
    stress = YOUNG / ((1.0 + POISSON) * (1.0 - 2.0 * POISSON)) * np.log(stretch) / stretch**2
    cases = {"one_step": (1, {"mpm_time_step": 1}), "coarse": (1, {}), "fine": (2, {"mpm_grid_refine": 2}), "finest": (2, {"mpm_grid_refine": 4}),
             "on_4": (4, {}), "smooth": (1, {"mpm_boundary_ring_friction": 0.1})}
    runs = {}
    for label, (ranks, options) in cases.items():
        runs[label] = run = test.run(RING, ranks=ranks, snes_rtol=1e-12, **options)
        errors[label] = np.mean(np.abs(run.table("stress")[:, :2] / stress - 1.0))
        # distances from the ring that the lattice's steps keep are stretched from step to step: one step knows nothing of it
        test.check(f"ring_{label}.stress", errors[label], None, 0.03 if label == "one_step" else 0.012)
        test.check(f"ring_{label}.balance", np.max(np.abs(reaction(run, "ring"))) / abs(stress), None, BALANCE)
        if label != "smooth":  # that may turn
            away = run.table("displacement") - motion - (stretch - 1.0) * (run.table("position0", "first") - 2.0)
            test.check(f"ring_{label}.displacement", np.max(np.abs(away)), None, 0.0025 if label == "one_step" else 0.0011)
    test.check("ring.falls", errors["finest"] / errors["fine"], None, 0.81)  # the coarse one has a radius of only two cells
    test.check("ring.same", difference(runs["coarse"].table("displacement"), runs["on_4"].table("displacement")), None, 1e-8)
    half = test.run(RING, snes_rtol=1e-12, mpm_time_end=0.5, mpm_checkpoint_every=1)
    rest = test.run(RING, snes_rtol=1e-12, mpm_restart=half.prefix + "_checkpoint.h5")
    test.check("ring.restart", difference(runs["coarse"].table("displacement"), rest.table("displacement")), None, 1e-8)
    disc, slab = (test.run(scene, ranks=ranks, snes_rtol=1e-12, mpm_stabilization_ghost="off")
                  for scene, ranks in ((RING, 1), (RING.parent / "ring3d.yaml", 2)))
    test.check("ring.slab", difference(disc.table("displacement"), slab.table("displacement")[:, :2]), None, 1e-8)


def inclined_plane(test):
    """The example, on several ranks, stuck and against a stop."""
    for scene in ("case.yaml", "stick.yaml"):
        runs = [test.run(EXAMPLES / "incline" / scene, ranks=ranks, mpm_quiet=None) for ranks in (1, 2, 4)]
        for ranks, run in zip((1, 2, 4), runs):
            label = f"incline_{scene[:-5]}_on_{ranks}"
            test.check_example(label, run, "incline")
            test.check(f"{label}.same", difference(runs[0].table("displacement"), run.table("displacement")), None, 1e-8)


def pressed_to_wall(test):
    """A layer thinner than a cell on a plane of nodes inside the grid, pressed to it: the plane carries all of the load."""
    thickness, pressure = 0.125, 1e3
    layer = {"mpm_body_block_upper": text(1.0 + thickness, 3.0), "mpm_body_block_points_per_cell": "4,2",
             "mpm_loads": "push", "mpm_load_push_type": "traction", "mpm_load_push_region": "box",
             "mpm_load_push_lower": text(1.0 + thickness, 1.0), "mpm_load_push_upper": text(1.0 + thickness, 3.0),
             "mpm_load_push_face": "+x", "mpm_load_push_value": text(-pressure, 0.0), "mpm_time_step": 1}
    held = {**nodes("wall", (1, 0), (1, 4), components="x"), **nodes("all", (0, 0), (4, 4), components="y")}
    for shape in ("gimp", "gimp_bspline2"):
        for edge in ("linear", "open"):
            run = test.run(BLOCK, mpm_bcs="wall,all", mpm_shape=shape, mpm_shape_edge=edge, **held, **layer)
            test.near(f"pressed_{shape}_{edge}.reaction", run.results.column("reaction_wall_x")[-1], 2.0 * pressure, 1e-6)


with Test() as test:
    prescribed_compression(test)
    pressed_to_wall(test)
    prescribed_total(test)
    drawn_across(test)
    inclined_roller(test)
    two_rollers(test)
    rotated_body(test)
    penalty_compression(test)
    free_sides(test)
    stick(test)
    bowl(test)
    turned_cup(test)
    closing_ring(test)
    inclined_plane(test)
