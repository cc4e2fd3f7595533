#!/usr/bin/env python3
"""Maps and outlines from files of many kinds: the same bed and the same points, bit by bit where the type allows.

GDAL's Python module writes the files and warps them for comparison; where it is missing only ASCII grids are read. One
rank reads what three do.

Quick.
"""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
import talus_test  # noqa: E402
from talus_test import Test  # noqa: E402

try:
    from osgeo import gdal, ogr, osr
    gdal.UseExceptions()
except ImportError:
    gdal = None

EAST, NORTH, CELL = 512340.0, 5212340.0, 5.0  # centre of the pixel in the south-west, m
SCENE = """mpm:
  dim: 2
  physics: depth_averaged
  terrain: {{file: {file}}}
  grid: {{{grid}}}
  materials: mud
  material_mud: {{type: coulomb, mu: 0.2, density: 1300}}
  bodies: flow
  body_flow: {{{body}, material: mud}}
  task: points
  time: {{integrator: explicit, end: 1}}
"""
WINDOW = 'lower: "512350,5212350", upper: "512550,5212500", cell: 5'
BODY = 'region: box, lower: "512360,5212360", upper: "512500,5212450", depth: 1'
POLYGON = [(512370, 5212370), (512490, 5212380), (512470, 5212440), (512400, 5212455)]


def heights():
    """Whole numbers, rows from south to north."""
    y, x = np.mgrid[0:40, 0:50]
    return np.round(900 + 8 * x - 3 * y + 40 * np.sin(x / 5) * np.cos(y / 7))


def bilinear(z, places):
    """Between the centres of pixels."""
    y, x = ((places[:, a] - (EAST, NORTH)[a]) / CELL for a in (1, 0))
    j, i = np.floor(y).astype(int), np.floor(x).astype(int)
    u, v = x - i, y - j
    return (1 - u) * (1 - v) * z[j, i] + u * (1 - v) * z[j, i + 1] + (1 - u) * v * z[j + 1, i] + u * v * z[j + 1, i + 1]


class Maps:
    """A folder with maps, and scenes on them."""

    def __init__(self, test):
        self.test, self.folder = test, test.folder()

    def scene(self, file, grid=WINDOW, body=BODY):
        path = self.folder / "scene.yaml"
        path.write_text(SCENE.format(file=file, grid=grid, body=body))
        return path

    def points(self, file, grid=WINDOW, body=BODY, ranks=1, **options):
        return self.test.run(self.scene(file, grid, body), ranks=ranks, **options).results.state("last")

    def same(self, label, state, reference, most=0.0):
        self.test.check(label, max(float(abs(state[name] - reference[name]).max()) for name in ("bed", "position", "volume")), 0, most)

    def refuse(self, label, words, file, grid=WINDOW, body=BODY, **options):
        run = self.test.run(self.scene(file, grid, body), status=2, **options)
        self.test.check(f"{label}.line", words in run.errors and run.errors.count("\n") == 1, 1, 1)
        self.test.check(f"{label}.files", len(run.files), 0, 0)
        if words not in run.errors:
            print(run.errors)

    def ascii(self, name, values, **changes):
        head = {"ncols": values.shape[1], "nrows": values.shape[0], "xllcenter": EAST, "yllcenter": NORTH, "cellsize": CELL,
                "NODATA_value": -9999, **changes}
        with open(self.folder / name, "w", encoding="utf-8") as file:
            file.write("".join(f"{key} {value!r}\n" for key, value in head.items() if value is not None))
            file.writelines(" ".join(repr(float(v)) for v in row) + "\n" for row in values[::-1])
        return name

    def tiff(self, name, values, kind="Float64", options=(), system=32632, area="Area", turn=0.0, none=None, scale=None):
        data = gdal.GetDriverByName("GTiff").Create(str(self.folder / name), values.shape[1], values.shape[0], 1,
                                                    getattr(gdal, "GDT_" + kind), list(options))
        data.SetGeoTransform([EAST - CELL / 2, CELL, turn, NORTH + (values.shape[0] - 0.5) * CELL, turn, -CELL])
        if system:
            reference = osr.SpatialReference()
            reference.ImportFromEPSG(system)
            data.SetProjection(reference.ExportToWkt())
        data.SetMetadataItem("AREA_OR_POINT", area)
        band = data.GetRasterBand(1)
        if none is not None:
            band.SetNoDataValue(none)
        if scale:
            band.SetScale(scale[0])
            band.SetOffset(scale[1])
            values = (values - scale[1]) / scale[0]
        band.WriteArray(values[::-1])
        return name

    def outline(self, name, driver, polygon, system=32632, **attributes):
        reference = osr.SpatialReference()
        reference.ImportFromEPSG(system)
        reference.SetAxisMappingStrategy(osr.OAMS_TRADITIONAL_GIS_ORDER)
        data = ogr.GetDriverByName(driver).CreateDataSource(str(self.folder / name))
        layer = data.CreateLayer("release", reference, ogr.wkbPolygon)
        for key in attributes:
            layer.CreateField(ogr.FieldDefn(key, ogr.OFTReal))
        feature = ogr.Feature(layer.GetLayerDefn())
        for key, value in attributes.items():
            feature.SetField(key, value)
        feature.SetGeometry(ogr.CreateGeometryFromWkt("POLYGON((" + ",".join(f"{x!r} {y!r}" for x, y in [*polygon, polygon[0]]) + "))"))
        layer.CreateFeature(feature)
        return f"region: raster, outline: {name}"


