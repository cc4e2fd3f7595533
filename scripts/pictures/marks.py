"""What acts on the material in the plane, and names: conditions, loads, boundaries, water, tracks, bodies."""

import numpy as np
from matplotlib.collections import LineCollection
from matplotlib.patches import Polygon

from . import style, units
from .domains import outline

SIZE = 0.022  # of the frame's larger extent: a symbol
ARROW = 0.075  # of it: an arrow
TEXT, LETTER = 0.05, 0.018  # of it: a line of text, and the width of a letter
REACH = 0.75  # of a domain: a line of nodes is at the material's edge
ARROWS = 9  # at most, along one surface
CLOSE = 0.1  # of it: names would overlap
RIGHT = 0.85  # of its width: names further right stand on the left of their place
NAMED_BODIES = 14  # more of them have no names in the picture
SIDES = {"-x": (0, -1), "+x": (0, 1), "-y": (1, -1), "+y": (1, 1)}


def unit_of(look):
    """The frame's larger extent, which symbols are sized by."""
    return float(np.max(look.frame[1] - look.frame[0]))


def name_bodies(axes, look, scene):
    """Each body's name in its middle."""
    bodies = scene.bodies()
    shown = [number for number in range(len(bodies)) if np.any(look.body == number)]
    if not 1 < len(shown) <= NAMED_BODIES:
        return
    for number in shown:
        place = look.domains.corners[look.body[look.domains.owner] == number].mean(axis=1)
        middle = place.mean(axis=0)
        away = np.linalg.norm(place - middle, axis=1)
        inside = away.min() < look.origin.lengths.max()
        style.name(axes, *(middle if inside else place[np.argmin(away)]), bodies[number].name)


# ---- conditions ----


def condition_line(look, scene, name):
    """Where a condition holds the material's edge: (axis across, its place, from, to); None without a straight line."""
    low, high = scene.vector(f"bc_{name}_lower"), scene.vector(f"bc_{name}_upper")
    if scene.get(f"bc_{name}_region") != "box" or len(low) != 2:
        return None
    cell = (scene.vector("grid_upper") - scene.vector("grid_lower")) / scene.vector("grid_cells")
    thin = [axis for axis in range(2) if high[axis] - low[axis] < 0.5 * cell[axis]]
    if len(thin) != 1:
        return edge_within(look, low, high, cell)
    axis, along = thin[0], 1 - thin[0]
    place = 0.5 * (low[axis] + high[axis])
    corners = look.domains.corners.reshape(-1, 2)
    near = np.abs(corners[:, axis] - place) < REACH * look.origin.lengths[:, axis].max()
    near &= (corners[:, along] > low[along] - cell[along]) & (corners[:, along] < high[along] + cell[along])
    if not near.any():
        return None
    return axis, place, max(corners[near, along].min(), low[along]), min(corners[near, along].max(), high[along])


def edge_within(look, low, high, cell):
    """The material's edge in a box that reaches beyond it, as condition_line() says it; None where there is more."""
    reach = 1e-3 * look.origin.lengths.min()
    first = look.domains.start.reshape(-1, 2)
    inside = np.all((first >= low - reach) & (first <= high + reach), axis=1)
    flat = [axis for axis in range(2) if inside.any() and np.ptp(first[inside, axis]) < 0.5 * cell[axis]]
    if len(flat) != 1:
        return None
    axis, now = flat[0], look.domains.corners.reshape(-1, 2)[inside]
    return axis, now[:, axis].mean(), now[:, 1 - axis].min(), now[:, 1 - axis].max()


def draw_conditions(axes, look, scene, stage, time):
    """Ticks where both components are prescribed, rollers where the one across the edge is; arrows of motion."""
    size = unit_of(look) * SIZE
    middle = look.state["position"].mean(axis=0)
    for name in scene.active("bcs", stage):
        line = condition_line(look, scene, name)
        components = set(scene.list(f"bc_{name}_components"))
        if not line or not components & {"x", "y"}:
            continue
        axis, place, start, end = line
        outward = 1.0 if place > middle[axis] else -1.0
        if end - start <= 0.0:
            start, end = start - size, end + size
        draw_support(axes, (axis, place, start, end), outward * size, components)
        draw_prescribed(axes, scene, name, line, time, unit_of(look))


def at(axis, across, along):
    """Places (n, 2) from their coordinate across an edge and along it."""
    across, along = np.broadcast_arrays(np.asarray(across, float), np.asarray(along, float))
    return np.stack([across, along] if axis == 0 else [along, across], axis=-1)


