#!/usr/bin/env python3
"""Results of flow over terrain: maps of largest values, gauges, and the end of a run at rest.

Ritter's dam break (1892) has closed forms of the time at which a depth arrives, of the discharge at the dam and of the
largest depth. On a plane bed a sliding layer stops after v/(mu g). Maps and gauges are the same on ranks and from a
checkpoint; the map of the last state has the volume of the points.

Quick.
"""
import json
import math
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import ENVIRONMENT, ROOT, Test, call  # noqa: E402
from maps import map_steps, read_map as read_whole  # noqa: E402

ENVIRONMENT["TALUS_GDAL"] = "none"  # maps as text
G = 9.81
RITTER = """mpm:
  dim: 2
  physics: depth_averaged
  slope: vertical
  bed: "0,0,0"
  grid: {lower: "-4,0", upper: "6,0.2", cells: "100,2"}
  materials: water
  material_water: {type: coulomb, mu: 0, density: 1000}
  bodies: lake
  body_lake: {region: box, lower: "-4,0", upper: "0,0.2", points_per_cell: "4,4", material: water, depth: 1}
  bcs: sides,far,west
  bc_sides: {region: box, lower: "-4,0", upper: "6,0", components: "y"}
  bc_far: {region: box, lower: "-4,0.2", upper: "6,0.2", components: "y"}
  bc_west: {region: box, lower: "-4,0", upper: "-4,0.2", components: "x"}
  time: {integrator: explicit, cfl: 0.4, end: 0.9}
  output: {every: 0}
  maps: {thresholds: "0.1,0.3"}
  gauges: dam,line,box
  gauge_dam: {place: "0,0.1"}
  gauge_line: {line: "0,0,0,0.2"}
  gauge_box: {outline: "1,0.02,2,0.02,2,0.18,1,0.18"}
  quiet: true
"""
SLIDE = """mpm:
  dim: 2
  physics: depth_averaged
  terrain: {file: bed.asc}
  grid: {lower: "1000,5000", upper: "1400,5160", cells: "50,20"}
  materials: mud
  material_mud: {type: voellmy, mu: 0.155, xi: 1750, density: 1300}
  bodies: flow
  body_flow: {region: sphere, center: "1060,5080", radius: 20, points_per_cell: "3,3", material: mud, depth: 2}
  time: {integrator: explicit, end: 4}
  output: {every: 0}
  maps: {every: 5}
  gauges: bridge,road,house,valley,all,top
  gauge_bridge: {place: "1090,5080"}
  gauge_road: {line: "1090,5000,1090,5160"}
  gauge_house: {outline: "1100,5070,1110,5070,1110,5085"}
  gauge_all: {outline: "1080,5000,1400,5000,1400,5160,1080,5160"}
  gauge_top: {place: "1080,5080"}
  gauge_valley: {path: "1030,5080,1380,5070"}
  quiet: true
"""


def read_map(path):
    """Values from south to north, and the head of an ESRI ASCII grid."""
    lines = path.read_text().split("\n")
    head = dict(line.lower().split() for line in lines[:6])
    value = np.array([[float(word) for word in line.split()] for line in lines[6:] if line])[::-1]
    value[value == float(head["nodata_value"])] = np.nan
    return value, {name: float(number) for name, number in head.items()}


def maps(run):
    """All maps of a run by their names behind the prefix."""
    return {path.stem.split("_", 1)[1]: read_map(path)[0] for path in sorted(run.folder.glob("*.asc"))}


