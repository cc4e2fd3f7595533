"""Ground from other programs' files: blocks of a scene and a picture.

    python -m talus import section.dxf                 # writes section.yaml and section.png
    python -m talus import terrain.tif --start 3200,810 --end 3400,905

| file | library | becomes |
|---|---|---|
| .dxf | ezdxf | a body of region polygon for each closed line, by its layer |
| .msh and what meshio reads | meshio | a body of region polygon for each physical group; in 3D a file of points for each |
| .tif | GDAL | a body of region layers, whose top is a profile through the terrain |
| .csv | none | boreholes (name, x, top, bottom, material): a body of region layers for each material |

Polygons are cleaned by shapely: closed, valid, without repeated vertices, without what an earlier one covers.
"""
from __future__ import annotations

import csv
import importlib
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from .errors import SceneError

Block = dict[str, Any]
LIBRARIES = {"ezdxf": "python3-ezdxf", "meshio": "python3-meshio", "osgeo.gdal": "python3-gdal", "shapely": "python3-shapely"}
COLUMNS = ("name", "x", "top", "bottom", "material")
SAMPLES = 201  # vertices of a profile through a terrain at most


def _library(name: str) -> Any:
    try:
        return importlib.import_module(name)
    except ImportError as error:
        raise SceneError(f"import needs {name}: install {LIBRARIES[name]} (Debian), or {name.split('.')[0]} by pip") from error


def _word(text: object) -> str:
    """A name for a block: letters, digits and underscores."""
    word = "".join(c if c.isascii() and c.isalnum() else "_" for c in str(text)).strip("_")
    return word or "body"


def _distinct(names: Sequence[str]) -> list[str]:
    """Names with a number where they repeat."""
    found: list[str] = []
    for name in names:
        candidate, count = name, 1
        while candidate in found:
            count += 1
            candidate = f"{name}_{count}"
        found.append(candidate)
    return found


def _text(numbers: Any) -> str:
    return ",".join(f"{number:.10g}" for number in np.ravel(numbers))


def clean(rings: Sequence[tuple[str, Any]]) -> list[tuple[str, Any]]:
    """Valid polygons without holes, as (name, vertices), of closed lines; a later one loses what an earlier one covers.

    A polygon with holes is cut from each hole to the outside, and parts that are left apart become polygons of their own.
    """
    shapely = _library("shapely")
    geometry = importlib.import_module("shapely.geometry")
    validation = importlib.import_module("shapely.validation")
    taken: Any = geometry.Polygon()
    found = []
    for name, vertices in rings:
        whole = validation.make_valid(geometry.Polygon(vertices))
        tolerance = 1e-9 * max(whole.bounds[2] - whole.bounds[0], whole.bounds[3] - whole.bounds[1])
        left = whole.difference(taken)
        taken = taken.union(whole)
        for part in _without_holes(left, geometry):
            if part.area > tolerance * part.length:
                found.append((name, np.asarray(part.simplify(tolerance).exterior.coords)[:-1]))
    if not found:
        raise SceneError(f"import: no closed line has an area (shapely {shapely.__version__})")
    return found


def _without_holes(shape: Any, geometry: Any) -> list[Any]:
    """Polygons of a shape; one with a hole is divided at the hole's middle."""
    pieces = []
    for part in getattr(shape, "geoms", [shape]):
        if part.geom_type != "Polygon":
            continue
        if not part.interiors:
            pieces.append(part)
            continue
        left, low, right, high = part.bounds
        middle = part.interiors[0].centroid.x
        for ends in ((left, middle), (middle, right)):
            pieces += _without_holes(part.intersection(geometry.box(ends[0], low, ends[1], high)), geometry)
    return pieces


def _polygon_blocks(rings: Sequence[tuple[str, Any]]) -> Block:
    polygons = clean(rings)
    names = _distinct([_word(name) for name, _ in polygons])
    blocks: Block = {"bodies": ",".join(names)}
    for name, (material, vertices) in zip(names, polygons):
        blocks[f"body_{name}"] = {"region": "polygon", "vertices": _text(vertices), "edge": "cut", "material": _word(material)}
    return blocks