def draw_support(axes, line, size, components):
    axis, place, start, end = line
    count = max(int((end - start) / (1.6 * abs(size))), 1)
    along = start + (np.arange(count) + 0.5) * (end - start) / count
    options = {"colors": style.FIXED, "linewidths": 0.7, "zorder": 5}
    if components >= {"x", "y"}:
        ticks = np.stack(
            [at(axis, place, along + 0.4 * abs(size)), at(axis, place + size, along - 0.4 * abs(size))], axis=1
        )
        axes.add_collection(LineCollection(ticks, **options), autolim=False)
    elif "xy"[axis] in components:
        angle = np.linspace(0.0, 2.0 * np.pi, 17)
        rings = at(axis, place + 0.4 * size, along)[:, None] + 0.36 * abs(size) * np.column_stack(
            [np.cos(angle), np.sin(angle)]
        )
        rail = at(axis, place + 0.85 * size, np.array([start, end]))[None]
        axes.add_collection(LineCollection(list(rings) + list(rail), **options), autolim=False)
    else:  # only the one along the edge
        ticks = np.stack([at(axis, place, along), at(axis, place + 0.8 * size, along)], axis=1)
        axes.add_collection(LineCollection(ticks, **options), autolim=False)
    edge = at(axis, place, np.array([start, end]))[None]
    axes.add_collection(LineCollection(edge, **{**options, "linewidths": 1.1}), autolim=False)


def draw_prescribed(axes, scene, name, line, time, extent):
    """An arrow, with its size, where a condition moves the material."""
    from .scene import ramp

    values, components = scene.vector(f"bc_{name}_value"), scene.list(f"bc_{name}_components")
    if (
        scene.get(f"bc_{name}_quantity", "displacement") != "displacement"
        or not np.any(values)
        or scene.get(f"bc_{name}_table")
    ):
        return
    factor = ramp(scene.get(f"bc_{name}_ramp", "0:1"), time) if time is not None else 1.0
    move = np.array([dict(zip(components, values)).get(axis, 0.0) for axis in "xy"])
    if not np.any(move):
        return
    axis, place, start, end = line
    direction = move / np.linalg.norm(move)
    middle = at(axis, place, 0.5 * (start + end))
    arrow(axes, middle - ARROW * extent * direction, middle, units.amount(factor * np.linalg.norm(move), "m"))


# ---- loads ----


def arrow(axes, tail, tip, text=None):
    """An arrow with a text at its tail."""
    axes.annotate(
        "",
        tip,
        tail,
        arrowprops={
            "arrowstyle": "-|>,head_width=0.18,head_length=0.35",
            "color": style.LOAD,
            "linewidth": 0.9,
            "shrinkA": 0,
            "shrinkB": 0,
        },
        zorder=7,
    )
    if text:
        style.name(axes, *tail, text, color=style.LOAD, va="bottom" if tail[1] >= tip[1] else "top", clip_on=True)


def even_row(places):
    """Places of an edge, at most ARROWS of them and evenly spaced along it."""
    axis = int(np.argmax(np.ptp(places, axis=0)))
    order = np.argsort(places[:, axis], kind="stable")
    along, across = places[order, axis], places[order, 1 - axis]
    if len(np.unique(np.round(along, 9))) <= ARROWS:
        return places[order]
    even = np.linspace(along[0], along[-1], ARROWS)
    row = np.empty((ARROWS, 2))
    row[:, axis], row[:, 1 - axis] = even, np.interp(even, along, across)
    return row


