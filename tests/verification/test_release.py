#!/usr/bin/env python3
"""Columns from maps and outlines: their volume is the integral of the depth over the outline, on any number of ranks.

The map 1 + 2 exp(-r^2/150) of 100 x 100 pixels has 10942.47778 m3. Other volumes are sums over pixels of polygons cut by
shapely, over which a bilinear function is integrated exactly. In 3D ground between maps has the integral of its height.

Quick.
"""
import json
import math
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import Test  # noqa: E402

SCENE = """mpm:
  dim: 2
  physics: depth_averaged
  {bed}
  grid: {{lower: "0,0", upper: "100,100", cells: "40,40"}}
  materials: mud
  material_mud: {{type: coulomb, mu: 0.2, density: 1300}}
  bodies: flow
  body_flow: {{region: raster, material: mud, {body}}}
  task: points
  time: {{integrator: explicit, end: 1}}
"""
PLANE = 'bed: "10,0.5,-0.1"'
GROUND = """mpm:
  dim: 3
  physics: solid
  terrain: {{file: top.asc}}
  grid: {{lower: "0,0,0", upper: "40,30,16", cells: "16,12,8"}}
  materials: soil,rock
  material_soil: {{type: hencky, E: 20e6, nu: 0.3, density: 2000}}
  material_rock: {{type: hencky, E: 200e6, nu: 0.3, density: 2500}}
  bodies: {names}
  body_soil: {{region: raster, material: soil, {soil}}}
  {rock}
  task: points
  time: {{step: 1, end: 1}}
"""
ROCK = "body_rock: {region: raster, below: soil, material: rock}"


def write_grid(path, values, x0, y0, cell):
    """Rows of values from south to north."""
    with open(path, "w", encoding="utf-8") as file:
        file.write(f"ncols {values.shape[1]}\nnrows {values.shape[0]}\nxllcenter {x0!r}\nyllcenter {y0!r}\ncellsize {cell!r}\nNODATA_value -9999\n")
        for row in values[::-1]:
            file.write(" ".join("-9999" if math.isnan(v) else repr(float(v)) for v in row) + "\n")


def ring(centre, radius, wave, count):
    """A star."""
    t = np.linspace(0, 2 * np.pi, count, endpoint=False)
    r = radius * (1 + 0.3 * np.sin(wave * t))
    return [[float(centre[0] + a * np.cos(b)), float(centre[1] + a * np.sin(b))] for a, b in zip(r, t)]


def write_outline(path, *features):
    """Polygons as (rings, properties)."""
    path.write_text(json.dumps({"type": "FeatureCollection", "features": [
        {"type": "Feature", "properties": properties, "geometry": {"type": "Polygon", "coordinates": [r + r[:1] for r in rings]}}
        for rings, properties in features]}))


def area(points):
    x, y = np.array(points).T
    return 0.5 * abs(float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))))


def bilinear_integral(shapely, polygon, values, cell):
    """Of values at pixel centres (1/2 + i) cell over a polygon: by the polygon's part between four centres."""
    total = 0.0
    n = values.shape[0]
    for j in range(n - 1):
        strip = polygon.intersection(shapely.geometry.box(-1e3, (j + 0.5) * cell, 1e3, (j + 1.5) * cell))
        for i in range(n - 1) if strip.area else ():
            part = strip.intersection(shapely.geometry.box((i + 0.5) * cell, (j + 0.5) * cell, (i + 1.5) * cell, (j + 1.5) * cell))
            for piece in getattr(part, "geoms", [part]):
                if piece.geom_type != "Polygon" or piece.is_empty:
                    continue
                for k, loop in enumerate([piece.exterior, *piece.interiors]):
                    total += loop_integral(np.array(loop.coords), values[j:j + 2, i:i + 2], ((i + 0.5) * cell, (j + 0.5) * cell), cell, k > 0)
    return total


def loop_integral(at, value, origin, cell, hole):
    """Of a bilinear function over a loop, by triangles from its first vertex."""
    at = (at[:-1] - origin) / cell
    sign = np.sum(at[:, 0] * np.roll(at[:, 1], -1) - at[:, 1] * np.roll(at[:, 0], -1))
    total = 0.0
    for b, c in zip(at[1:-1], at[2:]):
        twice = (b[0] - at[0, 0]) * (c[1] - at[0, 1]) - (b[1] - at[0, 1]) * (c[0] - at[0, 0])
        for u, v in ((at[0] + b) / 2, (b + c) / 2, (c + at[0]) / 2):
            total += twice / 6 * (value[0, 0] * (1 - u) * (1 - v) + value[0, 1] * u * (1 - v) + value[1, 0] * (1 - u) * v + value[1, 1] * u * v)
    return total * cell * cell * (1 if (sign > 0) != hole else -1)