def dxf(path: Path, tolerance: float = 0.01) -> Block:
    """Closed lines of a drawing: polylines, circles, ellipses, splines; arcs to a tolerance (m). Names are layers."""
    ezdxf = _library("ezdxf")
    paths = importlib.import_module("ezdxf.path")
    rings = []
    try:
        entities = ezdxf.readfile(path).modelspace().query("LWPOLYLINE POLYLINE CIRCLE ELLIPSE SPLINE")
    except (OSError, ezdxf.DXFError) as error:
        raise SceneError(f"{path}: is no DXF file: {error}") from error
    for entity in entities:
        vertices = np.array([(point.x, point.y) for point in paths.make_path(entity).flattening(tolerance)])
        if len(vertices) > 3 and np.allclose(vertices[0], vertices[-1]):
            rings.append((entity.dxf.layer, vertices[:-1]))
    if not rings:
        raise SceneError(f"{path}: has no closed line; polylines, circles, ellipses and splines are read")
    return _polygon_blocks(rings)


def mesh(path: Path, folder: Path | None = None) -> Block:
    """Bodies of a mesh: polygons of its groups in 2D; in 3D a table of points for each, a point an element at its centroid."""
    meshio = _library("meshio")
    try:
        read = meshio.read(path)
    except (Exception, SystemExit) as error:
        raise SceneError(f"{path}: meshio cannot read it: {error}") from error
    names = {int(tag): name for name, (tag, _) in read.field_data.items()}
    cells = []
    for k, block in enumerate(read.cells):
        tags = read.cell_data.get("gmsh:physical", [np.zeros(len(block.data), int)] * len(read.cells))[k]
        cells += [(names.get(int(tag), f"group{int(tag)}" if tag else "body"), block.type, cell) for tag, cell in zip(tags, block.data)]
    solid = [cell for cell in cells if cell[1] in ("tetra", "hexahedron", "wedge", "pyramid")]
    if solid:
        return _point_blocks(read.points, solid, Path(folder or Path(path).parent), Path(path).stem)
    flat = [(name, read.points[cell][:, :2]) for name, kind, cell in cells if kind in ("triangle", "quad")]
    if not flat:
        raise SceneError(f"{path}: has no triangles, quadrilaterals or solid elements of first order")
    _library("shapely")
    geometry, ops = importlib.import_module("shapely.geometry"), importlib.import_module("shapely.ops")
    rings: list[tuple[str, Any]] = []
    for group in dict.fromkeys(name for name, _ in flat):
        union = ops.unary_union([geometry.Polygon(corners) for name, corners in flat if name == group])
        rings += [(group, np.asarray(part.exterior.coords)[:-1]) for part in _without_holes(union, geometry)]
    return _polygon_blocks(rings)


def _volume(kind: str, corners: Any) -> float:
    """Volume of an element, by tetrahedra about its centroid over the triangles of its faces."""
    faces = {"tetra": ((0, 1, 2), (0, 1, 3), (0, 2, 3), (1, 2, 3)),
             "hexahedron": ((0, 1, 2, 3), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)),
             "wedge": ((0, 1, 2), (3, 4, 5), (0, 1, 4, 3), (1, 2, 5, 4), (2, 0, 3, 5)),
             "pyramid": ((0, 1, 2, 3), (0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4))}[kind]
    middle, total = corners.mean(axis=0), 0.0
    for face in faces:
        for k in range(1, len(face) - 1):
            edges = corners[[face[0], face[k], face[k + 1]]] - middle
            total += abs(float(np.linalg.det(edges))) / 6.0
    return total


def _point_blocks(places: Any, cells: Sequence[tuple[str, str, Any]], folder: Path, stem: str) -> Block:
    groups = list(dict.fromkeys(name for name, _, _ in cells))
    blocks: Block = {"bodies": ",".join(_distinct([_word(name) for name in groups]))}
    for name, group in zip(blocks["bodies"].split(","), groups):
        rows = [(*places[cell].mean(axis=0), _volume(kind, places[cell])) for own, kind, cell in cells if own == group]
        table = folder / f"{stem}_{name}.csv"
        np.savetxt(table, rows, delimiter=",", header="x,y,z,volume", comments="", fmt="%.10g")
        blocks[f"body_{name}"] = {"region": "file", "file": table.name, "material": name}
    return blocks


