#!/usr/bin/env python3
"""Depth-averaged flow on a bed: dam breaks, friction, laws of the bed by their uniform flow, and water at rest.

Exact solutions: Ritter (1892) and Stoker (1957) of a dam that breaks, Mangeney, Heinrich and Roche (2000),
doi:10.1007/s000240050018, of one on a slope with friction, Thacker (1981), doi:10.1017/S0022112081001882, of water that
swings in a bowl. Uniform flow of each law has its closed form.

Quick.
"""
import math
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import Test  # noqa: E402

G = 9.81
STRIP = """mpm:
  dim: 2
  physics: depth_averaged
  slope: {slope}
  bed: "0,{bed!r},0"
  grid: {{lower: "{lower!r},0", upper: "{upper!r},{cell!r}", cells: "{cells},1"}}
  materials: mud
  material_mud: {{{material}}}
  bodies: {names}
{bodies}  bcs: sides,west,east
  bc_sides: {{region: box, lower: "{lower!r},0", upper: "{upper!r},{cell!r}", components: "y"}}
  bc_west: {{region: box, lower: "{lower!r},0", upper: "{lower!r},{cell!r}", components: "x"}}
  bc_east: {{region: box, lower: "{upper!r},0", upper: "{upper!r},{cell!r}", components: "x"}}
  time: {{integrator: explicit, cfl: 0.4, end: {end!r}}}
  output: {{every: 0}}
  quiet: true
"""
BODY = ('  body_{name}: {{region: box, lower: "{lower!r},0", upper: "{upper!r},{cell!r}", points_per_cell: "4,4", '
        "material: mud, depth: {depth!r}}}\n")


CAP = """mpm:
  dim: 2
  physics: depth_averaged
  bed: "0,-0.3,0.1"
  shape: {shape}
  grid: {{lower: "0,0", upper: "{upper}", cells: "24,16"}}
  materials: sand
  material_sand: {{type: coulomb, mu: 0.1, density: 1000}}
  bodies: cap
  body_cap: {{region: sphere, center: "{center}", radius: {radius!r}, depth: {depth!r}, points_per_cell: "2,2", material: sand}}
  time: {{integrator: explicit, end: {end!r}}}
  output: {{every: 0}}
  quiet: true
"""


def strip(test, cell, depths, end, material, slope="vertical", bed=0.0, sides=(8.0, 10.0)):
    """Points of a row of cells in the last state: a depth left of 0, and one right of it unless that is 0."""
    lower, upper = -cell * math.ceil(sides[0] / cell), cell * math.ceil(sides[1] / cell)
    places = [("left", lower, 0.0, depths[0]), ("right", 0.0, upper, depths[1])]
    bodies = [BODY.format(name=name, lower=a, upper=b, cell=cell, depth=depth) for name, a, b, depth in places if depth]
    names = ",".join(name for name, _, _, depth in places if depth)
    path = test.folder() / "strip.yaml"
    path.write_text(STRIP.format(slope=slope, bed=bed, lower=lower, upper=upper, cell=cell, material=material, names=names,
                                 cells=round((upper - lower) / cell), bodies="".join(bodies), end=end))
    state = test.run(path).results.state("last")
    return state["position"][:, 0], state["depth"].ravel(), state["velocity"][:, 0]


def uniform(test, degrees, depth, material, end):
    """Speed along a slope of a layer of this depth normal to it, far from its ends."""
    c = math.cos(math.radians(degrees))
    x, h, v = strip(test, 20.0, (depth / c, 0.0), end, material, "normal", -math.tan(math.radians(degrees)), (4000.0, 1500.0))
    return float(np.median(v[np.argsort(abs(x + 1500.0))[:32]])) / c


def write_map(path, function, lower, cells, cell):
    """Heights at the nodes of a grid, and a pixel beyond."""
    xs, ys = ([lower[a] + cell * (i - 1) for i in range(cells[a] + 3)] for a in range(2))
    with open(path, "w", encoding="utf-8") as file:
        file.write(f"ncols {len(xs)}\nnrows {len(ys)}\nxllcenter {xs[0]!r}\nyllcenter {ys[0]!r}\ncellsize {cell!r}\n")
        for y in reversed(ys):
            file.write(" ".join(repr(float(function(x, y))) for x in xs) + "\n")


