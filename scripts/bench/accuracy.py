"""The cases of `error-time`: scenes whose answer is known, the options of a resolution, and the error of a run."""
import sys

import numpy as np

from bench.runs import ROOT

for folder in ("scripts", "examples"):
    sys.path.insert(0, str(ROOT / folder))
import bar as column  # noqa: E402  (the folders have to be known first)
from results import Results  # noqa: E402

# What is compared, by name: options. The last one is what the front page recommends where answers are smooth.
SETTINGS = {shape: {"mpm_shape": shape} for shape in ("linear", "gimp", "bspline2", "bspline3", "gimp_bspline2")}
SETTINGS["gimp_bspline2_open"] = {"mpm_shape": "gimp_bspline2", "mpm_shape_edge": "open"}

# u/L and v/L of the middle of the end section, from cantilever_reference.py, good to 2e-6: neo-Hookean,
# E = 12 MPa, nu = 0.2, 1000 kg/m3, 20 m/s2, root clamped.
CANTILEVER_END = np.array([-0.551266, -0.842725])


class Bar:
    """The elastic column under its own weight: the mean error of its stress, over the stress at the base."""

    name, title = "bar", "column: error of the stress over that at the base"
    scene = ROOT / "examples" / "bar_elastic" / "case.yaml"
    levels, quick_levels = (8, 12, 16, 24, 32, 48, 64, 96, 128, 256, 512), (8, 16, 32)
    coarse = {"gimp_bspline2_open": (6,)}  # has the error that `gimp` has with 8 cells

    @staticmethod
    def cell_size(level):
        return column.HEIGHT / level

    @staticmethod
    def options(level, points):
        return {"mpm_grid_upper": f"{column.HEIGHT / level!r},{column.HEIGHT!r}", "mpm_grid_cells": f"1,{level}",
                "mpm_body_column_points_per_cell": f"{points},{points}"}

    @staticmethod
    def error(prefix):
        results = Results(prefix)
        state, exact = results.state("last"), column.ElasticColumn(results.initial["position0"][:, 1])
        return column.weighted_error(state["stress"][:, 1] - exact.stress_yy, column.initial_volume(state))


class Cantilever:
    """The cantilever under its own weight: how far the middle of its end section is from the reference, over L.

    Points end half a spacing before the beam does. From each of those around the middle of the end section, X, the
    place is x_p + F_p (X - X_p); their mean is taken. The section carries no moment, so that what is left out is small.
    """

    name, title = "cantilever", "cantilever: error of the end's displacement over the length"
    scene = ROOT / "scripts" / "bench" / "cantilever_weight.yaml"
    levels, quick_levels = (30, 60, 120, 240), (30, 60)
    coarse = {}
    length, width, end = 10.0, 15.0, np.array([10.0, 9.5])  # m
    reach = 1.7  # spacings of points: the end's two next to its middle and their four neighbours

    @classmethod
    def cell_size(cls, level):
        return cls.width / level

    @staticmethod
    def options(level, points):
        return {"mpm_grid_cells": f"{level},{level}", "mpm_body_beam_points_per_cell": f"{points},{points}"}

    @classmethod
    def displacement(cls, results):
        """u/L and v/L of the middle of the end section."""
        state, start = results.state("last"), results.initial["position0"]
        away = cls.end - start
        distance = np.linalg.norm(away, axis=1)
        near = distance < cls.reach / 0.5**0.5 * distance.min()  # the nearest is sqrt(1/2) of a spacing away
        gradient = state["F"][near].reshape(-1, 3, 3)[:, :2, :2]
        place = state["position"][near] + np.einsum("pij,pj->pi", gradient, away[near])
        return (place.mean(axis=0) - cls.end) / cls.length

    @classmethod
    def error(cls, prefix):
        return np.linalg.norm(cls.displacement(Results(prefix)) - CANTILEVER_END)


CASES = {case.name: case for case in (Bar, Cantilever)}


def order(sizes, errors):
    """The slope of log error against log h, least squares; None with fewer than two of them."""
    if len(sizes) < 2:
        return None
    return float(np.polyfit(np.log(sizes), np.log(errors), 1)[0])
