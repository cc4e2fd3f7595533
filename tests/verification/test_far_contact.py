#!/usr/bin/env python3
"""Contact that is far: results are those without it, and no face was looked at. Near, faces are.

`-log_view` counts the looks as MpmContactSearch.

Quick.
"""
import re
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import Test, difference  # noqa: E402

SCENE = Path(__file__).parent / "far.yaml"
SPACE = {"mpm_dim": 3, "mpm_grid_lower": "0,0,0", "mpm_grid_upper": "32,32,4", "mpm_grid_cells": "32,32,4",
         "mpm_body_one_lower": "0,0,0", "mpm_body_one_upper": "3,2,2", "mpm_body_one_points_per_cell": "2,2,2",
         "mpm_body_other_lower": "14,0,0", "mpm_body_other_upper": "17,2,2", "mpm_body_other_points_per_cell": "2,2,2",
         "mpm_bc_base_lower": "0,0,0", "mpm_bc_base_upper": "32,0,4", "mpm_bc_base_components": "x,y,z",
         "mpm_load_weight_value": "0,-5,0"}
EXPLICIT = {"mpm_time_integrator": "explicit", "mpm_time_end": 0.1, "mpm_time_step": 0.002}
NEWMARK = {"mpm_time_integrator": "newmark", "mpm_time_end": 0.1, "mpm_time_step": 0.02}


def boundary(**block):
    return {"mpm_boundaries": "wall", **{f"mpm_boundary_wall_{name}": value for name, value in block.items()}}


def kinds(dim):
    """Contact that is far from both blocks, at rest and on its way, and its shapes."""
    up = ",2" * (dim - 2)
    still, go = ",0" * (dim - 2), ",1" * (dim - 2)
    return {"plane": boundary(type="plane", point="31,0" + still, normal="-1,0" + still, friction=0.3),
            "box": boundary(type="box", lower="1,30" + still, upper="2,31" + go, motion="0.01,0" + still, ramp="0:0,1:1"),
            "turning": boundary(type="box", lower="5,30" + still, upper="6,31" + go, rotation="0.1" if dim == 2 else "0,0,0.1",
                                ramp="0:0,1:1"),
            "sphere": boundary(type="sphere", center="5.5,31" + up, radius=0.5),
            "bodies": {"mpm_contacts": "ab", "mpm_contact_ab_bodies": "one,other", "mpm_contact_ab_friction": 0.3}}


def looks(run):
    """How often faces were looked at."""
    found = re.search(r"^MpmContactSearch +(\d+) ", run.output, re.MULTILINE)
    return int(found.group(1)) if found else 0


def far(test, dim, label, options):
    """Numbering by bodies changes the order in which a direct solver rounds, and nothing else."""
    start = test.run(SCENE, log_view=None, **options)
    for kind, more in kinds(dim).items():
        run = test.run(SCENE, log_view=None, **options, **more)
        exact = kind != "bodies" or options.get("mpm_time_integrator") == "explicit"
        for field in ("displacement", "stress"):
            one, other = start.table(field), run.table(field)
            test.check(f"{label}.{kind}.{field}", difference(one, other), None, 0.0 if exact else 1e-12)
        test.check(f"{label}.{kind}.newton", np.abs(start.newton - run.newton).sum(), None, 0)
        test.check(f"{label}.{kind}.looks", looks(run), 0, 0)


def free(test, label, options):
    """A free body with friction far away: an unknown more in the matrix, and the same steps of the same method."""
    body = boundary(type="sphere", center="28,20", radius=0.5, friction=0.3, free="x", load="0,0", mass=10)
    start, run = test.run(SCENE, **options), test.run(SCENE, log_view=None, **options, **body)
    for field in ("displacement", "stress"):
        test.check(f"free.{label}.{field}", difference(start.table(field), run.table(field)), None, 1e-12)
    test.check(f"free.{label}.newton", np.abs(start.newton - run.newton).sum(), None, 0)
    test.check(f"free.{label}.looks", looks(run), 0, 0)


def near(test):
    """The same where they are near, but do not touch: it has to look, once a step, and to find nothing."""
    start = test.run(SCENE)
    for kind, more in {"plane": boundary(type="plane", point="0,2.2", normal="0,-1"),
                       "bodies": {**kinds(2)["bodies"], "mpm_body_other_lower": "3.3,0", "mpm_body_other_upper": "6.3,2"}}.items():
        run = test.run(SCENE, log_view=None, **more)
        test.check(f"near.{kind}.looks", looks(run), 4, None)
    test.check("near.runs", start.results.summary["steps"], 4, 4)


def ranks(test):
    """On several ranks, with blocks that belong to different ones."""
    for kind in ("plane", "bodies"):
        for label, options in (("implicit", {}), ("explicit", EXPLICIT)):
            one, two = (test.run(SCENE, ranks=count, log_view=None, **options, **kinds(2)[kind]) for count in (1, 2))
            test.check(f"ranks.{label}.{kind}", difference(one.table("stress"), two.table("stress")), None, 1e-9)
            test.check(f"ranks.{label}.{kind}.looks", looks(two), 0, 0)


def main():
    with Test() as test:
        far(test, 2, "plane_strain", {})
        far(test, 2, "explicit", EXPLICIT)
        far(test, 2, "newmark", NEWMARK)
        far(test, 3, "space", {**SPACE, "mpm_time_end": 0.5})
        far(test, 3, "space_explicit", {**SPACE, **EXPLICIT, "mpm_time_end": 0.02})
        free(test, "static", {})
        free(test, "newmark", NEWMARK)
        near(test)
        ranks(test)


if __name__ == "__main__":
    main()
