#!/usr/bin/env python3
"""Factors of safety of slopes in sand with cohesion and in clay, 20 cells to their height, against upper bounds of limit analysis.

The bound is the least over rigid rotations along logarithmic spirals, circles in clay, through the toe or below it (Chen 1975, Limit
Analysis and Soil Plasticity, chapter 9); dilation is friction, so that the bound applies. With --full: all slopes and shapes.
"""
import itertools
import math
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import FULL, Test  # noqa: E402

SCENE = Path(__file__).resolve().parent / "acads_1a.yaml"
HEIGHT, BELOW, WEIGHT = 10.0, 5.0, 20e3  # m from toe to crest, m from toe to rock, N/m3
# run over height, cohesion (clay: strength) in Pa, friction in degrees
SLOPES = {"steep": (1.0, 20e3, 15.0), "half": (1.5, 12e3, 20.0), "flat": (2.0, 10e3, 20.0), "sand": (2.0, 4e3, 30.0),
          "clay_60": (1.0 / math.sqrt(3.0), 45e3, 0.0), "clay_75": (math.tan(math.radians(15.0)), 50e3, 0.0)}


def stability(start, end, ahead, run, tangent):
    """gamma H / c at which a spiral from `start` to `end` (angles below the horizontal at its centre) slides, that leaves the ground
    `ahead` of the toe; infinite where there is none. Arrays of any shape that broadcast."""
    start, end, ahead = np.broadcast_arrays(start, end, ahead)
    grow = np.exp((end - start) * tangent)
    with np.errstate(all="ignore"):
        first = HEIGHT / (grow * np.sin(end) - np.sin(start))  # the radius at the crest
        angle = start[..., None] + (end - start)[..., None] * np.linspace(0.0, 1.0, 81)
        radius = first[..., None] * np.exp((angle - start[..., None]) * tangent)
        centre = np.stack([-ahead - first * grow * np.cos(end), first * grow * np.sin(end)], axis=-1)
        x, y = centre[..., :1] + radius * np.cos(angle), centre[..., 1:] - radius * np.sin(angle)
        cover = (HEIGHT * np.clip(x / run, 0.0, 1.0) - y).min(axis=-1)  # m of ground above the spiral
        outline_x = np.concatenate([x, np.zeros_like(x[..., :1]), np.full_like(x[..., :1], run)], axis=-1) - centre[..., :1]
        outline_y = np.concatenate([y, np.zeros_like(y[..., :1]), np.full_like(y[..., :1], HEIGHT)], axis=-1)
        next_x, next_y = np.roll(outline_x, -1, axis=-1), np.roll(outline_y, -1, axis=-1)
        moment = ((outline_x + next_x) * (next_x * outline_y - outline_x * next_y)).sum(axis=-1) / 6.0  # of the area, m3
        swept = end - start if tangent == 0.0 else np.expm1(2.0 * (end - start) * tangent) / (2.0 * tangent)
        number = first**2 * swept * HEIGHT / moment
    bad = (end <= start) | ~(first > 0.0) | (cover < -1e-6 * HEIGHT) | (y.min(axis=-1) < -BELOW) | ~(moment > 0.0)
    return np.where(bad, np.inf, number)


def least(run, tangent):
    """The least of them, by random points around the best one, ever closer: the rock's bound cuts through lattices."""
    random, best, found = np.random.default_rng(1), np.array([math.radians(45.0), math.radians(110.0), 5.0]), np.inf
    spread = np.array([math.radians(60.0), math.radians(70.0), 10.0])
    for _ in range(30):
        places = best + spread * random.uniform(-1.0, 1.0, (1000, 3))
        places[:, 2] = np.maximum(places[:, 2], 0.0)
        values = stability(*places.T, run, tangent)
        at = np.argmin(values)
        if values[at] < found:
            found, best = values[at], places[at]
        spread *= 0.75
    return found


def bound(run, cohesion, friction):
    """The factor F by which cohesion and tan(friction) are divided at collapse, by halving: where friction holds the slope by itself no
    spiral slides."""
    low, high = 0.5, 2.5
    while high - low > 2e-4:
        factor = 0.5 * (low + high)
        stands = least(run, math.tan(math.radians(friction)) / factor) > factor * WEIGHT * HEIGHT / cohesion
        low, high = (factor, high) if stands else (low, factor)
    return low


def scene(folder, slope, run, cohesion, friction):
    """The slope of ACADS with another face and another ground."""
    law = (f"{{type: j2, yield_stress: {math.sqrt(3.0) * cohesion}, E: 1e8, nu: 0.49, density: 2000}}" if friction == 0.0 else
           f"{{type: mohr_coulomb, cohesion: {cohesion}, friction: {friction}, dilation: {friction}, E: 1e8, nu: 0.3, density: 2000}}")
    lines = SCENE.read_text(encoding="utf-8").replace("15,30,15,10,5", f"15,{10.0 + run},15,10,5").splitlines()
    lines = [f"  material_soil: {law}" if line.startswith("  material_soil:") else line for line in lines]
    path = Path(folder) / f"{slope}.yaml"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


def reduce(test, slope, shape, step=0.1):
    """The slope's factor, in steps of 0.5 times `step`, and its upper bound."""
    ratio, cohesion, friction = SLOPES[slope]
    run = ratio * HEIGHT
    reference = bound(run, cohesion, friction)
    path = scene(test.folder(), slope, run, cohesion, friction)
    done = test.run(path, mpm_quiet=None, mpm_grid_refine=2, mpm_shape=shape, mpm_stage_fail_time_step=step,
                    mpm_stage_fail_reduction=f"0:{0.8 * reference},1:{1.3 * reference}")
    factor = done.results.summary["factor_of_safety"]
    print(f"{slope} {shape}: factor {factor:.4f}, upper bound {reference:.4f}")
    test.check(f"{slope}.{shape}.{step:g}.factor", factor / reference, 0.97, 1.03)
    return factor


with Test() as checks:
    checks.near("chen", least(HEIGHT, math.tan(math.radians(15.0))), 12.05, relative=2e-3)  # 45 degrees, his table
    if FULL:
        for each in itertools.product(SLOPES, ("gimp", "gimp_bspline2")):
            reduce(checks, *each)
        for each in itertools.product(("half", "clay_60"), ("gimp", "gimp_bspline2")):
            factors = [reduce(checks, *each, step) for step in (0.02, 0.1, 0.4)]
            checks.check(".".join(each) + ".steps", max(factors) / min(factors) - 1.0, None, 0.003)
    else:
        reduce(checks, "steep", "gimp")
