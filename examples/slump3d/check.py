#!/usr/bin/env python3
"""Checks a run of the slump: balance, symmetry, volume, and the shape that Talus itself computed."""
import sys
from pathlib import Path

import numpy as np

FOLDER = Path(__file__).resolve().parent
sys.path.insert(0, str(FOLDER.parent))
import common  # noqa: E402
from common import Quantity  # noqa: E402

HALF_WIDTH, HEIGHT = 0.9, 1.8  # m
DENSITY, GRAVITY = 1000.0, 10.0  # kg/m3, m/s2
SHAPE_REACH = 0.01  # of the height or half width, for cells up to 0.18 m


def top_edge(state, initial):
    """Height of the deformed body on its axis: the highest point's centre and half of its domain."""
    start = initial["position0"]
    point = np.argmin(np.linalg.norm(start - [0.0, 0.0, HEIGHT], axis=1))
    return state["position"][point, 2] + state["F"][point, 8] * (HEIGHT - start[point, 2])


def half_width(state):
    """Half the width of the deformed body where it is widest, at the points' centres."""
    return state["position"][:, 0].max()


def asymmetry(state, initial):
    """Largest difference between the displacements of points that are each other's image in the plane x = y."""
    start, displacement = initial["position0"], state["displacement"]
    order = np.lexsort(np.round(start, 9).T)
    image = np.lexsort(np.round(start[:, [1, 0, 2]], 9).T)
    return np.max(np.abs(displacement[order] - displacement[image][:, [1, 0, 2]]))


def check(results):
    state, initial = results.state("last"), results.initial
    mass = DENSITY * HALF_WIDTH**2 * HEIGHT
    return [
        common.completed(results),
        Quantity.near("mass", state["mass"].sum(), mass, relative=1e-9),
        Quantity.near("base_reaction", results.column("reaction_base_z")[-1], mass * GRAVITY, relative=1e-6),
        Quantity("asymmetry", asymmetry(state, initial) / HEIGHT, None, 1e-6),
        Quantity("smallest_volume_ratio", np.linalg.det(state["F"].reshape(-1, 3, 3)).min(), 0.0),
        Quantity.near("height", top_edge(state, initial) / HEIGHT, 0.705, absolute=SHAPE_REACH),
        Quantity.near("half_width", half_width(state) / HALF_WIDTH, 1.193, absolute=SHAPE_REACH),
    ]


def mirrored(points):
    """The whole block from its quarter."""
    return np.concatenate([points * [sx, sy, 1.0] for sx in (-1.0, 1.0) for sy in (-1.0, 1.0)])


def draw(results):
    """The whole block before and after, coloured by how far each point has come down."""
    import matplotlib.pyplot as plt

    state, initial = results.state("last"), results.initial
    down = np.tile(-state["displacement"][:, 2], 4)
    figure = plt.figure(figsize=(11.0, 4.8))
    wide = 2.2 * half_width(state)
    side = 2.0 * HALF_WIDTH / np.cbrt(8.0 * len(state["position"]) / 2.0)
    for column, (position, title) in enumerate(((initial["position0"], "before"), (state["position"], "after"))):
        axes = figure.add_subplot(1, 2, column + 1, projection="3d")
        axes.set_proj_type("ortho")
        axes.view_init(elev=18, azim=-55)
        axes.set(xlim=(-wide / 2, wide / 2), ylim=(-wide / 2, wide / 2), zlim=(0.0, HEIGHT), title=title)
        axes.set(xlabel="x (m)", ylabel="y (m)", zlabel="z (m)", box_aspect=(wide, wide, HEIGHT),
                 xticks=(-1, 0, 1), yticks=(-1, 0, 1), zticks=(0.0, 0.6, 1.2, 1.8))
        size = (2.2 * side * 72.0 * 3.2 / wide) ** 2
        body = axes.scatter(*mirrored(position).T, c=down, s=size, cmap="viridis", vmin=0.0, depthshade=False,
                            linewidths=0)
    figure.colorbar(body, ax=figure.axes, shrink=0.7, pad=0.08, label="way down (m)")
    return figure


if __name__ == "__main__":
    common.main(check, draw)