def ritter(test):
    path = test.folder() / "ritter.yaml"
    path.write_text(RITTER)
    run = test.run(path)
    c, fields, history = math.sqrt(G), maps(run), run.results.history
    x = -4 + 0.1 * (np.arange(100) + 0.5)
    row = {name: value[0] for name, value in fields.items()}
    # behind the dam the first state is the deepest, before it the last one is
    test.near("ritter.behind", float(row["peak_depth"][x < -0.3].min()), 1.0, absolute=1e-3)
    front = (x > 0.2) & (x < 2)
    exact = (2 * c - x / 0.9) ** 2 / (9 * G)
    test.check("ritter.depth", float(abs(row["peak_depth"] - exact)[front].max()), 0, 0.015)
    for depth in (0.1, 0.3):
        # where the depth comes within the run, at x/(2 c0 - 3 sqrt(g h))
        due = x / (2 * c - 3 * math.sqrt(G * depth))
        reached = (x > 0.3) & (due < 0.85)
        time = row[f"peak_arrival_{depth:g}"]
        test.check(f"ritter.arrival.{depth}", float(abs(time - due)[reached].max()), 0, 0.08)
        test.check(f"ritter.never.{depth}", float(np.isnan(time[due > 1.05]).all()), 1, 1)
    late = history["time"] > 0.4
    width, flow = 0.2, 8 / 27 * c
    test.near("ritter.discharge", float(history["gauge_line_discharge"][late].mean()), width * flow, relative=0.01)
    test.near("ritter.volume", float(history["gauge_line_volume"][-1]), width * flow * 0.9, relative=0.02)
    test.near("ritter.place.depth", float(history["gauge_dam_depth"][-1]), 4 / 9, relative=0.015)
    test.near("ritter.place.speed", float(history["gauge_dam_speed"][-1]), 2 / 3 * c, relative=0.015)
    test.near("ritter.place.pressure", float(history["gauge_dam_pressure"][-1]), 1000 * (2 / 3 * c) ** 2, relative=0.03)
    test.near("ritter.outline", float(history["gauge_box_depth"][-1]), float(np.interp(1.0, x, exact)), relative=0.03)
    # the front that has gone over a place was the fastest there
    test.check("ritter.speed", float(row["peak_speed"][(x > 1) & (x < 2.6)].min()), 1.2 * c, 2.2 * c)
    with np.errstate(invalid="ignore"):
        ratio = (row["peak_pressure"] / row["peak_speed"] ** 2)[front]
    test.near("ritter.pressure", float(ratio.mean()), 1000, relative=0.02)


def write_bed(folder):
    """A slope of 1 in 2 with a bump; pixels of 5 m beside cells of 8 m."""
    columns, rows, size = 90, 42, 5.0
    with open(folder / "bed.asc", "w", encoding="utf-8") as file:
        file.write(f"ncols {columns}\nnrows {rows}\nxllcenter 975\nyllcenter 4975\ncellsize {size}\nNODATA_value -9\n")
        for j in reversed(range(rows)):
            file.write(" ".join(repr(700 - 0.5 * i * size + 0.1 * j * size + math.sin(0.3 * i)) for i in range(columns)) + "\n")