def ascii_maps(maps, test):
    """Without GDAL: grids by centre and corner, the extent of the map, and what is not there."""
    z = heights()
    maps.ascii("dem.asc", z)
    first = maps.points("dem.asc")
    test.near("ascii.bed", float(abs(first["bed"].ravel() - bilinear(z, first["position"])).max()), 0, absolute=1e-9)
    maps.same("ascii.corner", maps.points(maps.ascii("corner.asc", z, xllcenter=None, yllcenter=None, xllcorner=EAST - 2.5,
                                                     yllcorner=NORTH - 2.5)), first)
    maps.same("ascii.ranks", maps.points("dem.asc", ranks=3), first)
    run = test.run(maps.scene("dem.asc", "terrain: true, cell: 2.5"))
    test.check("extent", "grid of 98 x 78 cells of 2.5 x 2.5 m" in run.output, 1, 1)
    weight = np.exp(-0.5 * (np.arange(-5, 6) / 1.5) ** 2)
    smooth = z.copy()
    for axis in (0, 1):
        smooth = np.apply_along_axis(lambda line: np.convolve(line, weight / weight.sum(), "same"), axis, smooth)
    state = maps.points("dem.asc", 'lower: "512370,5212370", upper: "512520,5212470", cell: 5', BODY.replace("360", "380"), mpm_terrain_smooth=1.5)
    test.near("smooth", float(abs(state["bed"].ravel() - bilinear(smooth, state["position"])).max()), 0, absolute=1e-9)
    maps.ascii("flat.asc", 7 + 0 * z)
    test.near("smooth.flat", float(abs(maps.points("flat.asc", mpm_terrain_smooth=2.5)["bed"] - 7).max()), 0, absolute=1e-12)
    maps.refuse("beyond", "covers", "dem.asc", 'lower: "512300,5212350", upper: "512550,5212500", cell: 5')
    z[20, 20] = -9999
    z[18:22, 12:16] = -9999
    (maps.folder / "all.geojson").write_text('{"type": "Polygon", "coordinates": [[[512370,5212370],[512500,5212370],[512500,5212460],[512370,5212460]]]}')
    maps.refuse("hole", "material lies where the terrain has no data", maps.ascii("hole.asc", z), body="region: raster, outline: all.geojson, depth: 1")
    maps.refuse("band", "one band", "dem.asc", mpm_terrain_band=2)
    maps.refuse("short", "numbers in place of", maps.ascii("short.asc", z, nrows=41))
    maps.refuse("missing", "cannot be read", "nowhere.tif")
    maps.refuse("cell", "whole number of cells", "dem.asc", 'lower: "512350,5212350", upper: "512550,5212500", cell: 7')
    talus_test.ENVIRONMENT["TALUS_GDAL"] = "none"
    (maps.folder / "release.shp").write_bytes(b"\0\0\x27\x0a")
    maps.refuse("shapefile", "GDAL, which reads all outlines but GeoJSON, is not there", "dem.asc",
                body="region: raster, outline: release.shp, depth: 1")
    (maps.folder / "stub.tif").write_bytes(b"II*\0")
    maps.refuse("tiff", "GDAL, which reads all maps but ASCII grids, is not there", "stub.tif")
    maps.refuse("project", "project needs it", "dem.asc", mpm_terrain_project="EPSG:32632")
    del talus_test.ENVIRONMENT["TALUS_GDAL"]
    return first


