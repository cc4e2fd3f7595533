"""A state in the plane: the material as one body coloured by a field, outlines of bodies, contour lines, arrows."""

from collections import namedtuple

import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection, PathCollection
from matplotlib.colors import ListedColormap, Normalize
from matplotlib.path import Path
from matplotlib.ticker import MaxNLocator
from matplotlib.tri import Triangulation

from results import ResultsError

from . import style
from .domains import Region, first_domains, frame_of, moved_domains, outline
from .fields import Scale, colour_scale
from .scene import Scene

MARGIN = 0.06  # of the larger extent, around the material
ARROWS = 16  # along the longer side
LEVELS = 256  # of colours
PAINTED = 4000  # domains, more of which are stored as an image in vector formats

# What a state looks like: its points, where they were first, the body of each, the domains, limits of the axes, and
# edges of the material at first (None where it is drawn there).
Look = namedtuple("Look", "state origin body domains frame start")


def look_at(results, scene, state, deformed=True, scale=1.0):
    """Geometry of a state in the plane; see Look. What the first places say is kept until the points change."""
    origin = results.origin(state)
    key = state["id"].tobytes(), origin.lengths.tobytes()
    if key not in scene.memo:
        body, regions, part = bodies_of(scene, state, origin)
        first = first_domains(origin, regions, part)
        scene.memo.clear()
        scene.memo[key] = body, first, outline(first, np.zeros(len(body), int))[0]
    body, first, edges = scene.memo[key]
    found = moved_domains(first, state, origin, scale) if deformed else first
    corners = np.concatenate([found.corners.reshape(-1, 2), first.corners.reshape(-1, 2)])
    return Look(state, origin, body, found, frame_of(corners, MARGIN), edges if deformed else None)


def bodies_of(scene, state, origin):
    """The body of each point, outlines of regions with their points, and numbers that differ across contacts."""
    count = len(origin.position)
    if not scene.options:
        return np.zeros(count, int), [], None
    body = scene.body_of_points(state, origin)
    regions, bodies = [], scene.bodies()
    for number, one in enumerate(bodies):
        low, high = scene.clip(f"body_{one.name}")
        own = np.flatnonzero(body == number)
        if (
            one.polygon is None
            or scene.get(f"body_{one.name}_region") == "box"
            or np.isfinite([low, high]).any()
            or not len(own)
        ):
            continue
        usual = np.median(origin.lengths[own], axis=0)
        alike = np.all(
            np.abs(origin.lengths[own] - usual) < 1e-4 * usual, axis=1
        )  # without what fills a gap below the body
        replaced = [
            other.polygon
            for other in bodies
            if other.polygon is not None and other is not one and scene.get(f"body_{other.name}_priority") == "true"
        ]
        regions.append(
            Region(one.polygon, own[alike & scene.contains(f"body_{one.name}", origin.position[own])], replaced)
        )
    return body, regions, body if scene.list("contacts") else None


def paths_of(corners, level):
    """One path for all domains of a level, and the levels: thousands of domains are drawn as a few hundred paths."""
    width, order = corners.shape[1], np.argsort(level, kind="stable")
    closed = np.concatenate([corners, corners[:, :1]], axis=1)[order]
    codes = np.full(width + 1, Path.LINETO, Path.code_type)
    codes[0], codes[-1] = Path.MOVETO, Path.CLOSEPOLY
    levels, begin = np.unique(level[order], return_index=True)
    ends = np.append(begin[1:], len(order))
    return [Path(closed[a:b].reshape(-1, 2), np.tile(codes, b - a)) for a, b in zip(begin, ends)], levels


def paint(axes, look, values, scale):
    """The material by colour; the collection, for a colour bar."""
    share = (np.asarray(values, float)[look.domains.owner] - scale.low) / (scale.high - scale.low)
    level = np.where(np.isfinite(share), np.clip(LEVELS * np.nan_to_num(share), 0, LEVELS - 1), -1).astype(int)
    paths, levels = paths_of(look.domains.corners, level)
    middle = np.where(levels < 0, np.nan, scale.low + (levels + 0.5) / LEVELS * (scale.high - scale.low))
    filled = PathCollection(paths, array=middle, cmap=scale.colours, **solid(look))
    filled.set_clim(scale.low, scale.high)
    axes.add_collection(filled, autolim=False)
    return filled


def solid(look):
    """Properties of domains without hairlines between them."""
    return {
        "edgecolors": "face",
        "linewidths": 0.35,
        "antialiased": False,
        "rasterized": len(look.domains.owner) > PAINTED,
        "zorder": 2,
    }


def draw_outlines(axes, look, first_places=True):
    """Edges of the bodies, and in grey where the material was."""
    if first_places and look.start is not None:
        axes.add_collection(LineCollection(look.start, colors=style.SOFT, linewidths=0.6, zorder=1), autolim=False)
    segments, _ = outline(look.domains, look.body)
    axes.add_collection(
        LineCollection(segments, colors=style.INK, linewidths=0.6, capstyle="round", zorder=3), autolim=False
    )