def lake(test, name, function, slope, ranks):
    """Largest speed of water that starts level over a bed, after some hundred steps."""
    folder = test.folder()
    write_map(folder / "bed.asc", function, (0.0, 0.0), (40, 8), 0.25)
    (folder / "lake.yaml").write_text(f"""mpm:
  dim: 2
  physics: depth_averaged
  slope: {slope}
  terrain: {{file: bed.asc}}
  grid: {{lower: "0,0", upper: "10,2", cells: "40,8"}}
  materials: water
  material_water: {{type: coulomb, mu: 0, density: 1000}}
  bodies: lake
  body_lake: {{region: box, lower: "0,0", upper: "10,2", points_per_cell: "3,3", material: water, level: 1}}
  bcs: south,north,west,east
  bc_south: {{region: box, lower: "0,0", upper: "10,0", components: "y"}}
  bc_north: {{region: box, lower: "0,2", upper: "10,2", components: "y"}}
  bc_west: {{region: box, lower: "0,0", upper: "0,2", components: "x"}}
  bc_east: {{region: box, lower: "10,0", upper: "10,2", components: "x"}}
  time: {{integrator: explicit, cfl: 0.3, end: 3}}
  output: {{every: 0}}
  quiet: true
""")
    state = test.run(folder / "lake.yaml", ranks=ranks).results.state("last")
    test.check(f"lake.{name}.{slope}.{ranks}", float(abs(state["velocity"]).max()) / math.sqrt(G), 0, 1e-12)


SLIDE = """mpm:
  dim: 2
  physics: depth_averaged
  bed: "0,-0.5,0.1"
  grid: {lower: "0,0", upper: "400,160", cells: "50,20"}
  materials: mud
  material_mud: {type: voellmy, mu: 0.155, xi: 1750, density: 1300}
  bodies: flow
  body_flow: {region: sphere, center: "60,80", radius: 20, points_per_cell: "3,3", material: mud, depth: 2}
  time: {integrator: explicit, end: 5}
  output: {every: 0}
  quiet: true
"""


WEDGE = """mpm:
  dim: 2
  physics: depth_averaged
  slope: {slope}
  terrain: {{file: bed.asc}}
  grid: {{lower: "0,0", upper: "40,0.25", cells: "160,1"}}
  materials: water
  material_water: {{type: coulomb, mu: 0, density: 1000}}
  bodies: water
  body_water: {{region: box, lower: "1.5,0", upper: "5,0.25", points_per_cell: "4,4", material: water, level: 9.5}}
  bcs: sides
  bc_sides: {{region: box, lower: "0,0", upper: "40,0.25", components: "y"}}
  time: {{integrator: explicit, end: 3}}
  output: {{every: 0}}
  quiet: true
"""


TURNED = """mpm:
  dim: 2
  physics: depth_averaged
  terrain: {{file: bed.asc}}
  grid: {{lower: "-240,-240", upper: "240,240", cells: "48,48"}}
  materials: mud
  material_mud: {{type: voellmy, mu: 0.12, xi: 500, density: 1500}}
  bodies: flow
  body_flow: {{region: sphere, center: "{x!r},{y!r}", radius: 25, points_per_cell: "3,3", material: mud, depth: 3}}
  time: {{integrator: explicit, cfl: 0.5, end: 200, rest: 0.001}}
"""


def turned(test):
    """Mud that runs down a gully onto a fan, with the terrain and the release turned on the grid: its reach and its mean place."""
    reach, mean = [], []
    for angle in (0.0, 30.0):
        folder, (c, s) = test.folder(), (math.cos(math.radians(angle)), math.sin(math.radians(angle)))

        def bed(x, y):
            a, b = c * x + s * y, -s * x + c * y
            slope = 0.05 * (150 - a) + 9.0 * float(np.logaddexp(0.0, 1.0 - a / 20))
            return slope + 0.5 * (b / 20) ** 2 / (1 + (b / 60) ** 2) / (1 + math.exp(min((a - 20) / 25, 500.0)))

        write_map(folder / "bed.asc", bed, (-240.0, -240.0), (96, 96), 5.0)
        (folder / "turned.yaml").write_text(TURNED.format(x=-150.0 * c, y=-150.0 * s))
        state = test.run(folder / "turned.yaml").results.state("last")
        along = 175.0 + state["position"] @ [c, s]  # from the upper end of the release
        reach.append(float(np.quantile(along, 0.999)))
        mean.append(float(along @ state["mass"].ravel() / state["mass"].sum()))
    test.near("turned.reach", reach[1], reach[0], relative=0.01)
    test.near("turned.mean", mean[1], mean[0], relative=0.01)