def formats(maps, test, first):
    """Types of pixels and ways to store them."""
    z = heights()
    for label, options in {
        "int16": {"kind": "Int16"}, "uint16": {"kind": "UInt16"}, "float32": {"kind": "Float32"}, "float64": {},
        "deflate": {"options": ("COMPRESS=DEFLATE", "PREDICTOR=2"), "kind": "Int16"}, "tiled": {"options": ("TILED=YES", "BLOCKXSIZE=16", "BLOCKYSIZE=16")},
        "bigtiff": {"options": ("BIGTIFF=YES",)}, "point": {"area": "Point"}, "scaled": {"kind": "Int16", "scale": (0.5, 100.0)},
        "system": {"system": None},
    }.items():
        maps.same(label, maps.points(maps.tiff(f"{label}.tif", z, **options)), first)
    maps.same("tiff.ranks", maps.points("tiled.tif", ranks=3), first)
    z[1, 1] = -9999
    maps.same("none", maps.points(maps.tiff("none.tif", z, none=-9999.0)), first)
    maps.refuse("tiff.band", "has 1 band, and not band 2", "none.tif", mpm_terrain_band=2)
    maps.refuse("turned", "rotated", maps.tiff("turned.tif", z, turn=0.1))
    maps.refuse("degrees", "in degrees", maps.tiff("degrees.tif", z, system=4326))
    maps.refuse("feet", "not in metres", maps.tiff("feet.tif", z, system=2225))
    maps.refuse("unknown", "", "none.tif", mpm_terrain_project="EPSG:99999999")


def large(maps, test):
    """A window of a map of 1e9 pixels needs no more memory than its own."""
    side = 31623
    data = gdal.GetDriverByName("GTiff").Create(str(maps.folder / "large.tif"), side, side, 1, gdal.GDT_Float32,
                                                ["TILED=YES", "SPARSE_OK=TRUE", "COMPRESS=DEFLATE", "BIGTIFF=YES"])
    data.SetGeoTransform([EAST - CELL / 2, CELL, 0, NORTH - CELL / 2 + side * CELL, 0, -CELL])
    data = None
    run = test.run(maps.scene("large.tif"))
    test.check("large.memory", run.results.summary["memory_max_bytes"] / 1e6, 1, 400)


