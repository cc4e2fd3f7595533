"""Layers of ground, drawn by their surface and the interfaces below (region: layers)."""

import numpy as np


def read_line(scene, name):
    """A line of ground, (vertices, 2); one number is a level; None where the option is absent."""
    values = scene.vector(name)
    if not len(values):
        return None
    return np.array([[0.0, values[0]]]) if len(values) == 1 else values.reshape(-1, 2)


def height(line, x, side):
    """Height of a line at x, reached from the left (-1) or the right (1); level beyond its ends."""
    if x < line[0, 0] or (x == line[0, 0] and side < 0):
        return line[0, 1]
    after = np.searchsorted(line[:, 0], x, side="left" if side < 0 else "right")
    if after == len(line):
        return line[-1, 1]
    (a, b), (c, d) = line[after - 1], line[after]
    return b + (d - b) * (x - a) / (c - a)


def crossings(one, other, places):
    """Places between two neighbouring ones at which one line crosses the other."""
    found = []
    for a, b in zip(places[:-1], places[1:]):
        start, end = height(one, a, 1) - height(other, a, 1), height(one, b, -1) - height(other, b, -1)
        if start * end < 0.0:
            found.append(a + (b - a) * start / (start - end))
    return found


def lower_line(one, other):
    """The lower one of two lines at each x."""
    places = np.unique(np.concatenate([one[:, 0], other[:, 0]]))
    places = np.unique(np.concatenate([places, crossings(one, other, places)]))
    rows = [(x, min(height(one, x, side), height(other, x, side))) for x in places for side in (-1, 1)]
    return np.array([row for k, row in enumerate(rows) if k == 0 or row != rows[k - 1]])


def top_of(scene, block):
    """Top of a layer: its own line, or the bottom of the layer that it lies below."""
    own = read_line(scene, f"{block}_top")
    above = scene.get(f"{block}_below")
    if own is not None or not above:
        return own
    top, bottom = top_of(scene, f"body_{above}"), read_line(scene, f"body_{above}_bottom")
    return None if top is None or bottom is None else lower_line(top, bottom)


def bottom_of(scene, block, top):
    """Bottom of a layer, nowhere above its top; the grid's end where it has none."""
    line = read_line(scene, f"{block}_bottom")
    return lower_line(top, np.array([[0.0, scene.vector("grid_lower")[1]]]) if line is None else line)


def layer_polygon(scene, block):
    """Outline of a layer within the grid, (corners, 2); None where a line is missing."""
    top = top_of(scene, block)
    if top is None:
        return None
    low, high = scene.vector("grid_lower")[0], scene.vector("grid_upper")[0]
    sides = []
    for line in (top, bottom_of(scene, block, top)):
        inner = line[(line[:, 0] > low) & (line[:, 0] < high)]
        sides.append(np.concatenate([[(low, height(line, low, 1))], inner, [(high, height(line, high, -1))]]))
    return np.concatenate([sides[0], sides[1][::-1]])


def in_layer(scene, block, place, reach):
    """Which places lie in a layer, or within `reach` of it."""
    top = top_of(scene, block)
    if top is None:
        return np.zeros(len(place), bool)
    bottom = bottom_of(scene, block, top)
    under = np.array([min(height(top, x, -1), height(top, x, 1)) for x in place[:, 0]])
    over = np.array([max(height(bottom, x, -1), height(bottom, x, 1)) for x in place[:, 0]])
    return (place[:, 1] <= under + reach) & (place[:, 1] >= over - reach)
