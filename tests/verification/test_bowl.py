#!/usr/bin/env python3
"""Depth-averaged flow over long times: water that swings in a bowl, a lake at rest, and a cap that slides and spreads.

Exact solutions: Thacker (1981), doi:10.1017/S0022112081001882, planar: the surface stays plane and the water's centre
swings with the period 2 pi a/sqrt(2 g h_0), and in a round bowl water rises and falls in half of that; Savage and
Hutter (1989), doi:10.1017/S0022112089000340, of a parabolic cap on a slope with Coulomb friction, whose half-width
obeys L'' = 2 g cos H_0 L_0/L^2 and whose centre slides like a block.

Quick.
"""
import math
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import Test  # noqa: E402

G = 9.81
ROW = """mpm:
  dim: 2
  physics: depth_averaged
  slope: {slope}
  {bed}
  grid: {{lower: "{lower!r},0", upper: "{upper!r},{cell!r}", cells: "{cells},1"}}
  materials: mud
  material_mud: {{type: coulomb, friction: {friction!r}, density: 1000}}
  bodies: flow
  body_flow: {{region: box, lower: "{west!r},0", upper: "{east!r},{cell!r}", points_per_cell: "4,4", material: mud, {depth}}}
  bcs: sides
  bc_sides: {{region: box, lower: "{lower!r},0", upper: "{upper!r},{cell!r}", components: "y"}}
  time: {{integrator: explicit, end: {end!r}}}
  output: {{every: 0}}
  quiet: true
"""

ROUND = """mpm:
  dim: 2
  physics: depth_averaged
  slope: vertical
  terrain: {{file: bed.asc}}
  grid: {{lower: "-14,-14", upper: "14,14", cells: "{cells},{cells}"}}
  materials: water
  material_water: {{type: coulomb, mu: 0, density: 1000}}
  bodies: lake
  body_lake: {{region: box, lower: "-9,-9", upper: "9,9", points_per_cell: "4,4", material: water, depth: depth.asc}}
  time: {{integrator: explicit, end: {end!r}}}
  output: {{every: 0}}
  quiet: true
"""


def write_row(path, values, lower, spacing, rows):
    """A map of so many equal rows of pixels, whose first centre is at `lower`."""
    line = " ".join(repr(float(value)) for value in values) + "\n"
    path.write_text(f"ncols {len(values)}\nnrows {rows}\nxllcenter {lower!r}\nyllcenter {-spacing!r}\ncellsize {spacing!r}\n"
                    + line * rows)


def parabola(path, cell, lower, upper, centre, half, height):
    """Depths that give the points of a row the volumes of a parabolic cap."""
    spacing = cell / 4
    edges = np.clip(lower + spacing * np.arange(round((upper - lower) / spacing) + 1), centre - half, centre + half) - centre
    write_row(path, np.diff(height * (edges - edges ** 3 / (3 * half ** 2))) / spacing, lower + spacing / 2, spacing, 8)


def bowl(test, cell, periods, bound, ranks=1):
    """Distance of the points' depths from the exact ones over the volume, after periods from the largest shift."""
    folder, a, shift = test.folder(), 10.0, 2.5
    count = round(30 / cell)
    write_row(folder / "bed.asc", [(-15 + cell * (i - 1)) ** 2 / a ** 2 for i in range(count + 3)], -15 - cell, cell, 4)
    parabola(folder / "depth.asc", cell, -15.0, 15.0, shift, a, 1.0)
    path = folder / "bowl.yaml"
    path.write_text(ROW.format(slope="vertical", bed="terrain: {file: bed.asc}", lower=-15.0, upper=15.0, cell=cell, cells=count,
                               friction=0.0, west=shift - a, east=shift + a, depth="depth: depth.asc",
                               end=periods * 2 * math.pi * a / math.sqrt(2 * G)))
    state = test.run(path, ranks=ranks).results.state("last")
    x, depth, volume = state["position"][:, 0], state["depth"].ravel(), state["volume"].ravel()
    exact = np.maximum(1 - (x - shift) ** 2 / a ** 2, 0)
    name = f"bowl.{periods}.{ranks}"
    test.check(f"{name}.depth", float((volume / depth * abs(depth - exact)).sum() / volume.sum()), 0, bound)
    test.near(f"{name}.centre", float((volume * x).sum() / volume.sum()), shift, relative=0.005)


