#!/usr/bin/env python3
"""Contacts of saturated bodies: those that are open let water through and those that are sealed do not, whatever the method and the
form of the Jacobian; what has parted lets none through; friction of a body on saturated ground; on any number of ranks and over a
restart."""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import Test, difference  # noqa: E402

HERE = Path(__file__).resolve().parent
BLOCKS, SLIDING = (HERE / name for name in ("wet_blocks.yaml", "sliding_block.yaml"))
FACE, TOP, BELOW, LOAD = 2.125, 4.125, 10e3, 20e3  # m; pressure at the base, load on the top, Pa
LOW, HIGH = 1e-10, 4e-10  # mobilities, m2/(Pa s)
RATE = BELOW / (FACE / LOW + (TOP - FACE) / HIGH)  # m/s


def steady(y):
    """Pressure of water that rises through both."""
    return np.where(y < FACE, BELOW - RATE / LOW * y, RATE / HIGH * (TOP - y))


def passes(test):
    """The resistances of the blocks are one behind the other, and nothing stays in between."""
    alone = test.run(BLOCKS, mpm_checkpoint_every=8)
    y = alone.table("position")[:, 1] * TOP / alone.table("position")[:, 1].max()
    test.check("open.pressure", np.max(np.abs(alone.table("pressure") - steady(y))) / BELOW, None, 0.01)
    history = alone.results
    rate = {name: (history.column(f"outflow_{name}")[-1] - history.column(f"outflow_{name}")[-2]) / history.column("dt")[-1]
            for name in ("top", "bottom")}
    test.near("open.top", rate["top"], RATE, 2e-3)
    test.near("open.bottom", rate["bottom"], -RATE, 2e-3)
    test.near("open.force", history.column("force_ab_y")[-1], -LOAD, 1e-9)
    volume, stretch = alone.table("volume"), np.linalg.det(alone.table("F").reshape(-1, 3, 3))
    lost = np.sum(volume / stretch * (1 - np.trace(alone.table("F").reshape(-1, 3, 3) - np.eye(3), axis1=1, axis2=2)) - volume / stretch)
    test.near("open.lost", history.column("outflow_top")[-1] + history.column("outflow_bottom")[-1], lost, 1e-8)
    several = test.run(BLOCKS, ranks=3)
    test.check("open_on_3.same", difference(alone.table("pressure"), several.table("pressure")), None, 1e-8)
    again = test.run(BLOCKS, ranks=2, mpm_restart=min(alone.folder.glob("blocks_checkpoint_*16.h5")))
    test.check("open_again.same", difference(alone.table("pressure"), again.table("pressure")), None, 1e-9)
    return alone


def sealed(test):
    """Each block has the pressure at its own drain."""
    run = test.run(BLOCKS, mpm_contact_ab_water="sealed")
    pressure, low = run.table("pressure"), run.table("material") == 0
    test.check("sealed.low", np.max(np.abs(pressure[low] - BELOW)) / BELOW, None, 1e-4)
    test.check("sealed.high", np.max(np.abs(pressure[~low])) / BELOW, None, 1e-4)


def forms(test):
    """Other forms of the Jacobian, other methods of contact, other solvers."""
    short = {"mpm_time_end": 1000, "mpm_time_scheme": "euler"}
    base = test.run(BLOCKS, **short).table("pressure")
    for name, options, bound in (("coloring", {"mpm_jacobian": "coloring"}, 1e-9), ("dense", {"mpm_jacobian": "dense"}, 1e-9),
                                 ("matfree", {"mpm_jacobian": "matfree", "mpm_solver": "poro-fieldsplit", "ksp_rtol": 1e-10}, 1e-7),
                                 ("turned", {"mpm_contact_ab_bodies": "high,low"}, 1e-9),
                                 ("barrier", {"mpm_contact_ab_method": "barrier"}, 2e-3),
                                 ("augmented", {"mpm_contact_ab_method": "augmented"}, 1e-4),
                                 ("rough", {"mpm_contact_ab_friction": 0.3}, 1e-4)):
        run = test.run(BLOCKS, **short, **options)
        test.check(f"{name}.same", difference(base, run.table("pressure")), None, bound)
        test.check(f"{name}.newton", np.max(run.newton), None, 15 if name == "barrier" else 5)


def parted(test):
    """The upper block is lifted: from then on water has no way into it."""
    lift = {"mpm_bcs": "base,left,right,lift", "mpm_bc_lift_region": "box", "mpm_bc_lift_lower": "0,4", "mpm_bc_lift_upper": "1,5",
            "mpm_bc_lift_components": "y", "mpm_bc_lift_value": 0.05, "mpm_bc_lift_ramp": "0:0,500:1", "mpm_surface_top_traction": "0,0"}
    run = test.run(BLOCKS, **lift)
    low = run.table("material") == 0
    test.check("parted.force", np.max(np.abs(run.results.column("force_ab_y")[1:])), None, 1e-6)
    test.check("parted.high", np.max(np.abs(run.table("pressure")[~low])) / BELOW, None, 1e-3)
    test.check("parted.low", np.max(np.abs(run.table("pressure")[low] - BELOW)) / BELOW, None, 1e-3)


def slide(test):
    """A block on ground whose water drains at once slides at mu N, as on solid ground."""
    wet = test.folder() / "wet.yaml"
    text = SLIDING.read_text(encoding="utf-8").replace("density: 1000}", "density: 1000, porosity: 0.3, permeability: 1e-6}")
    text = text.replace("  dim: 2\n", "  dim: 2\n  physics: poro\n  water: {density: 0}\n  surfaces: low,high\n"
                        "  surface_low: {body: low, side: all, drained: true}\n  surface_high: {body: high, side: all, drained: true}\n")
    wet.write_text(text, encoding="utf-8")
    run = test.run(wet)
    normal, friction = run.results.column("force_ab_y")[-1], -run.results.column("force_ab_x")[-1]
    test.near("slide.friction", friction, 0.3 * normal, 1e-4)
    test.near("slide.weight", normal, 10.0 * 1000.0 * run.table("volume")[run.table("material") == 1].sum(), 1e-3)
    dry = test.run(SLIDING)
    test.check("slide.same", difference(dry.table("displacement"), run.table("displacement")), None, 1e-3)


with Test() as check:
    passes(check)
    sealed(check)
    forms(check)
    parted(check)
    slide(check)
