#!/usr/bin/env python3
"""Free flight and free fall: there is no stress at any time, and velocities stay what they are or grow as gravity has it.

Points stand on nodes, faces, in the middle of cells, on the grid's edges and a hair beside them: a node there has a gradient
and next to no mass (Brackbill and Ruppel 1986, doi:10.1016/0021-9991(86)90211-1: a node's velocity is the mean of its points').
Bounds: rounding, 1e-10 of the stiffness, of the velocity and of a cell. Quick.
"""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import Test  # noqa: E402

E, SPEED = 1e5, 1.0
HERE = Path(__file__).parent
SHAPES = ("linear", "gimp", "bspline2", "bspline3", "gimp_bspline2")
PLACES = {2: ((4, 4), (9, 4.3), (14.3, 5), (19.5, 4.5), (4, 0), (9.5, 1e-12), (14.3, 12), (19 + 1e-12, 9), (0, 8), (9.2, 11.999)),
          3: ((3, 3, 2), (8, 3.3, 2.5), (3, 0, 0), (8.3, 8, 4), (13, 4, 4), (13.2, 0, 2.5))}
METHODS = {"explicit": {"integrator": "explicit", "step": 0.0125, "end": 0.5},
           "usl": {"integrator": "explicit", "update": "usl", "step": 0.0125, "end": 0.5},
           "usf": {"integrator": "explicit", "update": "usf", "step": 0.0125, "end": 0.5},
           "flip": {"integrator": "explicit", "transfer": "flip", "step": 0.0125, "end": 0.5},
           "newmark": {"integrator": "newmark"}, "lumped": {"integrator": "newmark", "mass": "lumped"},
           "generalized_alpha": {"integrator": "generalized_alpha"}}


def fly(test, dim, shape, method, ranks=1, gravity=0.0, **options):
    """A run, and its largest stress over E, error of a velocity, and of a way in cells where no gravity acts."""
    table = test.folder() / "points.csv"
    if gravity:
        options.update({"mpm_loads": "weight", "mpm_load_weight_type": "gravity", "mpm_load_weight_value": f"0,{-gravity}",
                        "mpm_load_weight_ramp": "0:1"})
    rows = [",".join(repr(float(x)) for x in place) + ",0.25" for place in (PLACES[dim][:4] if gravity else PLACES[dim])
            if method != "usl" or shape == "linear" or 0.1 < place[1] < 11.9]  # next to an edge usl is not stable
    table.write_text(",".join("xyz"[:dim]) + ",volume\n" + "\n".join(rows) + "\n", encoding="utf-8")
    options.update({f"mpm_time_{key}": value for key, value in METHODS[method].items()})
    if dim == 3:
        options.update({"mpm_dim": 3, "mpm_grid_lower": "0,0,0", "mpm_grid_upper": "16,8,4", "mpm_grid_cells": "16,8,4",
                        "mpm_body_points_velocity": "1,0,0", "mpm_time_end": "0.5"})
    else:
        options.update({"mpm_bodies": "points,block", "mpm_body_block_region": "box", "mpm_body_block_lower": "26,4",
                        "mpm_body_block_upper": "28,6", "mpm_body_block_points_per_cell": "2,2",
                        "mpm_body_block_material": "s", "mpm_body_block_velocity": "1,0"})
    run = test.run(HERE / "flight.yaml", ranks, mpm_shape=shape, mpm_body_points_file=table, **options)
    states = [run.results.state(step) for step in run.results.steps]
    velocity, fall = np.eye(dim)[0] * SPEED, -np.eye(dim)[1] * gravity
    stress = max(np.max(np.abs(state["stress"])) for state in states) / E
    checked = states[:1] + states[-1:] if gravity else states  # explicit velocities are half a step behind in between
    change = max(np.max(np.abs(state["velocity"] - velocity - fall * state.time)) for state in checked) / SPEED
    if gravity:
        return stress, change
    way = max(np.max(np.abs(state["position"] - states[0]["position"] - velocity * state.time)) for state in states)
    return stress, change, way


with Test() as test:
    runs = [(2, shape, method, 1) for shape in SHAPES for method in METHODS]
    runs += [(3, "linear", method, 1) for method in ("explicit", "newmark", "generalized_alpha")] + [(3, "gimp", "newmark", 1)]
    runs += [(2, "linear", "explicit", 3), (2, "linear", "newmark", 3)]
    for dim, shape, method, ranks in runs:
        for name, value in zip(("stress", "velocity", "way"), fly(test, dim, shape, method, ranks)):
            test.check(f"{shape}.{dim}d.{method}.{ranks}.{name}", value, upper=1e-10)
    for shape in SHAPES:
        for method in ("explicit", "flip", "newmark", "generalized_alpha"):
            for name, value in zip(("stress", "velocity"), fly(test, 2, shape, method, gravity=2.0)):
                test.check(f"fall.{shape}.{method}.{name}", value, upper=1e-10)