def write_square(path, count, spacing, lower, values):
    """A map of count times count pixels from the centre `lower` on, of a function of the distance from the origin."""
    places = lower + spacing * np.arange(count)
    rows = [" ".join(repr(float(value)) for value in values(np.hypot(places, y))) for y in places[::-1]]
    path.write_text(f"ncols {count}\nnrows {count}\nxllcenter {lower!r}\nyllcenter {lower!r}\ncellsize {spacing!r}\n"
                    + "\n".join(rows) + "\n")


def radial(test, cell, bound):
    """Water that rises and falls in a round bowl: its depths after a period, in both directions of the plane."""
    folder, a, r0 = test.folder(), 10.0, 8.0
    part = (a ** 4 - r0 ** 4) / (a ** 4 + r0 ** 4)

    def depth(r):  # at its start and after each period
        q = math.sqrt(1 - part ** 2) / (1 - part)
        return np.maximum(q - (r / a) ** 2 * q ** 2, 0)

    count = round(28 / cell)
    write_square(folder / "bed.asc", count + 3, cell, -14 - cell, lambda r: (r / a) ** 2)
    write_square(folder / "depth.asc", 4 * count + 8, cell / 4, -14 - 3 * cell / 8,
                 lambda r: np.where(depth(r) > 1e-6, depth(r), 0))
    path = folder / "radial.yaml"
    path.write_text(ROUND.format(cells=count, end=math.pi * a / math.sqrt(2 * G)))
    state = test.run(path, ranks=3).results.state("last")
    r, found, volume = np.hypot(*state["position"].T), state["depth"].ravel(), state["volume"].ravel()
    test.check("radial.depth", float((volume / found * abs(found - depth(r))).sum() / volume.sum()), 0, bound)
    test.near("radial.shore", float(r.max()), r0, relative=0.003)


def cap(test, internal=None, pressure=1.0):
    """A cap on 30 degrees with 24 of friction, in lengths along the slope, with 40 cells across."""
    theta, delta, c = math.radians(30), math.radians(24), math.cos(math.radians(30))
    folder, half, height, cell = test.folder(), 60.0, 2.0, 3.0 * math.cos(math.radians(30))
    lower, count = -40 * cell, 130
    parabola(folder / "depth.asc", cell, lower, lower + count * cell, 0.0, half * c, height / c)
    for end in (5.0, 12.0):
        name = f"cap.{internal}.{end}"
        path = folder / "cap.yaml"
        path.write_text(ROW.format(slope="normal", bed=f'bed: "0,{-math.tan(theta)!r},0"', lower=lower, upper=lower + count * cell,
                                   cell=cell, cells=count, friction=24.0, west=-half * c, east=half * c, depth="depth: depth.asc",
                                   end=end).replace("density: 1000", "density: 1000"
                                                    + (f", internal_friction: {internal}" if internal else "")))
        state = test.run(path).results.state("last")
        x, volume = state["position"][:, 0] / c, state["volume"].ravel()
        centre = float((volume * x).sum() / volume.sum())
        width, speed, step = half, 0.0, end / 20000
        for _ in range(20000):  # leapfrog: the first kick is a half one
            middle = width + step / 2 * speed
            speed += step * 2 * G * c * pressure * height * half / middle ** 2
            width = middle + step / 2 * speed
        test.near(f"{name}.centre", centre, (math.sin(theta) - c * math.tan(delta)) * G * end ** 2 / 2, relative=0.005)
        test.near(f"{name}.width", math.sqrt(5 * float((volume * (x - centre) ** 2).sum() / volume.sum())), width,
                  relative=0.005)


def lake(test):
    """Water at rest over a bumpy bed for a thousand steps."""
    folder, cell = test.folder(), 0.25
    write_row(folder / "bed.asc", [0.2 * math.sin(2 * math.pi * i / 20) + 0.1 * math.sin(2 * math.pi * i / 10 + 1)
                                   for i in range(-61, 62)], -15 - cell, cell, 4)
    path = folder / "lake.yaml"
    path.write_text(ROW.format(slope="normal", bed="terrain: {file: bed.asc}", lower=-15.0, upper=15.0, cell=cell, cells=120,
                               friction=0.0, west=-15.0, east=15.0, depth="level: 1", end=45.0)
                    .replace("bcs: sides", "bcs: sides,west,east\n"
                             '  bc_west: {region: box, lower: "-15,0", upper: "-15,0.25", components: "x"}\n'
                             '  bc_east: {region: box, lower: "15,0", upper: "15,0.25", components: "x"}'))
    run = test.run(path)
    test.check("lake.steps", run.results.summary["steps"], 1000, 3000)
    test.check("lake.speed", float(abs(run.results.state("last")["velocity"]).max()) / math.sqrt(G), 0, 1e-12)


