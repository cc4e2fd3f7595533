"""The points' domains in the plane, as one body without gaps.

A domain is a box of the first lattice, or the part of it within the body's region. Its corners move by the point's own
F; corners that domains shared at first are drawn at their mean, as long as the body holds together there."""

from collections import namedtuple

import numpy as np

SQUARE = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
APART = 0.5  # of a domain's edge: corners further from their mean belong to material that has parted
CORNER = 1e-3  # of a domain's edge: corners nearer to each other are one
SLIVER = 1e-6  # of a domain: less of a region is left out

# Domains: corners (n, m, 2), short ones with their last corner repeated; `owner`: the point of each; `start`: the
# corners at first; `number`: of each corner, alike where shared.
Domains = namedtuple("Domains", "corners owner start number")


# A body's region in the plane: its outline, rows of its points, and outlines of bodies that replace it.
Region = namedtuple("Region", "polygon rows replaced")


def deformation(state):
    """F in the plane, (points, dim, dim)."""
    dim = state.dim
    if "F" not in state:
        return np.broadcast_to(np.eye(dim), (len(state["position"]), dim, dim))
    return state["F"].reshape(-1, 3, 3)[:, :dim, :dim]


def half_lengths(state, origin):
    return state["half_length"] if "half_length" in state else 0.5 * origin.lengths


def domain_polygons(state, origin, deformed):
    """Corners of each point's own domain, (points, 4, 2): the box at first, or what F makes of it."""
    if not deformed:
        return origin.position[:, None, :] + 0.5 * SQUARE * origin.lengths[:, None, :]
    return state["position"][:, None, :] + np.einsum(
        "pij,pkj->pki", deformation(state), SQUARE * half_lengths(state, origin)[:, None, :]
    )


def clip_half(corners, axis, sign, end):
    """The part of a polygon with sign * x[axis] <= sign * end (Sutherland and Hodgman 1974)."""
    kept = []
    for a, b in zip(corners, corners[1:] + corners[:1]):
        within = sign * (a[axis] - end) <= 0.0, sign * (b[axis] - end) <= 0.0
        if within[0]:
            kept.append(a)
        if within[0] != within[1]:
            share = (end - a[axis]) / (b[axis] - a[axis])
            cut = [a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1])]
            cut[axis] = end
            kept.append(cut)
    return kept


def clip(polygon, low, high):
    """The part of a polygon within a box, as a list of corners; empty where they do not meet."""
    corners = [list(corner) for corner in polygon]
    for axis in (0, 1):
        for sign, end in ((1.0, high[axis]), (-1.0, low[axis])):
            corners = clip_half(corners, axis, sign, end) if corners else []
    return corners


def in_polygon(place, corners, reach=0.0):
    """Which places lie inside a polygon or within `reach` of its edges; by crossings of a ray."""
    inside, near = np.zeros(len(place), bool), np.zeros(len(place), bool)
    for a, b in zip(corners, np.roll(corners, -1, axis=0)):
        edge, from_a = b - a, place - a
        crosses = (a[1] > place[:, 1]) != (b[1] > place[:, 1])
        with np.errstate(divide="ignore", invalid="ignore"):
            inside ^= crosses & (place[:, 0] < a[0] + edge[0] * from_a[:, 1] / edge[1])
        if reach > 0.0:
            along = np.clip(from_a @ edge / max(edge @ edge, 1e-300), 0.0, 1.0)
            near |= np.linalg.norm(from_a - along[:, None] * edge, axis=1) <= reach
    return inside | near


def area(corners):
    x, y = np.asarray(corners, float).T
    return 0.5 * abs(np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1)))


def crossed(low, high, polygon):
    """Which of the boxes [low, high] an edge of the polygon passes through."""
    found = np.zeros(len(low), bool)
    for a, b in zip(polygon, np.roll(polygon, -1, axis=0)):
        over = np.all((np.maximum(a, b) > low) & (np.minimum(a, b) < high), axis=1)
        normal = np.array([a[1] - b[1], b[0] - a[0]])
        middle, reach = 0.5 * (low + high) - a, 0.5 * (high - low) @ np.abs(normal)
        found |= over & (np.abs(middle @ normal) < reach)
    return found


def cut_cells(region, place, lengths):
    """Pieces of the lattice at a region's edge: (owner, corners). Cells that have no point go with a neighbour's."""
    polygon, rows, half = region.polygon, region.rows, 0.5 * lengths
    lattice = np.rint((place - place[0]) / lengths).astype(np.int64)
    there = {tuple(cell): row for cell, row in zip(lattice.tolist(), rows.tolist())}
    pieces = {}
    for k in np.flatnonzero(crossed(place - half, place + half, polygon)):
        pieces[tuple(lattice[k])] = (rows[k], clip(polygon, place[k] - half, place[k] + half))
    for dx, dy in ((0, -1), (0, 1), (-1, 0), (1, 0), (-1, -1), (-1, 1), (1, -1), (1, 1)):
        beside = place + np.array([dx, dy]) * lengths
        free = ~np.any([in_polygon(beside, other) for other in region.replaced], axis=0) if region.replaced else True
        for k in np.flatnonzero(crossed(beside - half, beside + half, polygon) & free):
            cell = (lattice[k][0] + dx, lattice[k][1] + dy)
            if cell not in there and cell not in pieces:
                pieces[cell] = (rows[k], clip(polygon, beside[k] - half, beside[k] + half))
    return [
        (owner, corners)
        for owner, corners in pieces.values()
        if len(corners) > 2 and area(corners) > SLIVER * np.prod(lengths)
    ]