class Case:
    """A folder with a map, an outline, and scenes on them."""

    def __init__(self, test):
        self.test, self.folder = test, test.folder()

    def scene(self, body, bed=PLANE):
        path = self.folder / "release.yaml"
        path.write_text(SCENE.format(bed=bed, body=body))
        return path

    def points(self, body, bed=PLANE, ranks=1):
        return self.test.run(self.scene(body, bed), ranks=ranks, mpm_output_prefix=f"out{ranks}").results.state("last")

    def refuse(self, label, words, body, bed=PLANE):
        run = self.test.run(self.scene(body, bed), status=2)
        self.test.check(f"{label}.line", words in run.errors and run.errors.count("\n") == 1, 1, 1)
        if words not in run.errors:
            print(run.errors)


def ground_integral(shapely, values, polygon=None):
    """Over the grid, or the polygon in it, of values on the pixels of 2.5 m about it."""
    values = values[1:-1, 1:-1]
    if polygon is None:
        return 6.25 * float((values[:-1, :-1] + values[1:, :-1] + values[:-1, 1:] + values[1:, 1:]).sum()) / 4
    polygon = shapely.affinity.translate(polygon, 1.25, 1.25)  # to where bilinear_integral() has the pixels
    square = np.zeros((17, 17))
    square[:values.shape[0], :values.shape[1]] = values
    return bilinear_integral(shapely, polygon, square, 2.5)


def check_ground(test, shapely):
    """Bodies between maps in 3D: volumes, masses, places, and layers that end."""
    folder = test.folder()
    at = [np.arange(-2.5, end, 2.5) for end in (43, 33)]
    x, y = np.meshgrid(*at)
    top = 12 - 6 / (1 + np.exp(-(x - 20) / 4)) + 0.8 * np.sin(y / 5)
    rock = top - 2 - 1.5 * np.cos(x / 9) * np.cos(y / 7)
    mantle = np.clip(1 - ((x - 15) ** 2 + (y - 15) ** 2) / 90, 0, None) * 3
    for name, value in (("top", top), ("rock", rock), ("mantle", mantle), ("crossing", top + 1 - 0.1 * x), ("low", top - 4)):
        write_grid(folder / f"{name}.asc", value, -2.5, -2.5, 2.5)

    def run(soil, names="soil,rock", rock_block=ROCK, **more):
        path = folder / "ground.yaml"
        path.write_text(GROUND.format(names=names, soil=soil, rock=rock_block if "rock" in names else ""))
        return test.run(path, mpm_output_prefix="ground", **more)

    first = run("bottom: rock.asc")
    points = first.results.state("last")
    soil = points["material"] == 0
    test.near("ground.soil", float(points["volume"][soil].sum()), ground_integral(shapely, top - rock), relative=1e-12)
    test.near("ground.rock", float(points["volume"][~soil].sum()), ground_integral(shapely, rock), relative=1e-12)
    test.near("ground.mass", float(points["mass"].sum() if "mass" in points else (points["volume"] * np.where(soil, 2000, 2500)).sum()),
              2000 * ground_integral(shapely, top - rock) + 2500 * ground_integral(shapely, rock), relative=1e-12)
    test.check("ground.log", "body soil: 2481.545983 m3, 4.96309e+06 kg" in first.output, 1, 1)
    height = float((points["position"][:, 2] * points["volume"]).sum())
    test.near("ground.centre", height, ground_integral(shapely, 0.5 * top**2), relative=2e-3)  # the square is not bilinear
    shared = run("bottom: rock.asc", ranks=3).results.state("last")
    test.check("ground.ranks", float(abs(shared["position"] - points["position"]).max()), 0, 0)
    # a mantle that thins out to nothing, and a surface that cuts through the one above
    state = run("depth: mantle.asc", rock_block=ROCK.replace("}", ", bottom: crossing.asc}")).results.state("last")
    thin = float(state["volume"][state["material"] == 0].sum())
    test.near("ground.mantle", thin, ground_integral(shapely, mantle), relative=1e-3)
    test.near("ground.crossing", float(state["volume"].sum()), ground_integral(shapely, np.clip(top - (top + 1 - 0.1 * x), mantle, None)), relative=2e-2)
    if shapely:
        star = ring((19, 16), 9.0, 5, 100)
        write_outline(folder / "star.geojson", ([star], {}))
        state = run("bottom: low.asc, outline: star.geojson", "soil").results.state("last")
        test.near("ground.outline", float(state["volume"].sum()), 4 * area(star), relative=1e-3)
        state = run("bottom: 2, outline: star.geojson", "soil").results.state("last")
        test.near("ground.level", float(state["volume"].sum()), ground_integral(shapely, top - 2, shapely.geometry.Polygon(star)), relative=1e-3)
    for label, words, *scene in (("both", "the bottom is given, too", "bottom: 1, depth: 2"), ("file", "cannot be read", "bottom: nowhere.asc"),
                                 ("below", "must be a body of region raster with a bottom", "points_per_cell: \"1,1,1\""),
                                 ("thin", "must be > 0", "depth: -1"), ("high", "outside the grid", "bottom: 1, top: 40"),
                                 ("none", "there is no point in it", "bottom: 12, top: 4", "soil,rock", ROCK.replace("below: soil", "bottom: 1")), ("twice", "must be absent", "bottom: 1", "soil,rock", ROCK.replace("}", ", top: 3}"))):
        refused = run(*scene, status=2)
        test.check(f"ground.{label}", words in refused.errors and refused.errors.count("\n") == 1, 1, 1)
        if words not in refused.errors:
            print(label, refused.errors)