def slide(test):
    folder = test.folder()
    write_bed(folder)
    (folder / "slide.yaml").write_text(SLIDE)
    whole = test.run(folder / "slide.yaml", mpm_checkpoint_every=6, mpm_checkpoint_keep=9)
    fields, history, state = maps(whole), whole.results.history, whole.results.state("last")
    spread = test.run(folder / "slide.yaml", ranks=3)
    for name, value in maps(spread).items():
        scale = np.nanmax(abs(fields[name])) if np.isfinite(fields[name]).any() else 1.0
        test.check(f"slide.ranks.{name}", float(np.nanmax(np.nan_to_num(abs(value - fields[name]))) / max(scale, 1e-9)), 0, 1e-9)
        test.check(f"slide.data.{name}", int((np.isnan(value) != np.isnan(fields[name])).sum()), 0, 0)
    begun = sorted(whole.folder.glob("*checkpoint_*.h5"))[0]
    again = test.run(folder / "slide.yaml", mpm_restart=begun)
    same = [float(np.array_equal(value, fields[name], equal_nan=True)) for name, value in maps(again).items() if name.startswith("peak")]
    test.check("slide.restart", min(same), 1, 1)
    for name in ("gauge_road_volume", "gauge_house_pressure", "gauge_valley_way"):
        test.near(f"slide.restart.{name}", float(again.results.history[name][-1]), float(history[name][-1]), relative=1e-13)
    test.near("slide.outline", float(history["gauge_all_depth"][-1]), max(history["gauge_top_depth"]), 1e-12)  # at its edge
    # the last state's map has the volume of the points, and the line has seen what is beyond it
    step = max(int(name.split("_")[0]) for name in fields if name[0].isdigit())
    volume, x = state["volume"].ravel(), state["position"][:, 0]
    test.near("slide.deposit", float(np.nansum(fields["peak_deposit"])) * 25, float(volume.sum()), relative=0.02)
    test.check("slide.last", float(np.nanmax(abs(fields[f"{step:06d}_depth"] - fields["peak_deposit"]))), 0, 1e-12)
    test.near("slide.passed", float(history["gauge_road_volume"][-1]), float(volume[x > 1090].sum()), relative=0.1)
    slope = math.sqrt(1 + 0.25 + 0.01)
    deep = fields["peak_depth"] > 0.1
    test.near("slide.normal", float(np.median(fields["peak_depth"][deep] / fields["peak_depth_normal"][deep])), slope, relative=0.05)
    head = read_map(next(whole.folder.glob("*peak_depth.asc")))[1]
    test.check("slide.pixels", abs(head["cellsize"] - 5) + (head["xllcenter"] - 975) % 5 + (head["yllcenter"] - 4975) % 5, 0, 0)
    run = json.loads(next(whole.folder.glob("*summary.json")).read_text())["runout"]["valley"]
    test.near("slide.angle", run["angle"], math.degrees(math.atan(run["drop"] / run["way"])), relative=1e-7)
    table = next(whole.folder.glob("*gauge_valley.csv")).read_text().split("\n")
    rows = np.array([[float(word) for word in line.split(",")] for line in table[1:] if line])
    deep = rows[rows[:, 4] > 0.02]
    test.near("slide.way", run["way"], float(deep[-1, 0] - deep[0, 0]), relative=1e-7)
    pictures(test, whole)
    features(test, whole)
    plain = test.run(folder / "slide.yaml", mpm_gauges="bridge", mpm_maps_every=0)
    test.check("slide.plain", len(list(plain.folder.glob("*_00*.asc"))), 0, 0)


def features(test, run):
    """Gauges from a file are those of the scene; a label makes one of each feature."""
    folder = test.folder()
    write_bed(folder)
    house = [[1100, 5070], [1110, 5070], [1110, 5085], [1100, 5070]]
    shed = [[1120, 5070], [1130, 5070], [1130, 5085], [1120, 5070]]
    text = [{"type": "Feature", "properties": {"id": name}, "geometry": {"type": "Polygon", "coordinates": [ring]}}
            for name, ring in (("house", house), ("shed 2", shed))]
    (folder / "houses.geojson").write_text(json.dumps({"type": "FeatureCollection", "features": text}))
    road = {"type": "Feature", "properties": {}, "geometry": {"type": "LineString", "coordinates": [[1090, 5000], [1090, 5160]]}}
    (folder / "road.geojson").write_text(json.dumps({"type": "FeatureCollection", "features": [road]}))
    scene = SLIDE.split("  gauges:")[0] + ("  gauges: road,at\n  gauge_road: {file: road.geojson}\n"
                                            "  gauge_at: {file: houses.geojson, label: id}\n  quiet: true\n")
    (folder / "slide.yaml").write_text(scene)
    history = test.run(folder / "slide.yaml", ranks=3, mpm_maps_every=0).results.history
    for name, other in (("gauge_at_house_pressure", "gauge_house_pressure"), ("gauge_road_volume", "gauge_road_volume")):
        test.near(f"file.{name}", float(history[name][-1]), float(run.results.history[other][-1]), relative=1e-9)
    test.check("file.label", "gauge_at_shed_2_depth" in history, 1, 1)
    wrong = test.run(folder / "slide.yaml", status=2, mpm_gauge_at_label="name")
    test.check("file.no_label", "has no such attribute" in wrong.errors and wrong.errors.count("\n") == 1, 1, 1)