def starting_pieces(origin, regions):
    """Domains at first: boxes, and pieces of boxes where a body's region cuts them. `regions`: see Region."""
    boxes = origin.position[:, None, :] + 0.5 * SQUARE * origin.lengths[:, None, :]
    pieces, whole = [], np.ones(len(boxes), bool)
    for region in regions:
        lengths = origin.lengths[region.rows]
        if len(lengths) and np.ptp(lengths, axis=0).max() < CORNER * lengths.min():
            pieces += cut_cells(region, origin.position[region.rows], lengths[0])
    whole[[owner for owner, _ in pieces]] = False
    lost = np.setdiff1d(np.flatnonzero(~whole), [owner for owner, corners in pieces if _covers(corners, origin, owner)])
    whole[lost] = True  # of these only a neighbour's cell was cut
    kept = np.flatnonzero(whole)
    width = max([4] + [len(corners) for _, corners in pieces])
    start = np.empty((len(pieces) + len(kept), width, 2))
    for k, (_, corners) in enumerate(pieces):
        start[k] = np.array(corners + [corners[-1]] * (width - len(corners)))
    start[len(pieces) :] = boxes[kept][:, [0, 1, 2] + [3] * (width - 3)]
    return start, np.concatenate([np.array([owner for owner, _ in pieces], int), kept])


def _covers(corners, origin, owner):
    """Is this piece in the owner's own cell?"""
    away = np.abs(np.mean(corners, axis=0) - origin.position[owner])
    return bool(np.all(away < (0.5 + CORNER) * origin.lengths[owner]))


def number_corners(start, lengths, part):
    """A number for each corner, alike where corners of one part meet at first; in the plane or in space."""
    dim = start.shape[-1]
    lattice = np.rint((start - start.reshape(-1, dim).min(axis=0)) / (CORNER * lengths.min())).astype(np.int64)
    code = np.broadcast_to(part[:, None].astype(np.int64) + 1, start.shape[:2])
    for axis in range(dim):
        code = code * (lattice[..., axis].max() + 1) + lattice[..., axis]
    return np.unique(code, return_inverse=True)[1].reshape(code.shape)


def join(own, number, lengths):
    """Corners at the mean of all that bear a number, where none is far from it."""
    flat, place = number.ravel(), own.reshape(-1, own.shape[-1])
    count = np.bincount(flat)
    mean = np.stack([np.bincount(flat, place[:, axis]) / count for axis in range(place.shape[1])], axis=1)
    away = np.max(np.abs(place - mean[flat]), axis=1).reshape(number.shape) > APART * lengths[:, None]
    parted = np.bincount(flat, away.ravel()) > 0
    return np.where(parted[number][..., None], own, mean[number])


def first_domains(origin, regions=(), part=None):
    """All domains at first; `part`: bodies that slide on each other have different numbers."""
    start, owner = starting_pieces(origin, regions)
    part = np.zeros(len(origin.position), int) if part is None else part
    return Domains(start, owner, start, number_corners(start, origin.lengths, part[owner]))


def moved_domains(first, state, origin, scale=1.0):
    """The domains where a state has them; `scale` of displacements."""
    owner = first.owner
    stretch = 2.0 * half_lengths(state, origin)[owner] / origin.lengths[owner]
    offset = (first.start - origin.position[owner][:, None]) * stretch[:, None]
    own = state["position"][owner][:, None] + np.einsum("pij,pkj->pki", deformation(state)[owner], offset)
    corners = join(own, first.number, origin.lengths[owner].min(axis=1))
    if scale != 1.0:
        move = np.repeat(state["displacement"][owner][:, None], first.start.shape[1], axis=1)
        corners = corners + (scale - 1.0) * join(move, first.number, np.full(len(owner), np.inf))
    return first._replace(corners=corners)


def outline(found, group):
    """Edges of domains that no other of the same group shares: (segments (k, 2, 2), the domain of each)."""
    first, second = found.number, np.roll(found.number, -1, axis=1)
    domain = np.repeat(np.arange(len(first)), first.shape[1])
    place = np.stack([found.corners, np.roll(found.corners, -1, axis=1)], axis=2).reshape(-1, 2, 2)
    low, high = np.minimum(first, second).ravel(), np.maximum(first, second).ravel()
    real = low != high
    code = (low.astype(np.int64) * (found.number.max() + 1) + high)[real]
    code = code * (group.max() + 2) + group[found.owner[domain[real]]] + 1
    _, inverse, count = np.unique(code, return_inverse=True, return_counts=True)
    alone = count[inverse] == 1
    return place[real][alone], domain[real][alone]


def frame_of(corners, margin):
    """Limits of the axes around corners, (lower, upper), with a margin of the larger extent."""
    flat = corners.reshape(-1, corners.shape[-1])
    lower, upper = flat.min(axis=0), flat.max(axis=0)
    return lower - margin * np.max(upper - lower), upper + margin * np.max(upper - lower)