with Test() as test:
    case = Case(test)
    y, x = np.mgrid[0:100, 0:100] + 0.5
    hill = 1 + 2 * np.exp(-((x - 50) ** 2 + (y - 50) ** 2) / 150)
    test.near("map.volume", float(hill.sum()), 10942.47778, relative=1e-9)
    write_grid(case.folder / "hill.asc", hill, 0.5, 0.5, 1.0)

    # all of a map, by any number of points
    for count, ranks in ((10000, 1), (10000, 3), (100000, 1)):
        state = case.points(f"depth: hill.asc, points: {count}", ranks=ranks)
        test.near(f"hill.{count}.{ranks}.volume", float(state["volume"].sum()), float(hill.sum()), relative=1e-12)
        test.near(f"hill.{count}.{ranks}.count", len(state["volume"]), count, relative=2e-3)
    run = test.run(case.scene("depth: hill.asc, points: 10000"))
    test.check("log", "body flow: 10942.47778 m3, 1.42252e+07 kg" in run.output, 1, 1)
    test.check("steps", len(run.results.column("step")), 0, 0)

    # a star with a hole: number, attribute, map, share of the bed, surfaces
    star, hole = ring((48.3, 52.1), 30.0, 5, 200), ring((45.0, 55.0), 8.0, 3, 40)
    write_outline(case.folder / "star.geojson", ([star, hole[::-1]], {"thickness": 2.5}))
    plan = area(star) - area(hole)
    first = case.points("outline: star.geojson, depth: 2.5")
    test.near("number.volume", float(first["volume"].sum()), 2.5 * plan, relative=1e-12)
    test.near("number.depth", float(abs(first["depth"] - 2.5).max()), 0.0, absolute=1e-12)
    test.near("number.mass", float(first["mass"].sum()), 1300 * 2.5 * plan, relative=1e-12)
    ranks = case.points("outline: star.geojson, depth: thickness", ranks=3)
    test.check("attribute.ranks", float(abs(ranks["position"] - first["position"]).max()), 0, 0)
    test.near("number.count", len(case.points("outline: star.geojson, depth: 2.5, points: 5000")["volume"]), 5000, relative=0.01)
    try:
        import shapely.affinity
        import shapely.geometry as geometry
        import shapely
    except ImportError:
        geometry = None
    if geometry:
        polygon = geometry.Polygon(star, [hole])
        exact = bilinear_integral(shapely, polygon, hill, 1.0)
        for label, body in (("cells", 'points_per_cell: "3,3"'), ("points", "points: 20000"), ("coarse", 'points_per_cell: "1,1"')):
            state = case.points(f"outline: star.geojson, depth: hill.asc, {body}")
            test.near(f"bilinear.{label}", float(state["volume"].sum()), exact, relative=1e-10)
        inside = sum(polygon.buffer(2.5).contains(geometry.Point(p)) for p in state["position"])
        test.check("bilinear.inside", inside / len(state["position"]), 1, 1)
        centre = polygon.centroid
        share = case.points("outline: star.geojson, fraction: 0.02")
        test.near("share", float(share["volume"].sum()), 0.02 * plan * (10 + 0.5 * centre.x - 0.1 * centre.y), relative=1e-12)
        test.near("share.centre", float((first["position"] * first["volume"].reshape(-1, 1)).sum(axis=0)[0] / first["volume"].sum()),
                  centre.x, relative=1e-12)
    # parts of equal mass, and denser points where the depth or the bed is steep
    body = "outline: star.geojson, depth: hill.asc, points: 5000, spread: mass"
    state = case.points(body)
    test.check("mass.count", len(state["volume"]), 5000, 5000)
    test.near("mass.equal", float(np.ptp(state["mass"]) / state["mass"].mean()), 0.0, absolute=1e-11)
    if geometry:
        test.near("mass.volume", float(state["volume"].sum()), exact, relative=1e-10)
    test.check("mass.ranks", float(abs(case.points(body, ranks=3)["position"] - state["position"]).max()), 0, 0)
    y, x = np.mgrid[-1:101, -1:101] + 0.5
    write_grid(case.folder / "step.asc", 10 / (1 + np.exp(-(x - 50) / 3)), -0.5, -0.5, 1.0)
    for label, bed, body in (("bed", "terrain: {file: step.asc}", "outline: star.geojson, depth: thickness, spread: bed, points: 5000"),
                             ("depth", PLANE, "depth: step.asc, spread: depth, points: 5000")):
        state = case.points(body, bed)
        steep = abs(state["position"][:, 0] - 50) < 3
        even = abs(first["position"][:, 0] - 50) < 3 if label == "bed" else 0.06
        test.check(f"{label}.denser", float(np.mean(steep) / np.mean(even)), 2.0, None)
        test.near(f"{label}.volume", float(state["volume"].sum()), 2.5 * plan if label == "bed" else 50000.0, relative=1e-3)
    before = np.where(hill > 1.5, hill, 1.0)
    write_grid(case.folder / "before.asc", before + 100, 0.5, 0.5, 1.0)
    write_grid(case.folder / "after.asc", 101 + 0 * hill, 0.5, 0.5, 1.0)
    state = case.points("before: before.asc, after: after.asc")
    test.near("surfaces", float(state["volume"].sum()), float((before - 1).sum()), relative=1e-12)

    # two features with depths of their own, and columns over a lake of no data
    write_outline(case.folder / "two.geojson", ([ring((25, 25), 10, 3, 30)], {"d": 1.0}), ([ring((60, 60), 15, 4, 50)], {"d": "3"}))
    state = case.points("outline: two.geojson, depth: d")
    test.near("features", float(state["volume"].sum()), area(ring((25, 25), 10, 3, 30)) + 3 * area(ring((60, 60), 15, 4, 50)),
              relative=1e-12)
    holed = hill.copy()
    holed[40:60, 40:60] = math.nan
    write_grid(case.folder / "holed.asc", holed, 0.5, 0.5, 1.0)
    state = case.points("depth: holed.asc, points: 10000")
    test.near("holed", float(state["volume"].sum()), float(np.nansum(holed)), relative=1e-12)

    # no releases
    small = hill[:50, :50]
    write_grid(case.folder / "small.asc", small, 0.5, 0.5, 1.0)
    write_grid(case.folder / "negative.asc", small - 2.0, 0.5, 0.5, 1.0)
    write_outline(case.folder / "out.geojson", ([ring((95, 50), 10, 3, 30)], {}))
    write_outline(case.folder / "overlap.geojson", ([ring((50, 50), 20, 0, 30)], {"d": 1}), ([ring((50, 50), 10, 0, 30)], {"d": 1}))
    write_outline(case.folder / "text.geojson", ([star], {"d": "deep"}))
    write_outline(case.folder / "bow.geojson", ([[[10, 10], [20, 20], [20, 10], [10, 20]]], {}))
    case.refuse("outside", "out of the map of depths", "outline: star.geojson, depth: small.asc")
    case.refuse("grid", "out of the grid", "outline: out.geojson, depth: 1")
    case.refuse("none", "over pixels without data", "outline: star.geojson, depth: holed.asc")
    case.refuse("fraction", "below 0", "outline: star.geojson, fraction: 0.02", 'bed: "10,-0.3,0"')
    case.refuse("negative", "must be >= 0", "depth: negative.asc")
    case.refuse("overlap", "overlap", "outline: overlap.geojson, depth: d")
    case.refuse("attribute", "must be a number >= 0", "outline: text.geojson, depth: d")
    case.refuse("crossing", "edges that cross", "outline: bow.geojson, depth: 1")
    case.refuse("number", "needs one", "depth: 1")
    case.refuse("two", "one of depth, fraction", "depth: hill.asc, fraction: 0.1")
    case.refuse("after", "after is missing", "before: before.asc")
    case.refuse("few", "more than a cell", "depth: hill.asc, points: 100")
    case.refuse("spread", "needs the number of points", "outline: star.geojson, depth: 1, spread: mass")
    case.refuse("file", "cannot be read", "outline: nowhere.geojson, depth: 1")
    check_ground(test, shapely if geometry else None)
