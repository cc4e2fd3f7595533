#!/usr/bin/env python3
"""A strip load on ground that keeps its water: pressures against Fourier's series with all shapes, far from it without the pressure
projection, the same on any number of ranks; what `solid` makes of it without compressibility, and of drained ground.
"""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import Test, difference, example  # noqa: E402

SCENE = Path(__file__).resolve().parent / "strip.yaml"
UNDRAINED = {"mpm_physics": "poro", "mpm_material_clay_porosity": 0.4, "mpm_material_clay_permeability": 1e-20}
DRY = {"mpm_bcs": "symmetry,side,base,dry", "mpm_bc_dry_region": "box", "mpm_bc_dry_lower": "0,-4", "mpm_bc_dry_upper": "4,0.5",
       "mpm_bc_dry_components": "p"}
FINE = {"mpm_grid_refine": 2, "mpm_quiet": None}


def series(test):
    """The example with all shapes, F-bar and small strain; without projection check.py wants the pressures to alternate."""
    runs = {}
    for shape in ("gimp", "linear", "bspline2", "gimp_bspline2"):
        runs[shape] = test.run(example("strip_undrained"), mpm_shape=shape, mpm_quiet=None)
        test.check_example(shape, runs[shape], "strip_undrained")
    for label, options in (("fbar", {"mpm_stabilization_fbar": "true"}), ("small", {"mpm_material_clay_type": "linear_elastic"}),
                           ("no_projection", {"mpm_stabilization_ppp": 0}),
                           ("nothing", {"mpm_stabilization_ppp": 0, "mpm_stabilization_ghost": "off"})):
        test.check_example(label, test.run(example("strip_undrained"), mpm_quiet=None, **options), "strip_undrained")
    for ranks in (2, 3):
        run = test.run(example("strip_undrained"), ranks=ranks, mpm_quiet=None)
        for field in ("pressure", "displacement"):
            test.check(f"ranks_{ranks}.{field}", difference(run.table(field), runs["gimp"].table(field)), None, 1e-8)


def incompressible(test):
    """E = 3 mu and nu near 1/2, on a load that settles by a tenth of its width."""
    solid = test.run(SCENE, mpm_material_clay_E=12e6, mpm_material_clay_nu=0.4999, mpm_stabilization_fbar="true", **FINE)
    for fbar in ("false", "true"):
        wet = test.run(SCENE, mpm_stabilization_fbar=fbar, **UNDRAINED, **FINE)
        wanted, got = solid.table("displacement"), wet.table("displacement")
        test.check(f"undrained.fbar_{fbar}.displacement", np.abs(got - wanted).max() / np.abs(wanted).max(), None, 0.01)
        test.near(f"undrained.fbar_{fbar}.settlement", got[:, 1].min(), wanted[:, 1].min(), relative=0.005)
        volume = np.linalg.det(wet.table("F").reshape(-1, 3, 3))
        test.check(f"undrained.fbar_{fbar}.volume", np.abs(volume - 1.0).mean(), None, 2e-3)
    test.check("settlement", -got[:, 1].min(), 0.05, None)


def drained(test):
    """Pressures held at zero: the water is not felt."""
    for fbar in ("false", "true"):
        solid = test.run(SCENE, mpm_stabilization_fbar=fbar, mpm_quiet=None, snes_rtol=1e-11)
        wet = test.run(SCENE, mpm_stabilization_fbar=fbar, mpm_quiet=None, snes_rtol=1e-11,
                       **{**UNDRAINED, **DRY, "mpm_material_clay_permeability": 1e-12})
        for field in ("stress", "displacement"):
            test.check(f"drained.fbar_{fbar}.{field}", difference(wet.table(field), solid.table(field)), None, 1e-9)
        test.check(f"drained.fbar_{fbar}.pressure", np.abs(wet.table("pressure")).max(), None, 1e-6)


with Test() as test:
    series(test)
    incompressible(test)
    drained(test)
