#!/usr/bin/env python3
"""Bodies in contact with one another: uniform stress over unlike lattices of points, forces that balance, no tension, Coulomb's
friction along a flat surface, on any number of ranks and over a restart."""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import Test, difference  # noqa: E402

HERE = Path(__file__).resolve().parent
BLOCKS, SLIDING = (HERE / name for name in ("blocks.yaml", "sliding_block.yaml"))
PRESSED = {"mpm_loads": "top", "mpm_load_top_type": "traction", "mpm_load_top_region": "box", "mpm_load_top_lower": "0,2",
           "mpm_load_top_upper": "2,2.125", "mpm_load_top_face": "+y", "mpm_load_top_value": "0,-10e3"}
PRESSURE, WIDTH = 10e3, 2.0


def patch(test):
    """The blocks are pressed together: the stress is uniform, whatever the method, and the force that of the load."""
    runs = {}
    for label, ranks, options in (("penalty", 1, {}), ("on_2", 2, {}), ("on_3", 3, {}), ("on_4", 4, {}),
                                  ("barrier", 1, {"mpm_contact_ab_method": "barrier"}),
                                  ("augmented", 2, {"mpm_contact_ab_method": "augmented", "mpm_contact_ab_penalty": 20}),
                                  ("rough", 2, {"mpm_contact_ab_friction": 0.3}), ("stick", 1, {"mpm_contact_ab_friction": "stick"}),
                                  ("smooth_shape", 2, {"mpm_shape": "gimp_bspline2"}),
                                  ("turned", 1, {"mpm_contact_ab_bodies": "high,low"})):
        run = runs[label] = test.run(BLOCKS, ranks=ranks, **PRESSED, **options)
        test.check(f"patch_{label}.stress", difference(run.table("stress")[:, 1], -PRESSURE), None, 1e-8)
        test.check(f"patch_{label}.shear", np.max(np.abs(run.table("stress")[:, 3])) / PRESSURE, None, 1e-8)
        sign = 1.0 if label == "turned" else -1.0
        test.near(f"patch_{label}.force", run.results.column("force_ab_y")[-1], sign * PRESSURE * WIDTH, 1e-10)
    spline = test.run(BLOCKS, **{**PRESSED, "mpm_shape": "bspline2", "mpm_load_top_place": "face", "mpm_load_top_value": "0,-100"})
    test.check("patch_spline.stress", difference(spline.table("stress")[:, 1], -100.0), None, 1e-3)
    low, down = runs["augmented"].table("material") == 0, -runs["augmented"].table("displacement")[:, 1]
    # no depth: what the half points between the faces' middles and the nearest centres give
    test.near("patch_augmented.depth", down[~low].min() - down[low].max(), PRESSURE * (0.0625 / 1e6 + 0.03125 / 4e6), 1e-6)
    for label in ("on_2", "on_3", "on_4"):
        test.check(f"patch_{label}.same", difference(runs["penalty"].table("displacement"), runs[label].table("displacement")),
                   None, 1e-9)


def unlike(test):
    """Blocks that were drawn to touch do, wherever their lattices of points end; a soft one slides on soft ground."""
    for name, height, low, high in (("apart", 1.075, 2, 3), ("overlap", 1.125, 3, 2), ("hair", 1.001, 1, 4)):
        run = test.run(BLOCKS, **{**PRESSED, "mpm_body_low_upper": f"2,{height}", "mpm_body_high_lower": f"0,{height}",
                                  "mpm_body_low_points_per_cell": f"{low},{low}", "mpm_body_high_points_per_cell": f"{high},{high}"})
        test.check(f"unlike_{name}.stress", difference(run.table("stress")[:, 1], -PRESSURE), None, 1e-8)
        test.near(f"unlike_{name}.force", run.results.column("force_ab_y")[-1], -PRESSURE * WIDTH, 1e-10)
    run = test.run(SLIDING, mpm_material_soft_E=2e6, mpm_material_hard_E=2e6, mpm_output_every=0)
    test.check("unlike_soft.force", np.max(np.abs(run.results.column("force_ab_y") / run.results.column("force_ab_y")[0] - 1)), None, 1e-5)


def parted(test):
    """The upper block is lifted: nothing holds it, and nothing of the lower one moves."""
    lift = {"mpm_bcs": "base,left,right,lift", "mpm_bc_lift_region": "box", "mpm_bc_lift_lower": "0,2", "mpm_bc_lift_upper": "2,3",
            "mpm_bc_lift_components": "y", "mpm_bc_lift_value": 0.2, "mpm_bc_lift_ramp": "0:0,1:1"}
    for method in ("penalty", "barrier"):
        run = test.run(BLOCKS, mpm_contact_ab_method=method, **lift)
        test.check(f"parted_{method}.force", np.max(np.abs(run.results.column("force_ab_y"))), None,
                   1e-6 if method == "penalty" else 1.0)
    low = run.table("material") == 0
    run = test.run(BLOCKS, mpm_stabilization_ghost="off", **lift)
    test.check("parted.low", np.max(np.abs(run.table("displacement")[low])), None, 1e-12)


def let_go(test):
    """Blocks that were drawn to touch, without a load, stay where they are in a step with inertia: a barrier sets no energy free."""
    run = test.run(BLOCKS, mpm_contact_ab_method="barrier", mpm_time_integrator="newmark", mpm_time_end=0.1, mpm_time_step=0.02)
    test.check("let_go.way", np.abs(run.table("displacement")).max(), None, 1e-12)


def slide(test):
    """The friction of a stiff block that is pushed along: mu N; the same on all ranks, and after a restart on others."""
    alone = test.run(SLIDING, mpm_checkpoint_every=10)
    normal, friction = alone.results.column("force_ab_y")[-1], -alone.results.column("force_ab_x")[-1]
    test.near("slide.friction", friction, 0.3 * normal, 1e-4)
    test.near("slide.weight", normal, 10.0 * 1000.0 * alone.table("volume")[alone.table("material") == 1].sum(), 1e-3)
    test.near("slide.balance", alone.results.column("reaction_push_x")[-1], friction, 1e-6)
    test.check("slide.newton", np.mean(alone.newton), None, 6)
    for ranks in (2, 4):
        run = test.run(SLIDING, ranks=ranks)
        test.near(f"slide_on_{ranks}.friction", run.results.column("force_ab_x")[-1], -friction, 1e-9)
        test.check(f"slide_on_{ranks}.same", difference(alone.table("displacement"), run.table("displacement")), None, 1e-9)
    run = test.run(SLIDING, ranks=2, mpm_restart=alone.folder / "slide_checkpoint_000010.h5")
    test.check("slide_again.same", difference(alone.table("displacement"), run.table("displacement")), None, 1e-10)


with Test() as check:
    patch(check)
    unlike(check)
    parted(check)
    let_go(check)
    slide(check)
