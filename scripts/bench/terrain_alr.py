"""The avalanche Alr of com1DFA's tests: Talus against the stored result, of a folder that has both.

The folder holds avaAlr.tif (heights, 5 m), REL/relAlr.shp (outline of a release of 1 m normal to the ground) and
expected/*_ppr.tif, *_pfv.tif, *_pft.tif: largest pressures (kPa), speeds and thicknesses. Constants of the law are those
of com1DFA's samosATMedium; `curvature: pressure` is its motion, along the bed with the path's curvature in friction.
Wanted: the common over the joint area above 1 kPa, its lowest place, speeds, those where no slope about is steeper than
60 degrees, seconds. com1DFA draws points to the mean velocity in their cells; the last variants do so, too.

Source: AvaFrame, com1DFA, configuration file com1DFACfg.ini (EUPL-1.2, not a part of this program).
"""
from pathlib import Path

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from bench.runs import BenchmarkError, Table, run_scene
from maps import write_ascii

SCENE = """mpm:
  dim: 2
  physics: depth_averaged
  curvature: pressure
  terrain: {{file: {folder}/avaAlr.tif, outflow: true}}
  grid: {{terrain: true, cell: 5}}
  materials: snow
  material_snow: {{type: samosat, mu: 0.17, density: 200}}
  bodies: flow
  body_flow: {{region: raster, outline: {folder}/REL/relAlr.shp, depth: depth.asc, points_per_cell: "2,2", material: snow}}
  time: {{integrator: explicit, cfl: 0.5, end: 400, rest: 0.01}}
  maps: {{every: 0}}
  output: {{prefix: alr, every: 0, history: 1000000}}
"""
VARIANTS = {"cells of 5 m": {}, "4 x 4 points": {"mpm_body_flow_points_per_cell": "4,4"}, "cells of 10 m": {"mpm_grid_cell": 10},
            "cells of 2.5 m": {"mpm_grid_cell": 2.5}, "lateral friction": {"mpm_terrain_viscosity": 100},
            "lateral friction, flip": {"mpm_terrain_viscosity": 100, "mpm_time_transfer": "flip"}}


def read(path, name=None):
    """Values of a map, rows from north to south, and the places of the pixels; not-a-number without data."""
    try:
        from osgeo import gdal
    except ImportError as error:
        raise BenchmarkError("--alr needs GDAL's Python package osgeo") from error
    gdal.UseExceptions()
    data = gdal.Open(str(path))
    bands = [data.GetRasterBand(k + 1) for k in range(data.RasterCount)]
    band = next((band for band in bands if name in (None, band.GetDescription())))
    values = band.ReadAsArray().astype(float)
    if band.GetNoDataValue() is not None:
        values[values == band.GetNoDataValue()] = np.nan
    x, dx, _, y, _, dy = data.GetGeoTransform()
    return values, x + dx * (np.arange(values.shape[1]) + 0.5), y + dy * (np.arange(values.shape[0]) + 0.5)


def compare(height, expected):
    rise = np.pad(np.hypot(*np.gradient(height, 5.0)), 3, mode="edge")
    gentle = sliding_window_view(rise, (7, 7)).max((2, 3)) < np.sqrt(3)

    def measure(prefix):
        found = {name: np.nan_to_num(read(f"{prefix}_peak.tif", name)[0]) for name in ("pressure", "speed", "depth_normal")}
        mine, stored = found["pressure"] > 1e3, expected["ppr"] > 1
        return {"common_over_joint": (mine & stored).sum() / (mine | stored).sum(), "hectares": mine.sum() * 25e-4,
                "lowest": np.nanmin(height[mine]), "rows_apart": int(abs(np.argmin(np.where(mine, height, np.inf)) // height.shape[1]
                                                                    - np.argmin(np.where(stored, height, np.inf)) // height.shape[1])),
                "speed": found["speed"].max(), "speed_below_60": found["speed"][gentle].max(), "speed_ratio": float(np.median(found["speed"][mine & stored] / expected["pfv"][mine & stored])),
                "depth": found["depth_normal"].max()}
    return measure


def run(arguments, folder):
    source = arguments.alr.resolve()
    height, x, y = read(source / "avaAlr.tif")
    expected = {}
    for name in ("ppr", "pfv"):
        files = sorted((source / "expected").glob(f"*_{name}.tif"))
        if not files:
            raise BenchmarkError(f"{source / 'expected'} has no *_{name}.tif")
        expected[name] = read(files[0])[0]
    rise = np.gradient(height, 5.0)
    write_ascii(folder / "depth.asc", x, y[::-1], np.sqrt(1 + rise[0] ** 2 + rise[1] ** 2)[::-1])
    scene = folder / "alr.yaml"
    scene.write_text(SCENE.format(folder=source), encoding="utf-8")
    table = Table(arguments.out, "terrain_alr", ("case", "status", "points", "steps", "total_s", "common_over_joint", "hectares",
                                                 "lowest", "rows_apart", "speed", "speed_below_60", "speed_ratio", "depth"))
    for name, options in list(VARIANTS.items())[:1 if arguments.quick else None]:
        one = run_scene(arguments.program, scene, options, arguments.ranks, measure=compare(height, expected))
        summary = one.summary or {}
        table.add(case=name, status=one.status, points=summary.get("points"), steps=summary.get("steps"),
                  total_s=summary.get("time_total_s"), **(one.value or {}))
