#!/usr/bin/env python3
"""What a scene does not use costs nothing and leaves nothing: empty space, options, memory, iterations.

Quick.
"""
import re
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import Test, difference, example  # noqa: E402

SMALL_STRAIN = {"mpm_material_beam_type": "linear_elastic", "mpm_load_tip_value": "0,-100"}


def big_box(test):
    """The cantilever in a box four times as long per axis, same cells: the same run, at about the same memory."""
    small = test.run(example("cantilever"), mpm_output_every=50, mpm_quiet=None)
    large = test.run(example("cantilever"), mpm_output_every=50, mpm_quiet=None, mpm_grid_upper="60,60",
                     mpm_grid_cells="240,240", mpm_bc_root_upper="0,60")
    test.check("big_box.newton_differs", np.abs(small.newton - large.newton).sum(), None, 0)
    for field in ("displacement", "stress"):
        test.check(f"big_box.{field}", difference(small.table(field), large.table(field)), None, 1e-9)
    one, other = small.results.summary, large.results.summary
    test.check("big_box.cells_ratio", other["cells"] / one["cells"], 16, 16)
    test.check("big_box.unknowns_ratio", other["active_dofs_max"] / one["active_dofs_max"], 1, 1)
    test.check("big_box.memory_ratio", other["memory_max_bytes"] / one["memory_max_bytes"], None, 1.1)


def shift(test):
    """The cantilever in a grid that starts elsewhere, with empty space on every side; cell faces are where they were."""
    options = {"mpm_output_every": 0, "mpm_quiet": None, "mpm_time_end": 0.2}
    here = test.run(example("cantilever"), **options)
    there = test.run(example("cantilever"), mpm_grid_lower="-8,-16", mpm_grid_upper="24,16", mpm_grid_cells="128,128",
                     mpm_bc_root_lower="-8,-16", mpm_bc_root_upper="0,16", **options)
    test.check("shift.newton_differs", np.abs(here.newton - there.newton).sum(), None, 0)
    for axis in "xy":
        one, other = (run.results.column(f"track_tip_u{axis}") for run in (here, there))
        test.check(f"shift.tip_u{axis}", difference(one, other), None, 1e-9)


def leftovers(test, label, ranks, **options):
    """No option left unused, no memory left allocated."""
    run = test.run(example("cantilever"), ranks=ranks, mpm_time_end=0.06, options_left=None, malloc_debug=None,
                   malloc_dump=None, **options)
    unused = re.findall(r"^Option left: (.*)$", run.output, re.MULTILINE)
    test.check(f"{label}.options_were_asked_for", run.output.count("There are no unused options"), 1, 1)
    test.check(f"{label}.unused_options", len(unused), None, 0)
    leaks = re.findall(r"^ *\[ *\d+\] *\d+ bytes", run.output + run.errors, re.MULTILINE)
    test.check(f"{label}.leaks", len(leaks), None, 0)
    test.check(f"{label}.lines_on_stderr", len(run.errors.split()), None, 0)


def linear_scene(test):
    """Small strains in a linear elastic beam: Newton's first step is the answer."""
    run = test.run(example("cantilever"), status=None, mpm_quiet=None, mpm_output_every=0, mpm_time_step=0.1, **SMALL_STRAIN)
    test.check("linear.status", run.status, 0, 0)
    if run.status:
        return
    test.check("linear.newton", run.newton.max(), 1, 1)
    test.check("linear.steps", run.newton.size, 10, 10)
    # F L^3/(3 E I), plane strain, at 1/1000 of the example's load; shear and the grid's resolution give the rest
    tip, stiffness = -run.results.column("track_tip_uy")[-1], 12e6 / (1.0 - 0.2**2) / 12.0
    test.near("linear.tip_over_beam_theory", tip / (100.0 * 10.0**3 / (3.0 * stiffness)), 1.0, relative=0.05)


def unused_fields(test):
    """A hencky solid writes what it has, and nothing else."""
    run = test.run(example("cantilever"), mpm_time_end=0.02, mpm_quiet=None)
    fields = set(run.results.state("last").fields)
    wanted = {"id", "material", "position", "displacement", "stress", "volume", "mass", "F", "half_length", "strain"}
    state = {"elastic_left_cauchy_green"}
    test.check("fields.unexpected", len(fields - wanted - state), None, 0)
    test.check("fields.missing", len(wanted - fields), None, 0)
    summary = run.results.summary
    test.check("one_rank.share_of_migration", summary["time"]["migrate"] / summary["time_total_s"], None, 0.01)


with Test() as test:
    big_box(test)
    shift(test)
    leftovers(test, "options", 1)
    leftovers(test, "options_on_2", 2)
    linear_scene(test)
    unused_fields(test)
