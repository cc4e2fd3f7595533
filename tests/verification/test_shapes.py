#!/usr/bin/env python3
"""Shapes of boundaries and how they move: one surface described in two ways does the same, what sticks to a surface that
turns is turned, and neither ranks nor a restart on the way change it.

Quick.
"""
import itertools
import struct
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import Test, difference  # noqa: E402

HERE = Path(__file__).resolve().parent
PUNCH, PUNCH_3D, RING, RING_3D = (HERE / f"{name}.yaml" for name in ("punch", "punch3d", "ring", "ring3d"))
SAME = 1e-9
TURNED = 1e-9  # m


def boundary(name, **what):
    return {f"mpm_boundary_{name}_{key}": value for key, value in what.items()}


def write_box(path, lower, upper, cuts):
    """A box as a binary STL file; each face is cut into cuts x cuts squares of two triangles."""
    triangles = []
    for axis, high, i, j in itertools.product(range(3), (False, True), range(cuts), range(cuts)):
        one, two = ((axis + 1) % 3, (axis + 2) % 3) if high else ((axis + 2) % 3, (axis + 1) % 3)
        square = []
        for right, up in ((0, 0), (1, 0), (1, 1), (0, 1)):
            place = [upper[axis] if high else lower[axis]] * 3
            place[one] = lower[one] + (upper[one] - lower[one]) * (i + right) / cuts
            place[two] = lower[two] + (upper[two] - lower[two]) * (j + up) / cuts
            square.append(place)
        triangles += [square[:3], [square[0], *square[2:]]]
    data = b"".join(struct.pack("<12fH", 0, 0, 0, *np.ravel(corners), 0) for corners in triangles)
    path.write_bytes(b"a box".ljust(80) + struct.pack("<I", len(triangles)) + data)


def compare(test, label, one, other):
    """Two runs: their reactions, depths and displacements."""
    for column in one.results.history:
        if column.startswith(("reaction_", "depth_")) and np.any(one.results.column(column)):
            test.check(f"{label}.{column}", difference(one.results.column(column), other.results.column(column)), None, SAME)
    test.check(f"{label}.displacement", difference(one.table("displacement"), other.table("displacement")), None, SAME)


def described_in_two_ways(test):
    """Presses and turns at once; what it does is worth comparing."""
    moves = boundary("punch", motion="0.02,-0.06", rotation=8)
    box = test.run(PUNCH, **moves, **boundary("punch", type="box", lower="0.7,1", upper="1.4,1.5"))
    test.check("box.reaction", box.results.column("reaction_punch_y")[-1], None, -1e3)
    compare(test, "box", box, test.run(PUNCH, **moves, **boundary(
        "punch", type="polygon", vertices="0.7,1,1.4,1,1.4,1.5,0.7,1.5")))

    moves = boundary("punch", motion="0.05,-0.25", rotation=-10)
    wedge = test.run(PUNCH, **moves, **boundary("punch", type="cone", tip="1.01,1.1", angle=120, radius=0.25))
    test.check("wedge.reaction", wedge.results.column("reaction_punch_y")[-1], None, -1e3)
    shoulder = 1.1 + 0.25 / np.tan(np.radians(60))
    outline = f"1.01,1.1,1.26,{shoulder:.15g},1.26,9,0.76,9,0.76,{shoulder:.15g}"
    compare(test, "wedge", wedge, test.run(PUNCH, **moves, **boundary(
        "punch", type="polygon", vertices=outline, pivot="1.01,1.1")))


def triangles(test):
    """Boxes of triangles, in units and at an origin of their own: the same box, on any number of ranks."""
    moves = boundary("punch", motion="0,0.01,-0.05", rotation="5,0,20")
    box = test.run(PUNCH_3D, **moves, **boundary("punch", type="box", lower="0.25,0.25,1", upper="0.75,0.75,1.5"))
    test.check("stl.reaction", box.results.column("reaction_punch_z")[-1], None, -1e3)
    path = test.folder() / "box.stl"
    write_box(path, (-250, -250, 0), (250, 250, 500), 4)
    stl = boundary("punch", type="stl", file=path, scale=1e-3, origin="0.5,0.5,1")
    if "this build cannot search triangles" in test.run(PUNCH_3D, status=None, **stl).errors:
        print("built without Embree: no triangles")
        return
    for ranks in (1, 3):
        compare(test, f"stl_{ranks}", box, test.run(PUNCH_3D, ranks, **moves, **stl))


def turned(test):
    """A disc and a ball in surfaces that hold them and turn: they turn as rigid bodies, without a force."""
    for label, scene, rotation, vector in (("disc", RING, "40", (0, 0, 40)), ("ball", RING_3D, "0,0,40", (0, 0, 40))):
        still = boundary("ring", growth=0, motion="0,0" if label == "disc" else "0,0,0", rotation=rotation)
        run = test.run(scene, **still, snes_rtol=1e-12)
        start = run.results.initial["position0"]
        centre, angle = np.full(start.shape[1], 2.0), np.radians(vector[2])
        arm = start[:, :2] - centre[:2]
        moved = arm @ np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]]) - arm
        test.check(f"{label}.turned", np.max(np.abs(run.table("displacement")[:, :2] - moved)), None, TURNED)


def tables_and_restarts(test):
    """A table is what a ramp says; a run that goes on from its middle ends as one that went through."""
    path = test.folder() / "motion.csv"
    path.write_text("time,uy,rz\n0,0,0\n0.5,-0.03,4\n1,-0.06,8\n", encoding="utf-8")
    shape = boundary("punch", type="box", lower="0.7,1", upper="1.4,1.5")
    ramp = test.run(PUNCH, **shape, **boundary("punch", motion="0,-0.06", rotation=8), mpm_checkpoint_every=2)
    compare(test, "table", ramp, test.run(PUNCH, 2, **shape, **boundary("punch", motion_table=path)))
    rest = test.run(PUNCH, 3, **shape, **boundary("punch", motion="0,-0.06", rotation=8),
                    mpm_restart=ramp.folder / "punch_checkpoint_000002.h5")
    for axis in "xy":
        column = f"reaction_punch_{axis}"
        test.near(f"restart.{column}", rest.results.column(column)[-1], ramp.results.column(column)[-1], SAME)
    test.check("restart.displacement", difference(ramp.table("displacement"), rest.table("displacement")), None, SAME)


def coarse(test):
    """The first lines name a boundary of few cells, and no other."""
    for radius, lines in ((0.4, 1), (0.8, 0)):
        run = test.run(PUNCH, **boundary("punch", type="sphere", center=f"1,{1 + radius}", radius=radius, motion="0,-0.01"),
                       mpm_quiet="false")
        test.check(f"coarse.{radius}", run.output.count("boundary punch is sampled coarsely"), lines, lines)


def main():
    with Test() as test:
        coarse(test)
        described_in_two_ways(test)
        triangles(test)
        turned(test)
        tables_and_restarts(test)


if __name__ == "__main__":
    main()