def outlines(maps, test):
    """Polygons from each format, and in other systems."""
    body = maps.outline("release.geojson", "GeoJSON", POLYGON, thickness=1.5) + ", depth: thickness"
    maps.tiff("dem.tif", heights())
    first = maps.points("dem.tif", body=body)
    x, y = np.array(POLYGON, float).T - np.array([[EAST], [NORTH]])
    plan = 0.5 * abs(float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))))
    test.near("outline.volume", float(first["volume"].sum()), 1.5 * plan, relative=1e-9)
    for driver, name in (("ESRI Shapefile", "release.shp"), ("GPKG", "release.gpkg")):
        maps.same(driver.replace(" ", "_"), maps.points("dem.tif", body=maps.outline(name, driver, POLYGON, thickness=1.5) + ", depth: thickness"), first, 1e-7)
    turn = osr.CoordinateTransformation(*(reference(epsg) for epsg in (32632, 4326)))
    degrees = [turn.TransformPoint(float(a), float(b))[:2] for a, b in POLYGON]
    body = maps.outline("degrees.gpkg", "GPKG", degrees, system=4326, thickness=1.5) + ", depth: thickness"
    maps.refuse("systems", "another coordinate system", "dem.tif", body=body)
    state = maps.points("dem.tif", body=body, mpm_terrain_project="EPSG:32632")
    test.near("outline.project", float(state["volume"].sum()), 1.5 * plan, relative=1e-6)


def reference(epsg):
    """A coordinate system with axes east and north."""
    system = osr.SpatialReference()
    system.ImportFromEPSG(epsg)
    system.SetAxisMappingStrategy(osr.OAMS_TRADITIONAL_GIS_ORDER)
    return system


def library(maps, test):
    """The library is opened by the first map that needs it, and by nothing else."""
    for label, file, body in (("plane", "dem.asc", BODY), ("map", "dem.tif", BODY)):
        path = maps.scene(file, body=body)
        for old in maps.folder.glob("ld.*"):
            old.unlink()
        talus_test.ENVIRONMENT.update(LD_DEBUG="files", LD_DEBUG_OUTPUT=str(maps.folder / "ld"))
        talus_test.must(test, f"library.{label}", [test.program, "-options_file", path], test.folder())
        for name in ("LD_DEBUG", "LD_DEBUG_OUTPUT"):
            del talus_test.ENVIRONMENT[name]
        said = "".join(old.read_text(errors="replace") for old in maps.folder.glob("ld.*"))
        test.check(f"library.{label}.opened", int("libgdal" in said), *((1, 1) if label == "map" else (0, 0)))


def project(maps, test):
    """A map in degrees, warped as GDAL does it."""
    data = gdal.GetDriverByName("GTiff").Create(str(maps.folder / "wgs.tif"), 60, 60, 1, gdal.GDT_Int16)
    data.SetGeoTransform([9.155, 0.0001, 0, 47.073, 0, -0.0001])
    data.SetProjection(reference(4326).ExportToWkt())
    y, x = np.mgrid[0:60, 0:60]
    data.GetRasterBand(1).WriteArray(np.round(900 + 3 * x + 50 * np.sin(y / 9)))
    data = None
    gdal.Warp(str(maps.folder / "warped.tif"), str(maps.folder / "wgs.tif"), dstSRS="EPSG:32632", resampleAlg="bilinear", errorThreshold=0,
              outputType=gdal.GDT_Float64, dstNodata=float("nan"))
    warped = gdal.Open(str(maps.folder / "warped.tif"))
    west, cell, _, north, _, _ = warped.GetGeoTransform()
    low = [west + cell * warped.RasterXSize / 3, north - cell * warped.RasterYSize * 2 / 3]
    grid = f'lower: "{low[0]!r},{low[1]!r}", upper: "{low[0] + 20 * 5!r},{low[1] + 20 * 5!r}", cell: 5'
    body = f'region: box, lower: "{low[0] + 20!r},{low[1] + 20!r}", upper: "{low[0] + 80!r},{low[1] + 80!r}", depth: 1'
    maps.refuse("project.degrees", "in degrees", "wgs.tif", grid, body)
    maps.same("project.warp", maps.points("wgs.tif", grid, body, mpm_terrain_project="EPSG:32632"), maps.points("warped.tif", grid, body))


with Test() as test:
    maps = Maps(test)
    first = ascii_maps(maps, test)
    if gdal:
        formats(maps, test, first)
        large(maps, test)
        outlines(maps, test)
        library(maps, test)
        project(maps, test)