def pictures(test, run):
    """Bands of a GeoTIFF are those of the ASCII grids; a picture and a film have colours."""
    ENVIRONMENT.pop("TALUS_GDAL")
    folder = test.folder()
    write_bed(folder)
    (folder / "slide.yaml").write_text(SLIDE)
    other = test.run(folder / "slide.yaml")
    ENVIRONMENT["TALUS_GDAL"] = "none"
    text, tiff = read_whole(f"{run.prefix}_peak"), read_whole(f"{other.prefix}_peak")
    steps = list(map_steps(run.prefix))  # every fifth, and the last one
    test.check("maps.steps", steps == list(map_steps(other.prefix)) and steps[:2] == [0, 5] and 5 < steps[-1] <= 15, 1, 1)
    test.check("maps.places", float(abs(text.x - tiff.x).max() + abs(text.y - tiff.y).max()), 0, 1e-9)
    for name, value in text.bands.items():
        test.check(f"maps.{name}", float(np.nanmax(np.append(abs(value - tiff.bands[name]).ravel() / max(np.nanmax(abs(value)), 1), 0))), 0, 1e-9)
        test.check(f"maps.data.{name}", int((np.isnan(value) != np.isnan(tiff.bands[name])).sum()), 0, 0)
    for words in (["--output", "peak.png"], ["--field", "speed", "--step", "5", "--output", "step.png"], ["--film", "--output", "film.gif"]):
        process = call([sys.executable, ROOT / "scripts/plot.py", other.prefix, "--terrain", *words], other.folder)
        test.check(f"picture.{words[-1]}", process.returncode, 0, 0)
        test.check(f"picture.{words[-1]}.size", (other.folder / words[-1]).stat().st_size if process.returncode == 0 else 0, 5000)
    process = call([sys.executable, ROOT / "scripts/plot.py", other.prefix, "--terrain", "--field", "colour"], other.folder)
    test.check("picture.field", process.returncode == 2 and "has no band 'colour'" in process.stderr, 1, 1)


STOP = """mpm:
  dim: 2
  physics: depth_averaged
  bed: "0,0,0"
  grid: {lower: "0,0", upper: "30,4", cells: "60,8"}
  materials: mud
  material_mud: {type: coulomb, mu: 0.5, density: 1000}
  bodies: flow
  body_flow: {region: box, lower: "2,1", upper: "4,3", points_per_cell: "3,3", material: mud, depth: 0.001, velocity: "5,0"}
  time: {integrator: explicit, step: 0.005, end: 10, rest: 0.01}
  output: {every: 0}
  quiet: true
"""


def stop(test):
    """A thin layer on a plane: its energy is 1 % of that at the start when 0.9 of the time to stop is over."""
    path = test.folder() / "stop.yaml"
    path.write_text(STOP)
    for ranks in (1, 3):
        run = test.run(path, ranks=ranks)
        test.near(f"stop.time.{ranks}", float(run.results.history["time"][-1]), 0.9 * 5 / (0.5 * G), relative=0.03)
        test.check(f"stop.status.{ranks}", run.results.summary["status"] == "completed", 1, 1)
    test.near("stop.never", float(test.run(path, mpm_time_rest=0, mpm_time_end=1.5).results.history["time"][-1]), 1.5, relative=1e-12)


def refuse(test, label, words, **options):
    path = test.folder() / "ritter.yaml"
    path.write_text(RITTER)
    run = test.run(path, status=2, **options)
    test.check(f"{label}.line", words in run.errors and run.errors.count("\n") == 1, 1, 1)
    test.check(f"{label}.files", len(run.files), 0, 0)


with Test() as test:
    ritter(test)
    slide(test)
    stop(test)
    refuse(test, "thresholds", "must be > 0.3", mpm_maps_thresholds="0.3,0.1")
    refuse(test, "outside", "outside of the grid", mpm_gauge_dam_place="9,0")
    refuse(test, "two", "must have one of them", mpm_gauge_dam_line="0,0,1,0")
    refuse(test, "numbers", "must have an even number", mpm_gauge_line_line="0,0,1")
    refuse(test, "rest", "rest", mpm_time_rest=2)
