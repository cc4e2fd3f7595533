"""Maps that a run over terrain leaves: GeoTIFFs as Talus writes them, or ESRI ASCII grids.

    peak = read_map("out/slide_peak")       # out/slide_peak.tif, or out/slide_peak_depth.asc and its kin
    peak.bands["depth"]                     # rows from south to north, not-a-number without data
    peak.x, peak.y                          # of the centres of the pixels, m

Source of the format: Adobe (1992), TIFF 6.0; OGC (2019), GeoTIFF 1.1; predictor 3: Adobe (2005), Photoshop TIFF Technical
Note 3. Other TIFFs are for GDAL's own tools.
"""
import re
import struct
import zlib
from collections import namedtuple
from pathlib import Path

import numpy as np

from results import ResultsError

Map = namedtuple("Map", "x y bands")
SIZES = {1: "B", 2: "c", 3: "H", 4: "I", 12: "d"}  # types of entries


def read_ascii(path):
    """Places of the pixels and values of an ESRI ASCII grid."""
    with open(path, encoding="utf-8") as file:
        words = file.read().split()
    head = {}
    while words and re.match("[a-zA-Z]", words[0]) and words[0].lower() != "nan":
        head[words[0].lower()] = float(words[1])
        del words[:2]
    columns, rows = int(head["ncols"]), int(head["nrows"])
    dx, dy = head.get("dx", head.get("cellsize")), head.get("dy", head.get("cellsize"))
    value = np.array(words, float).reshape(rows, columns)[::-1]
    value[value == head.get("nodata_value", -9999.0)] = np.nan
    x = head["xllcenter"] if "xllcenter" in head else head["xllcorner"] + 0.5 * dx
    y = head["yllcenter"] if "yllcenter" in head else head["yllcorner"] + 0.5 * dy
    return x + dx * np.arange(columns), y + dy * np.arange(rows), value


def write_ascii(path, x, y, value, none=-9999.0):
    """An ESRI ASCII grid: centres of square pixels, rows from south to north."""
    head = (f"ncols {len(x)}\nnrows {len(y)}\nxllcenter {float(x[0])!r}\nyllcenter {float(y[0])!r}\n"
            f"cellsize {float(x[1] - x[0])!r}\nNODATA_value {none!r}\n")
    rows = (" ".join(f"{number:.12g}" for number in np.where(np.isnan(row), none, row)) for row in np.asarray(value)[::-1])
    Path(path).parent.mkdir(parents=True, exist_ok=True)
    Path(path).write_text(head + "\n".join(rows) + "\n", encoding="utf-8")


def gully_on_fan(x, y, fan, middle, slopes, blend, ends, depth, width, dome=0.0, centre=0.0):
    """Heights of a slope with a gully that opens on a fan, m.

    The slope falls from the first of `slopes` to the second at x = fan, over the length `blend`; the walls of the gully about
    y = middle rise by `depth` within about `width`, and end within `ends` of the fan. The fan is dome (y - centre)^2 higher.
    """
    steep, flat = slopes
    along = flat * (fan - x) + (steep - flat) * blend * np.logaddexp(0.0, (fan - x) / blend)
    walls = 1.0 / (1.0 + np.exp((x - fan) / ends))
    return 20.0 + along + walls * depth * np.tanh(((y - middle) / width) ** 2) + (1.0 - walls) * dome * (y - centre) ** 2


def tiff_entries(data):
    """The entries of the first directory of a TIFF by tag."""
    if data[:4] != b"II*\0":
        raise ResultsError("is no TIFF as Talus writes them")
    start = struct.unpack_from("<I", data, 4)[0]
    found = {}
    for k in range(struct.unpack_from("<H", data, start)[0]):
        tag, kind, count, value = struct.unpack_from("<HHII", data, start + 2 + 12 * k)
        if kind not in SIZES:
            continue
        form = f"<{count}s" if kind == 2 else f"<{count}{SIZES[kind]}"
        place = start + 2 + 12 * k + 8 if struct.calcsize(form) <= 4 else value
        found[tag] = struct.unpack_from(form, data, place)
    return found


def unpack(block, rows, columns, bands, predictor):
    """Reals of a strip: bands of a pixel side by side."""
    if predictor == 3:  # the bytes of a row's numbers by their place, most significant first, as differences
        width = columns * bands
        planes = np.frombuffer(block, np.uint8).reshape(rows, width * 8)
        planes = np.add.accumulate(planes.reshape(rows, width * 8 // bands, bands), axis=1, dtype=np.uint8)
        return planes.reshape(rows, 8, width).transpose(0, 2, 1).copy().view(">f8").reshape(rows, columns, bands)
    return np.frombuffer(block, "<f8").reshape(rows, columns, bands)


def read_tiff(path):
    """Places of the pixels and bands by name of a GeoTIFF of 64-bit reals in strips, deflated or plain."""
    data = Path(path).read_bytes()
    entry = tiff_entries(data)
    columns, rows, bands = entry[256][0], entry[257][0], entry.get(277, (1,))[0]
    if set(entry[258]) != {64} or 273 not in entry or entry[259][0] not in (1, 8):
        raise ResultsError(f"{path}: has other pixels than the maps of Talus")
    height, planar = entry.get(278, (rows,))[0], entry.get(284, (1,))[0] == 2
    values, strips = np.empty((rows, columns, bands)), -(-rows // height)
    for number, (place, size) in enumerate(zip(entry[273], entry[279])):
        first, band = number % strips * height, slice(number // strips, number // strips + 1) if planar else slice(None)
        block = data[place:place + size]
        block = zlib.decompress(block) if entry[259][0] == 8 else block
        last = min(first + height, rows)
        values[first:last, :, band] = unpack(block, last - first, columns, 1 if planar else bands, entry.get(317, (1,))[0])
    if 42113 in entry:
        values[values == float(entry[42113][0].rstrip(b"\0"))] = np.nan
    names = {int(k): name for k, name in re.findall(
        r'<Item name="DESCRIPTION" sample="(\d+)"[^>]*>([^<]*)<', entry.get(42112, (b"",))[0].decode())}
    (dx, dy, _), (_, _, _, x, y, _) = entry[33550], entry[33922]
    return (x + dx * (np.arange(columns) + 0.5), y - dy * (np.arange(rows)[::-1] + 0.5),
            {names.get(k, str(k)): values[::-1, :, k] for k in range(bands)})


def read_map(stem):
    """All bands of a map of a run, by its name without ending."""
    tiff = Path(f"{stem}.tif")
    if tiff.is_file():
        return Map(*read_tiff(tiff))
    bands, x, y = {}, None, None
    for path in sorted(tiff.parent.glob(f"{tiff.stem}_*.asc")):
        x, y, bands[path.stem[len(tiff.stem) + 1:]] = read_ascii(path)
    if not bands:
        raise ResultsError(f"there is no map {tiff}: the run needs -mpm_maps_every")
    return Map(x, y, bands)


def map_steps(prefix):
    """The steps of which a run has maps, in order."""
    prefix = Path(prefix)
    found = (re.match(re.escape(prefix.name) + r"_(\d{6,})(?:_depth)?\.(?:tif|asc)$", path.name)
             for path in prefix.parent.glob(prefix.name + "_*"))
    return sorted({int(match.group(1)) for match in found if match})