def set_frame(axes, frame, axial=False):
    axes.set(xlim=(frame[0][0], frame[1][0]), ylim=(frame[0][1], frame[1][1]), aspect="equal")
    axes.set(xlabel="radius x (m)" if axial else "x (m)", ylabel="y (m)")
    extent = frame[1] - frame[0]
    for axis, share in zip((axes.xaxis, axes.yaxis), extent / extent.max()):
        axis.get_major_locator().set_params(nbins=2 if share < 0.25 else 4 if share < 0.5 else 7)


def draw_body(axes, results, state, values, scale=None, deformed=True):
    """The material in given axes by `values`; `scale`: (colour map, low, high). The collection, for a colour bar."""
    scene = Scene(results)
    look = look_at(results, scene, state, deformed)
    filled = paint(axes, look, values, Scale(*scale) if scale else colour_scale(np.asarray(values)))
    draw_outlines(axes, look, deformed)
    set_frame(axes, look.frame, scene.axial)
    return filled


def draw_plane(figure, results, state, values, scale=None, deformed=True):
    """New axes with the material, see draw_body(); axes and collection."""
    axes = figure.add_subplot()
    return axes, draw_body(axes, results, state, values, scale, deformed)


def draw_groups(axes, look, numbers, labels):
    """The material by names, as of materials or bodies, with a legend; numbers without a name are grey."""
    colours = ListedColormap([style.material_colour(k) for k in range(len(labels))] + ["0.9"])
    values = np.where((numbers >= 0) & (numbers < len(labels)), numbers, len(labels))
    paths, numbers_there = paths_of(look.domains.corners, values[look.domains.owner])
    axes.add_collection(PathCollection(paths, facecolors=colours(numbers_there), **solid(look)), autolim=False)
    return [(style.material_colour(k), labels[k]) for k in range(len(labels)) if np.any(numbers == k)]


def corner_mesh(look, values):
    """Triangles of the domains, and the field at their corners: the mean over the domains that share one."""
    found, count = look.domains, look.domains.number.max() + 1
    number, width = found.number, found.number.shape[1]
    weight = np.bincount(number.ravel(), minlength=count)
    mean = np.bincount(number.ravel(), np.repeat(np.asarray(values)[found.owner], width), count) / weight
    place = (
        np.stack([np.bincount(number.ravel(), found.corners[..., axis].ravel(), count) for axis in range(2)], axis=1)
        / weight[:, None]
    )
    fans = np.concatenate([number[:, [0, k, k + 1]] for k in range(1, width - 1)])
    fans = fans[(fans[:, 0] != fans[:, 1]) & (fans[:, 1] != fans[:, 2]) & (fans[:, 0] != fans[:, 2])]
    return Triangulation(*place.T, triangles=fans), mean


def draw_contours(axes, look, values, scale, count):
    """Contour lines of a field, with numbers on them."""
    levels = MaxNLocator(count).tick_values(scale.low, scale.high)
    mesh, mean = corner_mesh(look, values)
    lines = axes.tricontour(mesh, mean, levels=levels, colors="0.15", linewidths=0.5, zorder=4)
    axes.clabel(lines, fontsize=6.0, inline_spacing=2, fmt=lambda value: f"{value:.4g}")


def draw_arrows(axes, look, name):
    """Arrows of a vector field on an even lattice of places; the largest has the lattice's spacing."""
    vectors = look.state[name]
    if vectors.ndim != 2 or vectors.shape[1] not in (2, 3):
        raise ResultsError(f"--arrows {name}: this field is no vector")
    vectors = vectors[:, :2]
    lower, upper = look.state["position"].min(axis=0), look.state["position"].max(axis=0)
    spacing = max(np.max(upper - lower) / ARROWS, look.origin.lengths.max())
    cell = np.floor((look.state["position"] - lower) / spacing).astype(int)
    code = cell[:, 0] * (cell[:, 1].max() + 1) + cell[:, 1]
    away = np.linalg.norm(look.state["position"] - lower - (cell + 0.5) * spacing, axis=1)
    order = np.lexsort((away, code))
    chosen = order[np.unique(code[order], return_index=True)[1]]
    size = np.max(np.linalg.norm(vectors[chosen], axis=1), initial=0.0)
    if size > 0.0:
        axes.quiver(
            *look.state["position"][chosen].T,
            *vectors[chosen].T,
            angles="xy",
            scale_units="xy",
            scale=size / spacing,
            units="inches",
            width=0.014,
            pivot="mid",
            color=style.INK,
            edgecolor="white",
            linewidth=0.3,
            zorder=6,
        )
    return size


def bar(figure, axes, scale, label, **options):
    """A colour bar for one or several axes."""
    mappable = ScalarMappable(Normalize(scale.low, scale.high), scale.colours)
    return figure.colorbar(mappable, ax=axes, label=label, aspect=25, **{"shrink": 0.85, "pad": 0.03, **options})
