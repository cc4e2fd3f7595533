#!/usr/bin/env python3
"""Reads an XDMF index of Talus as a viewer does, without a screen, and draws what it finds.

    xdmf.py out/cantilever.xdmf --output picture.png [--state -1] [--field displacement]

The points of a state are drawn over the cells of the grid, coloured by the size of a field. As a module: read(path) gives
the collections by name, each a list of states in time.
"""
import argparse
import sys
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import h5py
import matplotlib
import numpy as np

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
from matplotlib.collections import LineCollection, PolyCollection  # noqa: E402
from mpl_toolkits.mplot3d.art3d import Line3DCollection  # noqa: E402

COMPONENTS = {"Scalar": 1, "Tensor": 9}
CORNERS = {"Polyvertex": 1, "Quadrilateral": 4, "Hexahedron": 8}
EDGES = {4: ((0, 1), (1, 2), (2, 3), (3, 0)),
         8: ((0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7))}


class XdmfError(Exception):
    """The index and the file that it refers to do not belong together; the text says where."""


class State:
    """A mesh at a time: positions (n, 2 or 3), cells as corner numbers (m, corners), fields of the nodes by name."""

    def __init__(self, time, position, cells, fields):
        self.time, self.position, self.cells, self.fields = time, position, cells, fields


def data(item, folder):
    """The numbers of a DataItem, which must be what it announces."""
    name, path = item.text.strip().split(":")
    with h5py.File(folder / name, "r") as file:
        if path not in file:
            raise XdmfError(f"{name} has no {path}")
        values = file[path][()]
    shape = tuple(int(word) for word in item.get("Dimensions").split())
    kind = {"Float": "f", "Int": "i"}[item.get("NumberType")] + item.get("Precision")
    if values.shape != shape or values.dtype != np.dtype(kind):
        raise XdmfError(f"{path} is {values.shape} {values.dtype}, the index says {shape} {kind}")
    return values


def read_state(grid, folder):
    topology, geometry = grid.find("Topology"), grid.find("Geometry")
    position = data(geometry.find("DataItem"), folder)
    if position.shape[1] != {"XY": 2, "XYZ": 3}[geometry.get("GeometryType")]:
        raise XdmfError(f"positions of {position.shape[1]} components in {geometry.get('GeometryType')}")
    corners = CORNERS[topology.get("TopologyType")]
    cells = data(topology.find("DataItem"), folder).reshape(-1, corners)
    if len(cells) != int(topology.get("NumberOfElements")):
        raise XdmfError(f"{len(cells)} cells, the index says {topology.get('NumberOfElements')}")
    if cells.size and not (0 <= cells.min() and cells.max() < len(position)):
        raise XdmfError("a cell has a corner that is not there")
    if corners == 1 and not np.array_equal(cells[:, 0], np.arange(len(position))):
        raise XdmfError("the points' cells are not the points, each once and in their order")
    fields = {}
    for attribute in grid.findall("Attribute"):
        name, kind = attribute.get("Name"), attribute.get("AttributeType")
        values = fields[name] = data(attribute.find("DataItem"), folder)
        width = values.shape[1] if values.ndim > 1 else 1
        if len(values) != len(position) or width not in (COMPONENTS.get(kind, position.shape[1]),):
            raise XdmfError(f"{name} is {values.shape} as a {kind} of {len(position)} nodes")
    return State(float(grid.find("Time").get("Value")), position, cells, fields)


def read(path):
    """{name of a collection: [State, ...]}"""
    path = Path(path)
    domain = ElementTree.parse(path).getroot().find("Domain")
    return {collection.get("Name"): [read_state(grid, path.parent) for grid in collection.findall("Grid")]
            for collection in domain.findall("Grid")}


def size(values):
    """One number a node: a scalar itself, otherwise the length of all components."""
    return values if values.ndim == 1 else np.linalg.norm(values, axis=1)


def draw(points, grid, field):
    """A figure of one state of the points and, if there is one, of the grid."""
    space = points.position.shape[1] == 3
    figure = plt.figure(figsize=(8, 6), layout="constrained")
    axes = figure.add_subplot(projection="3d" if space else None)
    if grid is not None:
        edges = np.concatenate([grid.position[grid.cells[:, edge]] for edge in EDGES[grid.cells.shape[1]]])
        if space:
            axes.add_collection3d(Line3DCollection(edges, colors="0.7", linewidths=0.3))
        else:
            axes.add_collection(PolyCollection(grid.position[grid.cells], facecolors="0.95", edgecolors="none"))
            axes.add_collection(LineCollection(edges, colors="0.6", linewidths=0.5))
    dots = axes.scatter(*points.position.T, c=size(points.fields[field]), s=3.0, linewidths=0, cmap="viridis")
    axes.set_aspect("equal")
    axes.set(xlabel="x (m)", ylabel="y (m)", title=f"time {points.time:g}")
    figure.colorbar(dots, ax=axes, shrink=0.8, label=field)
    return figure


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("index", help="PREFIX.xdmf")
    parser.add_argument("--output", required=True, metavar="FILE.png")
    parser.add_argument("--state", type=int, default=-1, help="which of the states, from 0; -1 is the last")
    parser.add_argument("--field", default="displacement", help="of the points; vectors and tensors by their size")
    arguments = parser.parse_args()
    try:
        collections = read(arguments.index)
        points = collections["states"][arguments.state]
        if arguments.field not in points.fields:
            raise XdmfError(f"there is no field {arguments.field}, but {', '.join(points.fields)}")
        grids = [grid for grid in collections.get("grids", ()) if grid.time == points.time]
        draw(points, grids[0] if grids else None, arguments.field).savefig(arguments.output, dpi=120)
    except (XdmfError, OSError, IndexError) as error:
        sys.exit(f"xdmf.py: {error}")


if __name__ == "__main__":
    main()