def wedge(test):
    """Water that runs down a slope of 1 in 3 and out on level ground: its mean velocity and place after 3 s.

    Reference: a well-balanced finite-volume scheme (HLL, Audusse and others 2004) with 8 000 cells.
    """
    folder = test.folder()
    write_map(folder / "bed.asc", lambda x, y: max(10 - x / 3, 10 - 10 / 3), (0.0, 0.0), (160, 1), 0.25)
    for slope, speed, place in (("vertical", 6.651, 16.31), ("normal", 6.237, None)):
        (folder / "wedge.yaml").write_text(WEDGE.format(slope=slope))
        state = test.run(folder / "wedge.yaml").results.state("last")
        mass = state["mass"].ravel() / state["mass"].sum()
        test.near(f"wedge.{slope}.speed", float(mass @ state["velocity"][:, 0]), speed, relative=0.015)
        if place:
            test.near(f"wedge.{slope}.place", float(mass @ state["position"][:, 0]), place, relative=0.01)


def slide(test):
    """A slide in both directions: on ranks, and from a checkpoint, as in one go; mass and volume stay."""
    folder = test.folder()
    (folder / "slide.yaml").write_text(SLIDE)
    whole = test.run(folder / "slide.yaml", mpm_checkpoint_every=20)
    state = whole.results.state("last")
    ranks = test.run(folder / "slide.yaml", ranks=3).results.state("last")
    test.check("slide.ranks", float(abs(ranks["position"] - state["position"]).max()), 0, 1e-9)
    path = sorted(whole.folder.glob("*checkpoint*.h5"))[0]
    again = test.run(folder / "slide.yaml", mpm_restart=path).results.state("last")
    test.check("slide.restart", float(abs(again["position"] - state["position"]).max()), 0, 1e-12)
    thick = test.run(folder / "slide.yaml", mpm_time_viscosity_quadratic=1.5).results.state("last")
    test.check("slide.viscosity", float(abs(thick["position"] - state["position"]).max()), 1e-12, 5)
    test.near("slide.mass", float(state["mass"].sum()), 1300 * float(state["volume"].sum()), relative=1e-12)
    test.check("slide.moves", float(state["position"][:, 0].mean()) - 60, 10, 60)


def scaled(test):
    """A cap on a slope, in metres and in a laboratory's size: lengths by 1/64, times by 1/8, momentum and energies by their powers."""
    for shape in ("linear", "gimp"):
        one, other = [], []
        for to, size in ((one, 1.0), (other, 1 / 64)):
            path = test.folder() / "cap.yaml"
            path.write_text(CAP.format(shape=shape, upper=f"{48 * size},{32 * size}", center=f"{18 * size},{17 * size}", radius=6 * size,
                                       depth=1.5 * size, end=2 * math.sqrt(size)))
            history = test.run(path).results.history
            to += [history["momentum_x"][-1] / size**3.5] + [history["energy_" + name][-1] / size**4 for name in
                                                             ("kinetic", "dissipated", "external", "balance")]
        test.check(f"scaled.{shape}", float(max(abs(np.array(other) - one)) / abs(one[3])), 0, 1e-9)
        test.check(f"scaled.{shape}.balance", abs(one[4] / one[3]), 0, 0.03)


def mixing(test):
    """Lateral friction: columns that move among nodes which are held, and a slide with it on ranks."""
    path = test.folder() / "mixing.yaml"
    u, k, end = 3.0, 20.0, 0.5
    body = BODY.format(name="left", lower=-2.0, upper=2.0, cell=0.5, depth=1.0).replace("material:", f'velocity: "{u!r},0", material:')
    path.write_text(STRIP.format(slope="vertical", bed=0.0, lower=-2.0, upper=2.0, cell=0.5, material=WATER, names="left", cells=8,
                                 bodies=body, end=end))
    run = test.run(path, mpm_time_transfer="flip", mpm_terrain_viscosity=k, mpm_bc_west_upper="2,0.5").results
    state, lost = run.state("last"), run.history["energy_dissipated"][-1]
    speed = u / (1 + k * u * end / 0.125)  # the side of a base: 4 points a cell
    test.check("mixing.flip", float(abs(state["velocity"][:, 0] / speed - 1).max()), 0, 1e-10)
    test.near("mixing.dissipated", lost, 0.5 * float(state["mass"].sum()) * (u**2 - speed**2), relative=1e-10)

    path.write_text(SLIDE)
    thick = {"mpm_terrain_viscosity": 100, "mpm_erosion_rate": 1e-15}  # the rate for the column energy_transfer alone
    runs = [test.run(path, ranks=n, **options).results for n, options in ((1, {}), (1, thick), (3, thick))]
    plain, mixed, ranks = (run.state("last") for run in runs)
    last = {part: runs[1].history["energy_" + part][-1] for part in ("dissipated", "external", "balance", "transfer")}
    off = (last["balance"] + last["transfer"]) / last["external"]
    test.check("mixing.energy", abs(off), 0, 0.01)
    test.near("mixing.energy_ranks", runs[2].history["energy_dissipated"][-1], last["dissipated"], relative=1e-9)
    test.check("mixing.ranks", float(abs(ranks["position"] - mixed["position"]).max()), 0, 1e-9)
    affine = [float((state["velocity_gradient"] ** 2).sum()) for state in (plain, mixed)]
    test.check("mixing.affine", affine[1] / affine[0], 0.01, 0.9)


