#!/usr/bin/env python3
"""Points that are divided where they are drawn out: in a uniform stretch nothing but their number changes.

Quick.
"""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import Test, difference  # noqa: E402

SCENE = Path(__file__).resolve().parent / "stretch.yaml"
ROUNDING, RANKS = 1e-9, 1e-9
POINTS, HALVED = 64, 2  # from 0.5 cells to 1.25 and more, beyond 0.6: twice


def moments(state):
    """Mass, volume, and the first moments of mass."""
    mass = state["mass"]
    return np.array([mass.sum(), state["volume"].sum(), *(mass[:, None] * state["position"][:, :2]).sum(axis=0)])


with Test() as check:
    whole = check.run(SCENE, mpm_stabilization_divide="off", snes_rtol=1e-12)
    runs = {ranks: check.run(SCENE, ranks=ranks, snes_rtol=1e-12) for ranks in (1, 3)}
    states = {"whole": whole.results.state("last"), "halves": runs[1].results.state("last")}
    count = states["halves"]["id"].size
    check.near("points", count, POINTS * 2**HALVED)
    check.near("ids", np.unique(states["halves"]["id"]).size, count)
    check.check("moments", difference(*map(moments, states.values())), None, ROUNDING)
    for name in ("reaction_plane_x", "track_corner_ux", "track_corner_uy"):
        check.check(name, difference(whole.results.column(name), runs[1].results.column(name)), None, ROUNDING)
        check.check(f"ranks.{name}", difference(runs[3].results.column(name), runs[1].results.column(name)), None, RANKS)
    stress = states["halves"]["stress"][:, 0]
    check.check("uniform", np.ptp(stress) / np.mean(stress), None, ROUNDING)
    half = check.run(SCENE, ranks=2, mpm_checkpoint_every=1, mpm_time_end=0.5, snes_rtol=1e-12)
    for ranks in (1, 2):
        rest = check.run(SCENE, ranks=ranks, mpm_restart=half.prefix + "_checkpoint.h5", snes_rtol=1e-12)
        pull = [run.results.column("reaction_plane_x")[-1] for run in (rest, runs[1])]
        check.near(f"restart_{ranks}", pull[0], pull[1], relative=RANKS)