def draw_row(axes, places, direction, extent, text):
    """Arrows that push or pull at places of an edge, and one text."""
    chosen = even_row(places)
    for k, place in enumerate(chosen):
        arrow(axes, place - ARROW * extent * direction, place, text if k == len(chosen) // 2 else None)


def draw_loads(axes, look, scene, stage, time):
    """Forces and tractions at the points that carry them; gravity acts everywhere and is not drawn."""
    from .scene import ramp

    extent = unit_of(look)
    for name in scene.active("loads", stage):
        kind, value = scene.get(f"load_{name}_type"), scene.vector(f"load_{name}_value")
        factor = ramp(scene.get(f"load_{name}_ramp", "0:0,1:1"), time) if time is not None else 1.0
        if kind not in ("force", "traction") or len(value) < 2 or not np.any(value):
            continue
        places = loaded_places(look, scene, f"load_{name}", kind == "traction")
        direction = value[:2] / np.linalg.norm(value[:2])
        unit = "Pa" if kind == "traction" else "N" if scene.axial else "N/m"
        if len(places):
            draw_row(
                axes,
                places if kind == "traction" else places.mean(axis=0)[None],
                np.sign(factor or 1.0) * direction,
                extent,
                units.amount(abs(factor) * np.linalg.norm(value[:2]), unit),
            )


def loaded_places(look, scene, block, faces):
    """Places of a load: the points that carry it, or the middles of their faces."""
    origin = look.origin.position
    if scene.is_given(f"{block}_at"):
        away = np.linalg.norm(origin - scene.vector(f"{block}_at"), axis=1)
        rows = np.argsort(away, kind="stable")[: int(scene.get(f"{block}_nearest", "1"))]
        return look.state["position"][rows]
    reach = 0.55 * look.origin.lengths.max() if faces else 1e-3 * look.origin.lengths.min()
    rows = np.flatnonzero(scene.contains(block, origin, reach))
    side = scene.get(f"{block}_face")
    if not faces or side not in SIDES:
        return look.state["position"][rows]
    axis, sign = SIDES[side]
    places = look.state["position"][rows].copy()
    places[:, axis] += sign * 0.5 * look.origin.lengths[rows, axis]
    return places


def surface_edges(look, scene, name):
    """Edges of a body's surface: (middles, outward normals, segments)."""
    names = [body.name for body in scene.bodies()]
    body = scene.get(f"surface_{name}_body")
    segments, domain = outline(look.domains, np.zeros(len(look.body), int))
    owner = look.domains.owner[domain]
    chosen = look.body[owner] == names.index(body) if body in names else np.ones(len(owner), bool)
    along = segments[:, 1] - segments[:, 0]
    normal = np.column_stack([along[:, 1], -along[:, 0]])
    middle = segments.mean(axis=1)
    inner = look.domains.corners[domain].mean(axis=1)
    normal *= np.sign(np.einsum("ij,ij->i", normal, middle - inner))[:, None]
    normal /= np.maximum(np.linalg.norm(normal, axis=1), 1e-300)[:, None]
    side = scene.get(f"surface_{name}_side", "all")
    if side in SIDES:
        axis, sign = SIDES[side]
        chosen &= sign * normal[:, axis] > 0.7
    if scene.get(f"surface_{name}_region", "all") != "all":
        chosen &= scene.contains(f"surface_{name}", look.origin.position[owner], look.origin.lengths.max())
    return middle[chosen], normal[chosen], segments[chosen]


def draw_surfaces(axes, look, scene, stage, time):
    """Drained surfaces as blue lines, loaded ones by arrows."""
    from .scene import ramp

    extent = unit_of(look)
    for name in scene.active("surfaces", stage):
        middle, normal, segments = surface_edges(look, scene, name)
        if not len(middle):
            continue
        if scene.get(f"surface_{name}_drained", "false") == "true" or scene.get(f"surface_{name}_pressure"):
            axes.add_collection(LineCollection(segments, colors=style.WATER, linewidths=2.0, zorder=5), autolim=False)
        factor = ramp(scene.get(f"surface_{name}_ramp", "0:1"), time) if time is not None else 1.0
        value = scene.vector(f"surface_{name}_traction")
        if np.any(value):
            draw_row(
                axes,
                middle,
                value[:2] / np.linalg.norm(value[:2]),
                extent,
                units.amount(factor * np.linalg.norm(value[:2]), "Pa"),
            )
        stress = scene.get(f"surface_{name}_normal")
        if stress and float(stress):
            rows = np.unique(np.linspace(0, len(middle) - 1, min(ARROWS, len(middle))).round().astype(int))
            for k, row in enumerate(rows):
                push = np.sign(float(stress)) * normal[row]
                tail, tip = (
                    (middle[row] - ARROW * extent * push, middle[row])
                    if float(stress) < 0.0
                    else (middle[row], middle[row] + ARROW * extent * push)
                )
                arrow(axes, tail, tip, units.amount(abs(factor * float(stress)), "Pa") if k == len(rows) // 2 else None)


# ---- boundaries, water, tracks ----


def draw_plane_boundary(axes, look, scene, name, line):
    """A plane as a line, with ticks on the side without material, and its name."""
    extent = unit_of(look)
    normal = scene.vector(f"boundary_{name}_normal")
    normal, along = normal / np.linalg.norm(normal), (line[1] - line[0]) / np.linalg.norm(line[1] - line[0])
    steps = np.arange(0.0, np.linalg.norm(line[1] - line[0]), 1.6 * SIZE * extent)[:, None]
    start = line[0] + steps * along
    seen = start[np.all((start > look.frame[0]) & (start < look.frame[1]), axis=1)]
    ticks = np.stack([seen, seen - SIZE * extent * (0.7 * normal + 0.7 * along)], axis=1)
    axes.add_collection(
        LineCollection(np.concatenate([line[None], ticks]), colors=style.RIGID, linewidths=0.8, zorder=4), autolim=False
    )
    if len(seen):
        style.name(axes, *(seen[len(seen) // 2] - 2.0 * SIZE * extent * normal), name)


def draw_boundaries(axes, look, scene, time, step=None):
    """Rigid bodies in grey, planes as lines."""
    extent = unit_of(look)
    for name in scene.list("boundaries"):
        kind, found = scene.get(f"boundary_{name}_type"), scene.boundary_outline(name, time or 0.0, 2.0 * extent, step)
        if found is None:
            continue
        corners, closed = found
        if kind == "plane":
            draw_plane_boundary(axes, look, scene, name, corners)
            continue
        solid = kind == "cone" or (closed and scene.get(f"boundary_{name}_side", "outside") == "outside")
        axes.add_patch(
            Polygon(
                corners,
                closed=solid or closed,
                facecolor="0.82" if solid else "none",
                edgecolor=style.RIGID,
                linewidth=1.0,
                zorder=3.5 if solid else 4,
                clip_on=True,
            )
        )
        seen = np.all((corners >= look.frame[0]) & (corners <= look.frame[1]), axis=1)
        if solid and seen.any():
            place = np.clip(corners.mean(axis=0), look.frame[0] + 0.04 * extent, look.frame[1] - 0.04 * extent)
            style.name(axes, *place, name)


def draw_water(axes, look, scene, time):
    """The water level as a line, with the usual triangle."""
    line = scene.water_line(time or 0.0, look.frame[0][0], look.frame[1][0])
    if line is None:
        return
    axes.plot(*line.T, color=style.WATER, linewidth=1.0, linestyle=(0, (5, 2)), zorder=6, scalex=False, scaley=False)
    x = look.frame[0][0] + 0.1 * (look.frame[1][0] - look.frame[0][0])
    y = np.interp(x, *line.T)
    axes.plot(
        [x],
        [y + 0.012 * unit_of(look)],
        marker="v",
        color=style.WATER,
        markersize=5,
        zorder=6,
        scalex=False,
        scaley=False,
    )


def draw_tracks(axes, look, scene):
    """Places that are followed, with their names; names of places close to each other stand on either side."""
    extent, before = unit_of(look), []
    for name in scene.list("tracks"):
        if not scene.is_given(f"track_{name}_at"):
            continue
        away = np.linalg.norm(look.origin.position - scene.vector(f"track_{name}_at"), axis=1)
        place = look.state["position"][
            np.argsort(away, kind="stable")[: int(scene.get(f"track_{name}_nearest", "1"))]
        ].mean(axis=0)
        axes.plot(
            *place,
            marker="o",
            markersize=3.5,
            markerfacecolor="white",
            markeredgecolor=style.INK,
            zorder=7,
            scalex=False,
            scaley=False,
        )
        crowded = place[0] > look.frame[0][0] + RIGHT * (look.frame[1] - look.frame[0])[0]
        side = -1.0 if crowded or any(np.linalg.norm(place - other) < CLOSE * extent for other in before) else 1.0
        before.append(place)
        style.name(
            axes,
            place[0] + side * 0.012 * extent,
            place[1] + 0.012 * extent,
            name,
            ha="left" if side > 0.0 else "right",
            va="bottom",
        )


class Reach:
    """Takes the place of axes, and keeps how far arrows and texts reach."""

    def __init__(self, extent):
        self.places, self.extent = [], extent

    def annotate(self, _text, tip, tail, **_options):
        self.places += [tip, tail]

    def add_collection(self, collection, autolim=True):
        """Symbols of conditions lie within the margin."""

    def text(self, x, y, words, **_options):
        """A text in the middle of its place, beside the margin that all have."""
        half = max(0.5 * LETTER * len(words) - TEXT, 0.0) * self.extent
        self.places += [np.array([x - half, y]), np.array([x + half, y])]


def widen(look, scene, time, stage):
    """The look with a frame that holds all arrows and their texts."""
    extent = unit_of(look)
    reach = Reach(extent)
    draw_conditions(reach, look, scene, stage, time)
    draw_surfaces(reach, look, scene, stage, time)
    draw_loads(reach, look, scene, stage, time)
    if not reach.places:
        return look
    places = np.array(reach.places)
    lower, upper = places.min(axis=0) - TEXT * extent, places.max(axis=0) + TEXT * extent
    return look._replace(frame=(np.minimum(look.frame[0], lower), np.maximum(look.frame[1], upper)))


def draw_marks(axes, look, scene, time, stage=None, names=True):
    """All that acts in a stage; with the names of the bodies."""
    draw_water(axes, look, scene, time)
    draw_boundaries(axes, look, scene, time, look.state.step)
    draw_conditions(axes, look, scene, stage, time)
    draw_surfaces(axes, look, scene, stage, time)
    draw_loads(axes, look, scene, stage, time)
    if names:
        name_bodies(axes, look, scene)