def bumpy(x, y):
    return 0.2 * math.sin(2 * math.pi * x / 5) * math.cos(2 * math.pi * y / 3) + 0.1 * math.sin(2 * math.pi * x / 2.5 + 1)


def shore(x, y):
    return 0.08 * (x - 5) ** 2 + 0.02 * (y - 1) ** 2


def rough(x, y):
    """Ground of no shape: heights from node to node as by chance, on a slope that the level cuts."""
    return 0.3 * math.sin(37.0 * x * x + 11.0 * y) + 0.25 * x


def refuse(test, label, words, time="explicit, cfl: 0.4", **options):
    """A scene that is none: one line with these words, status 2, no files."""
    path = test.folder() / "strip.yaml"
    path.write_text(STRIP.format(slope="normal", bed=0.0, lower=-1.0, upper=1.0, cell=0.5, material=WATER, names="left", cells=4,
                                 bodies=BODY.format(name="left", lower=-1.0, upper=0.0, cell=0.5, depth=1.0), end=1.0)
                    .replace("explicit, cfl: 0.4", time))
    run = test.run(path, status=2, **options)
    test.check(f"{label}.line", words in run.errors and run.errors.count("\n") == 1, 1, 1)
    test.check(f"{label}.files", len(run.files), 0, 0)


WATER = "type: coulomb, mu: 0, density: 1000"