def geotiff(path: Path, start: Sequence[float] | None = None, end: Sequence[float] | None = None) -> Block:
    """A layer below a profile through a terrain, from start to end (coordinates of the map; default: along its middle row)."""
    gdal = _library("osgeo.gdal")
    gdal.UseExceptions()
    try:
        data = gdal.Open(str(path))
        heights = data.GetRasterBand(1).ReadAsArray().astype(float)
        missing, (x0, dx, _, y0, _, dy) = data.GetRasterBand(1).GetNoDataValue(), data.GetGeoTransform()
    except (RuntimeError, AttributeError) as error:
        raise SceneError(f"{path}: GDAL cannot read it: {error}") from error
    rows, columns = heights.shape
    middle = y0 + dy * (rows // 2 + 0.5)
    ends = np.array([start or (x0 + 0.5 * dx, middle), end or (x0 + (columns - 0.5) * dx, middle)], float)
    length = float(np.hypot(*(ends[1] - ends[0])))
    along = np.linspace(0.0, 1.0, min(SAMPLES, 1 + int(np.ceil(length / min(abs(dx), abs(dy))))))
    places = ends[0] + along[:, None] * (ends[1] - ends[0])
    i, j = (places[:, 1] - y0) / dy - 0.5, (places[:, 0] - x0) / dx - 0.5
    if min(i.min(), j.min()) < -0.501 or i.max() > rows - 0.499 or j.max() > columns - 0.499:
        raise SceneError(f"{path}: the profile leaves the map, x {x0:g} to {x0 + columns * dx:g}, y {y0 + rows * dy:g} to {y0:g}")
    i, j = np.clip(i, 0, rows - 1), np.clip(j, 0, columns - 1)
    i0, j0 = np.minimum(i.astype(int), max(rows - 2, 0)), np.minimum(j.astype(int), max(columns - 2, 0))
    i1, j1, s, t = np.minimum(i0 + 1, rows - 1), np.minimum(j0 + 1, columns - 1), i - i0, j - j0
    corners = np.stack([heights[i0, j0], heights[i0, j1], heights[i1, j0], heights[i1, j1]])
    if missing is not None and (corners == missing).any():
        raise SceneError(f"{path}: the profile crosses places without data")
    top = corners[0] * (1 - s) * (1 - t) + corners[1] * (1 - s) * t + corners[2] * s * (1 - t) + corners[3] * s * t
    line = _text(np.stack([along * length, top], axis=1))
    return {"bodies": "ground", "body_ground": {"region": "layers", "top": line, "edge": "cut", "material": "ground"}}


def boreholes(path: Path) -> Block:
    """Layers between boreholes: a CSV file with the columns name, x, top, bottom, material; rows from above, hole by hole.

    Materials stand in one order in all holes; one that a hole lacks has no thickness there.
    """
    with open(path, encoding="utf-8-sig", newline="") as file:
        text = file.read()
    rows = list(csv.DictReader(text.splitlines(), delimiter=";" if ";" in text.split("\n", 1)[0] else ","))
    lacking = [name for name in COLUMNS if not rows or name not in rows[0]]
    if lacking:
        raise SceneError(f"{path}: has no column {lacking[0]}; boreholes have {', '.join(COLUMNS)}")
    holes: dict[str, list[tuple[float, float, float, str]]] = {}
    for number, row in enumerate(rows, 2):
        try:
            x, top, bottom = (float(row[name].replace(",", ".")) for name in ("x", "top", "bottom"))
        except (ValueError, AttributeError) as error:
            raise SceneError(f"{path}: line {number}: x, top and bottom must be numbers") from error
        hole = holes.setdefault(row["name"], [])
        if bottom > top or (hole and abs(hole[-1][2] - top) > 1e-6):
            raise SceneError(f"{path}: line {number}: a layer must begin where the one above ends, and end below")
        hole.append((x, top, bottom, row["material"]))
    order = _order(path, [[layer[3] for layer in hole] for hole in holes.values()])
    across = sorted(holes.values(), key=lambda hole: hole[0][0])
    names = _distinct([_word(name) for name in order])
    blocks: Block = {"bodies": ",".join(names)}
    level = [hole[0][1] for hole in across]
    for k, (name, material) in enumerate(zip(names, order)):
        ends = [next((layer[2] for layer in hole if layer[3] == material), height) for hole, height in zip(across, level)]
        body: Block = {"region": "layers"}
        if k:
            body["below"] = names[k - 1]
        else:
            body["top"] = _text([(hole[0][0], height) for hole, height in zip(across, level)])
        blocks[f"body_{name}"] = {**body, "bottom": _text([(hole[0][0], height) for hole, height in zip(across, ends)]), "edge": "cut",
                                  "material": name}
        level = ends
    return blocks


def _order(path: Path, columns: Sequence[Sequence[str]]) -> list[str]:
    """One order of materials, from above, that all holes have."""
    order: list[str] = []
    left = [list(column) for column in columns]
    while any(left):
        heads = [column[0] for column in left if column]
        free = [head for head in heads if not any(head in column[1:] for column in left)]
        if not free:
            raise SceneError(f"{path}: {heads[0]} lies above and below the same material: name the layers apart")
        order.append(free[0])
        left = [column[1:] if column and column[0] == free[0] else column for column in left]
    return order


KINDS: dict[str, tuple[Callable[..., Block], tuple[str, ...]]] = {
    ".dxf": (dxf, ("tolerance",)), ".tif": (geotiff, ("start", "end")), ".tiff": (geotiff, ("start", "end")), ".csv": (boreholes, ())}


def read(path: Path | str, folder: Path | str = ".", **options: Any) -> Block:
    """Blocks of a scene from a file, by the ending of its name; tables of points are written to the folder."""
    path = Path(path)
    if not path.is_file():
        raise SceneError(f"{path}: there is no such file")
    if path.suffix.lower() not in KINDS:
        return mesh(path, Path(folder))
    importer, accepted = KINDS[path.suffix.lower()]
    for name in options:
        if name not in accepted:
            raise SceneError(f"{path}: {name} is not for files {path.suffix}")
    return importer(path, **options)


def write(blocks: Block, path: Path | str) -> None:
    """A scene's file with these blocks; materials are to be filled in."""
    materials = dict.fromkeys(block["material"] for key, block in blocks.items() if key.startswith("body_"))
    scene = {"mpm": {"materials": ",".join(materials), **blocks}}
    head = "# Bodies made by talus import. Add dim, grid, conditions and the block of each material, or name a second file that has them.\n"
    Path(path).write_text(head + yaml.safe_dump(scene, sort_keys=False, width=10**6, default_flow_style=False), encoding="utf-8")


def picture(blocks: Block, path: Path | str, folder: Path | str = ".") -> None:
    """A picture of the bodies, with their names."""
    pyplot = importlib.import_module("matplotlib.pyplot")
    figure, axes = pyplot.subplots(figsize=(9, 5), layout="constrained")
    tops: dict[str, Any] = {}
    for k, name in enumerate(blocks["bodies"].split(",")):
        body, colour = blocks[f"body_{name}"], f"C{k % 10}"
        if body["region"] == "polygon":
            place = np.array(body["vertices"].split(","), float).reshape(-1, 2)
            axes.fill(*place.T, facecolor=colour, edgecolor="black", linewidth=0.8, alpha=0.7, label=name)
        elif body["region"] == "layers":
            top = np.array(body["top"].split(","), float).reshape(-1, 2) if "top" in body else tops[body["below"]]
            bottom = np.array(body["bottom"].split(","), float).reshape(-1, 2) if "bottom" in body else None
            tops[name] = bottom
            floor = np.interp(top[:, 0], *bottom.T) if bottom is not None else top[:, 1].min() - 0.3 * np.ptp(top[:, 1])
            axes.fill_between(top[:, 0], floor, top[:, 1], facecolor=colour, edgecolor="black", linewidth=0.8, alpha=0.7, label=name)
        else:
            place = np.loadtxt(Path(folder) / body["file"], delimiter=",", skiprows=1, ndmin=2)
            axes.scatter(place[:, 0], place[:, 1], s=4, color=colour, label=name)
    axes.set(xlabel="x (m)", ylabel="y (m)")
    axes.set_aspect("equal", adjustable="datalim")
    axes.legend(loc="upper right")
    figure.savefig(path, dpi=130)
    pyplot.close(figure)
