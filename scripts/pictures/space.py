"""A state in space: the faces of the domains at the material's surface, with light from above."""

import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.colors import ListedColormap, Normalize
from matplotlib.patches import Patch
from matplotlib.ticker import MaxNLocator
from mpl_toolkits.mplot3d.art3d import Poly3DCollection

from . import style
from .domains import deformation, frame_of, half_lengths, join, number_corners
from .fields import Scale

MARGIN = 0.02
VIEW = {"elev": 22, "azim": -60}  # degrees
LIGHT = np.array([0.35, -0.55, 0.76])  # direction to the light, of length one
FACES = np.array([[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]])
NORMALS = np.array([[0, 0, -1], [0, 0, 1], [0, -1, 0], [0, 1, 0], [-1, 0, 0], [1, 0, 0]])
BOX = np.array([[x, y, z] for z in (-1.0, 1.0) for y in (-1.0, 1.0) for x in (-1.0, 1.0)])


def space_corners(results, state, arguments):
    """Corners of the domains, (points, 8, 3)."""
    origin = results.origin(state)
    if arguments.initial:
        return origin.position[:, None] + 0.5 * BOX * origin.lengths[:, None]
    local = BOX * half_lengths(state, origin)[:, None]
    corners = state["position"][:, None] + np.einsum("pij,pkj->pki", deformation(state), local)
    number = number_corners(
        origin.position[:, None] + 0.5 * BOX * origin.lengths[:, None], origin.lengths, np.zeros(len(corners), int)
    )
    corners = join(corners, number, origin.lengths.min(axis=1))
    if arguments.scale == 1.0:
        return corners
    move = np.repeat(state["displacement"][:, None], len(BOX), axis=1)
    return corners + (arguments.scale - 1.0) * join(move, number, np.full(len(corners), np.inf))


def space_frame(results, state, arguments):
    return frame_of(space_corners(results, state, arguments), MARGIN)


def shell(origin):
    """Indices of the points that had no neighbour on one of their six sides at first."""
    lattice = np.rint((origin.position - origin.position.min(axis=0)) / origin.lengths.min(axis=0)).astype(np.int64)
    shape = lattice.max(axis=0) + 3
    code = np.ravel_multi_index((lattice + 1).T, shape)
    inner = [np.isin(np.ravel_multi_index((lattice + 1 + step).T, shape), code) for step in NORMALS]
    return np.flatnonzero(~np.all(inner, axis=0))


def view_direction():
    """Unit vector from the scene to the eye."""
    elevation, azimuth = np.radians(VIEW["elev"]), np.radians(VIEW["azim"])
    return np.array([np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation)])


def draw_space(axes, results, state, values, scale, arguments, frame=None):
    """The faces at the surface that look at the eye; `values` by point."""
    corners, origin = space_corners(results, state, arguments), results.origin(state)
    lower, upper = frame if frame else frame_of(corners, MARGIN)
    axes.set_proj_type("ortho")
    axes.view_init(**VIEW)
    axes.set_box_aspect(upper - lower, zoom=0.92)
    axes.set(xlim=(lower[0], upper[0]), ylim=(lower[1], upper[1]), zlim=(lower[2], upper[2]))
    point = np.repeat(shell(origin), len(FACES))
    polygons = corners[point[:, None], np.tile(FACES, (len(point) // len(FACES), 1))]
    normal = np.cross(polygons[:, 2] - polygons[:, 0], polygons[:, 3] - polygons[:, 1])
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-300)
    seen = normal @ view_direction() > 0.0
    shade = 0.72 + 0.28 * np.clip(normal[seen] @ LIGHT, 0.0, 1.0)
    colours = ScalarMappable(Normalize(scale.low, scale.high), scale.colours).to_rgba(values[point[seen]])
    colours[:, :3] *= shade[:, None]
    axes.add_collection3d(Poly3DCollection(polygons[seen], facecolors=colours, edgecolors=colours, linewidths=0.4))
    axes.set(xlabel="x (m)", ylabel="y (m)", zlabel="z (m)")
    for axis in (axes.xaxis, axes.yaxis, axes.zaxis):
        axis.set_major_locator(MaxNLocator(4))
        axis.set_pane_color((0.97, 0.97, 0.97, 1.0))
        axis.label.set_fontsize(style.SMALL)
    return axes


def draw_space_groups(axes, results, state, groups, arguments, frame=None):
    """The surface by names, as of materials or bodies, with a legend; `groups`: (number of each point, names)."""
    numbers, labels = groups
    count = max(len(labels), 1)
    colours = ListedColormap([style.material_colour(k) for k in range(count)])
    draw_space(axes, results, state, numbers.astype(float), Scale(colours, -0.5, count - 0.5), arguments, frame)
    handles = [
        Patch(facecolor=style.material_colour(k), edgecolor=style.INK, linewidth=0.5, label=labels[k])
        for k in range(len(labels))
        if np.any(numbers == k)
    ]
    axes.legend(handles=handles, loc="lower center", bbox_to_anchor=(0.5, -0.14), ncols=min(len(handles), 5))