with Test() as test:
    # dams that break, 63 cells in c0 t
    cell = math.sqrt(G) / 63
    x, h, v = strip(test, cell, (1.0, 0.0), 1.0, WATER)
    near = np.argsort(abs(x))[:16]
    test.near("ritter.depth", float(h[near].mean()), 4 / 9, relative=0.01)
    test.near("ritter.speed", float(v[near].mean()), 2 / 3 * math.sqrt(G), relative=0.01)
    test.near("ritter.front", float(x.max()), 2 * math.sqrt(G), relative=0.1)
    x, h, v = strip(test, cell, (1.0, 0.2), 1.0, WATER, sides=(8.0, 8.0))
    behind = (x > 0.3) & (x < 2.2)
    test.near("stoker.depth", float(np.median(h[behind])), 0.50787, relative=0.005)
    test.near("stoker.speed", float(np.median(v[behind])), 1.80001, relative=0.005)

    # a dam on a slope with friction, in axes along it
    theta, delta, c = math.radians(22), math.radians(12), math.cos(math.radians(22))
    cell = math.sqrt(G * c * 20) * 10 / 34 * c
    x, h, v = strip(test, cell, (20 / c, 0.0), 10.0, "type: coulomb, friction: 12, density: 1000", "normal", -math.tan(theta),
                    (450.0, 480.0))
    near = np.argsort(abs(x))[:16]
    test.near("mangeney.depth", float(h[near].mean()) * c, 15.5539318, relative=0.01)
    test.near("mangeney.speed", float(v[near].mean()) / c, 20.6019906, relative=0.01)

    # laws by their uniform flow; a thin layer slides like a block
    s = math.sin(math.radians(25))
    test.near("voellmy", uniform(test, 25, 2.0, "type: voellmy, mu: 0.2, xi: 1500, density: 1000", 60.0), 26.90855, relative=1e-3)
    test.near("manning", uniform(test, 25, 2.0, "type: manning, n: 0.1, density: 1000", 60.0), 2 ** (2 / 3) * math.sqrt(s) / 0.1,
              relative=1e-3)
    test.near("bingham", uniform(test, 12, 1.5, "type: bingham, yield_stress: 2e3, viscosity: 150, density: 1800", 120.0), 8.796,
              relative=1e-3)
    lean = math.radians(12)
    x, h, v = strip(test, 1.0, (1.5 / math.cos(lean), 0.0), 100.0, "type: bingham, yield_stress: 2e3, viscosity: 150, density: 1800",
                    "normal", -math.tan(lean), (30.0, 80.0))
    test.near("bingham.deposit", float(np.median(h[x < -15.0])) * math.cos(lean), 2e3 / (1800 * G * math.sin(lean)), relative=0.03)
    tau, n = 1800 * G * 1.5 * math.sin(math.radians(12)), 0.5
    flows = 1 - 1000 / tau
    speed = n / (n + 1) * (tau / 1500 * flows) ** (1 / n) * 1.5 * flows * (1 - n / (2 * n + 1) * flows)
    test.near("herschel_bulkley", uniform(test, 12, 1.5, "type: herschel_bulkley, yield_stress: 1e3, consistency: 1500, n: 0.5, "
                                          "density: 1800", 60.0), speed, relative=1e-3)
    mu, c = math.tan(math.radians(25)), math.cos(math.radians(25))
    inertial = 0.3 * (mu - 0.38) / (0.64 - mu)
    speed = inertial * 2 * 2.0 * math.sqrt(0.6 * G * 2.0 * c) / (5 * 0.5)
    test.near("mu_i", uniform(test, 25, 2.0, "type: mu_i, mu_s: 0.38, mu_2: 0.64, diameter: 0.5, density: 1500", 60.0), speed,
              relative=1e-3)
    a, b, k = 1500 * G * 0.08 ** 2 / 2 ** (1 / 3), 24 * 50 / 16, 500 - 1500 * G * 2.0 * s
    test.near("obrien_julien", uniform(test, 25, 2.0, "type: obrien_julien, yield_stress: 500, viscosity: 50, n: 0.08, density: 1500",
                                       60.0), (-b + math.sqrt(b * b - 4 * a * k)) / (2 * a), relative=1e-3)
    weight, profile = 200 * G * 2.0, (math.log(2.0 / 1.0) / 0.43 + 4.13) ** 2
    low, high = 0.0, 100.0
    for _ in range(100):
        middle = (low + high) / 2
        r = 200 * middle ** 2 / (weight * c)
        low, high = (middle, high) if (0.155 * (1 + 0.222 / (0.222 + r)) * weight * c + 200 * middle ** 2 / profile
                                       < weight * s) else (low, middle)
    test.near("samosat", uniform(test, 25, 2.0, "type: samosat, roughness: 1, density: 200", 90.0), low, relative=1e-3)
    test.near("block", uniform(test, 30, 0.01, f"type: coulomb, mu: {math.tan(math.radians(20))!r}, density: 1000", 4.0),
              4 * 1.8128147, relative=1e-3)
    test.near("held", uniform(test, 25, 2.0, "type: coulomb, friction: 26, density: 1000", 5.0), 0.0)

    # water at rest, also at its shores
    for slope in ("vertical", "normal"):
        lake(test, "bumpy", bumpy, slope, 1)
        lake(test, "shore", shore, slope, 3)
    lake(test, "rough", rough, "normal", 2)

    slide(test)
    scaled(test)
    mixing(test)
    wedge(test)
    turned(test)

    points = test.folder() / "points.csv"
    points.write_text("x,y,volume\n-0.5,0.25,0.1\n")
    refuse(test, "file", "points on a bed are made from", mpm_body_left_region="file", mpm_body_left_file=points)
    refuse(test, "history", "initial_depth: unknown option", mpm_body_left_initial_depth=2)
    refuse(test, "boundary", "there are none yet", mpm_boundaries="ball", mpm_boundary_ball_type="sphere",
           mpm_boundary_ball_center="0,0", mpm_boundary_ball_radius=1)
    refuse(test, "section", "-mpm_sections: there are none yet", mpm_sections="cut", mpm_section_cut_point="1,1", mpm_section_cut_normal="1,0")
    refuse(test, "implicit", "must be explicit", "quasistatic, step: 0.1")
    refuse(test, "law", "must be one of", mpm_material_mud_type="j2")
    refuse(test, "depth", "must be > 0", mpm_body_left_depth=-1)
    refuse(test, "varies", "must be a number or a map", mpm_material_mud_mu="0:0.1,10:0.5")
    refuse(test, "viscosity", "must be >= 0", mpm_terrain_viscosity=-1)
    refuse(test, "absorbing", "absorbing: not available", mpm_bc_west_absorbing="true")
    refuse(test, "xi", "xi", mpm_material_mud_type="voellmy", mpm_material_mud_xi=0, mpm_material_mud_mu=0.1)
