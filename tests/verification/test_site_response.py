#!/usr/bin/env python3
"""The soil layer of the example that is shaken from below, on rigid rock and on rock that goes on: frequency and height of the
first peaks of its amplification, by two shapes, and with
its base moved by acceleration."""
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import Test, difference, example  # noqa: E402

NAME = "site_response"

with Test() as test:
    scene = example(NAME)
    rigid = test.run(scene, mpm_quiet=None)
    test.check_example("rigid", rigid, NAME)
    test.check_example("splines", test.run(scene, mpm_quiet=None, mpm_shape="gimp_bspline2"), NAME)
    run = test.run(scene, mpm_quiet=None, options_file=scene.parent / "rock.yaml")
    test.check_example("rock", run, NAME)
    record = test.run(scene, mpm_quiet=None, mpm_bc_base_quantity="acceleration", mpm_bc_base_ramp="0:0.2,0.05:0.2,0.05:-0.2,0.1:-0.2,0.1:0",
                      mpm_bc_base_value=1, mpm_time_end=2)
    mine, other = (each.results.column("track_surface_vx")[:400] for each in (rigid, record))
    test.check("acceleration_instead_of_velocity", difference(mine, other), None, 5e-3)
