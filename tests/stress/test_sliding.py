#!/usr/bin/env python3
"""A body that slides by 0.37 cells a step: grid lines pass through it at every phase, and its stress must not notice.

`carried`: every node is prescribed. Each column of nodes has its own ramp: first the columns close in on the first
one, a uniform strain; then all move alike. The strain no longer changes, so that the stress may only gather rounding,
at most eps times the distance in cells a step: 1e-10 of it is asked for.

`pushed`: only the nodes under the body are driven, sideways; a traction on its top, with nu = 0, has made its stress
uniform before. The domains of `gimp` tile the body, so that uniform stress is the discrete equilibrium as well, and
what may be added a step is what Newton leaves: its relative tolerance, 1e-8 of a residual of the order of the stress
that the nodes' step makes while the rest stands still, 0.37 E. A step's share of noise is 1e-8 E; errors add up at
worst. `drag` is the same without traction.

With --full: 200 steps, all shapes, 2 ranks.
"""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent))
from hostile import Hostile  # noqa: E402
from talus_test import FULL  # noqa: E402

LIMIT = 120.0  # s, for one run
PHASE = 0.37  # cells a step
E, CLOSED, PRESSURE = 1e6, 0.05, 1e5  # Pa; engineering strain; Pa
SHAPES = ("linear", "gimp", "bspline2", "bspline3", "gimp_bspline2")

SCENE = """
mpm:
  dim: 2
  grid: {{lower: "0,0", upper: "{upper},6", cells: "{upper},6"}}
  materials: soil
  material_soil: {{type: hencky, E: 1e6, nu: {nu}, density: 1000}}
  bodies: block
  body_block: {{region: box, lower: "2,0", upper: "6,3", points_per_cell: "2,2", material: soil}}
  bcs: {names}
{blocks}
  time: {{end: {end}, step: 1}}
  tracks: top
  track_top: {{at: "6,3", nearest: 1}}
  quiet: true
  output: {{prefix: run, every: 1}}
"""
TRACTION = """
  loads: cap
  load_cap: {type: traction, region: box, lower: "2,3", upper: "6,3", value: "0,-1e5", ramp: "0:0,1:1"}
"""


def width(steps):
    """Cells along x: the body's way and some more."""
    return int(np.ceil(PHASE * steps)) + 10


def carried(steps, walls):
    """Every column of nodes on its own ramp; as boxes they are walls to the shape functions, as polygons not."""
    upper = width(steps)
    blocks, names = ["  bc_floor: {components: \"y\"}"], ["floor"]
    for i in range(upper + 1):
        closed = -CLOSED * i
        region = (f'region: box, lower: "{i},0", upper: "{i},6"' if walls else
                  f'region: polygon, vertices: "{i - 0.1},-1,{i + 0.1},-1,{i + 0.1},7,{i - 0.1},7"')
        names.append(f"c{i}")
        blocks.append(f"  bc_c{i}: {{{region}, components: \"x\", value: \"1\", "
                      f"ramp: \"0:0,1:{closed!r},{steps + 1}:{closed + PHASE * steps!r}\"}}")
    return SCENE.format(upper=upper, names=",".join(names), blocks="\n".join(blocks), end=steps + 1, nu=0.3)


def pushed(steps, traction):
    """The row of nodes under the body, driven sideways and held in height."""
    upper = width(steps)
    block = (f'  bc_base: {{region: box, lower: "0,0", upper: "{upper},0", components: "x,y", value: "1,0", '
             f'ramp: "0:0,1:0,{steps + 1}:{PHASE * steps!r}"}}')
    return SCENE.format(upper=upper, names="base", blocks=block + (TRACTION if traction else ""), end=steps + 1, nu=0)


def noise(run):
    """Largest difference of any stress component at any step from that after the first one; the largest stress, Pa."""
    results = run.results
    start = results.state(1)["stress"]
    worst = max(np.max(np.abs(results.state(step)["stress"] - start)) for step in results.steps if step > 0)
    return worst, np.max(np.abs(start))


def moved(test, label, run, steps):
    """Every point has gone the whole way."""
    results = run.results
    way = results.state("last")["position"][:, 0] - results.state(1)["position"][:, 0]
    test.check(f"{label}.way_error", np.max(np.abs(way - PHASE * steps)), None, 1e-6)


def carry(test, label, steps, walls, **options):
    run = test.ends(label, carried(steps, walls), **options)
    if not run.completed:
        return
    change, size = noise(run)
    # uniform: ln(1 - CLOSED) along x
    expected = E * (1.0 - 0.3) / (1.3 * 0.4) * np.log(1.0 - CLOSED) / (1.0 - CLOSED)
    test.near(f"{label}.stress", run.results.state(1)["stress"][:, 0].max(), expected, relative=1e-9)
    test.check(f"{label}.noise", change / size, None, 1e-10)
    moved(test, label, run, steps)


def push(test, label, steps, traction, **options):
    run = test.ends(label, pushed(steps, traction), **options)
    if not run.completed:
        return
    change, size = noise(run)
    if traction:
        # nominal stress -p: E ln(s)/s = -p, Cauchy's is -p since nu = 0
        test.near(f"{label}.stress", size, PRESSURE, relative=1e-6)
    test.check(f"{label}.noise_over_E", change / E, None, 1e-8 * steps)
    moved(test, label, run, steps)


with Hostile(LIMIT) as test:
    steps = 200 if FULL else 40
    for shape in SHAPES if FULL else ("linear", "gimp", "gimp_bspline2"):
        carry(test, f"carried.{shape}", steps, False, mpm_shape=shape)
        carry(test, f"carried_between_walls.{shape}", steps, True, mpm_shape=shape)
    for ranks in (1, 2, 4) if FULL else (1, 2):
        if ranks > 1:
            carry(test, f"carried.gimp.{ranks}_ranks", steps, False, ranks=ranks)
        push(test, f"pushed.{ranks}_ranks", steps, True, ranks=ranks)
        push(test, f"drag.{ranks}_ranks", steps, False, ranks=ranks)
    push(test, "pushed.penalty", steps, True, mpm_stabilization_ghost="1e-3")
    push(test, "pushed.amg", steps, True, mpm_solver="amg")
    for shape in SHAPES:
        push(test, f"drag.{shape}", steps, False, mpm_shape=shape)