def path(test, curvature, mu, ranks=1):
    """A thin layer slides from rest through the valley z = x^2/20: its speed along the bed before the lowest place."""
    folder, cell, start = test.folder(), 0.25, -8.0
    write_row(folder / "bed.asc", [(-15 + cell * (i - 1)) ** 2 / 20 for i in range(123)], -15 - cell, cell, 4)
    x, u, step, time = start, 0.0, 1e-4, 0.0
    while x < -3.0:  # midpoint rule of u' = -(z' + mu sign q)(g + z'' u^2)/q^2, with q^2 = 1 + z'^2, friction along the bed
        a, b = x, u
        for part in (step / 2, step):
            s = a / 10
            rate = -(s * (G + b * b / 10) + mu * (G + (b * b / 10 if curvature == "pressure" else 0))) / (1 + s * s)
            a, b = x + part * (u if part < step else b), u + part * rate
        x, u, time = a, b, time + step
    file = folder / "path.yaml"
    file.write_text(ROW.format(slope="normal", bed=f"curvature: {curvature}\n  terrain: {{file: bed.asc}}", lower=-15.0, upper=15.0,
                               cell=cell, cells=120, friction=math.degrees(math.atan(mu)), west=start - cell, east=start + cell,
                               depth="depth: 1e-4", end=time))
    state = test.run(file, ranks=ranks, mpm_time_step=0.01).results.state("last")
    name = f"path.{curvature}.{mu}.{ranks}"
    test.near(f"{name}.speed", float(state["velocity"][:, 0].mean()), u, relative=0.01)
    test.near(f"{name}.place", float(state["position"][:, 0].mean()), x, absolute=0.05)


def kink(test, slope, mu):
    """A thin layer slides down a plane onto level ground: it stops where friction has used up its drop, drop/mu away."""
    folder, cell, start = test.folder(), 0.25, -12.0
    write_row(folder / "bed.asc", [max(0.0, slope * (5 - cell * (i - 1))) for i in range(123)], -15 - cell, cell, 4)
    file = folder / "kink.yaml"
    file.write_text(ROW.format(slope="normal", bed="curvature: path\n  terrain: {file: bed.asc}", lower=-15.0, upper=15.0,
                               cell=cell, cells=120, friction=math.degrees(math.atan(mu)), west=start - cell,
                               east=start + cell, depth="depth: 1e-4", end=10.0))
    state = test.run(file, mpm_time_step=0.02).results.state("last")
    test.near(f"kink.{slope}.reach", float(state["position"][:, 0].mean()), start + slope * 2 / mu, absolute=cell)
    test.check(f"kink.{slope}.speed", float(abs(state["velocity"]).max()), 0, 0)


def steep(test):
    """Acceleration on a plane of 68 degrees."""
    path, theta = test.folder() / "steep.yaml", math.radians(68)
    path.write_text(ROW.format(slope="normal", bed=f'bed: "0,{-math.tan(theta)!r},0"', lower=-15.0, upper=15.0, cell=0.5, cells=60,
                               friction=0.0, west=-4.0, east=4.0, depth="depth: 1e-3", end=1.0))
    state = test.run(path, mpm_time_step=0.01).results.state("last")
    test.near("steep.speed", float(state["velocity"][:, 0].mean()), G * math.sin(theta) * math.cos(theta), relative=1e-3)


def pressed(test):
    """A cap on 30 degrees that spreads with active earth pressure: K as many times the pressure of a fluid."""
    phi, delta = math.radians(30), math.radians(24)
    root = math.sqrt(1 - math.cos(phi) ** 2 / math.cos(delta) ** 2)
    cap(test, 30.0, 2 * (1 - root) / math.cos(phi) ** 2 - 1)


with Test() as test:
    bowl(test, 0.5, 1, 0.004)
    bowl(test, 0.25, 5, 0.002, ranks=3)
    radial(test, 0.4, 0.002)
    cap(test)
    pressed(test)
    steep(test)
    path(test, "path", 0.0)
    path(test, "path", 0.2, ranks=3)
    path(test, "pressure", 0.2)
    kink(test, 1.0, 0.2)
    lake(test)
