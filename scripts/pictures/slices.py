"""A slice through a body in space: the domains that a plane across an axis cuts, seen along that axis."""

from collections import namedtuple

import numpy as np

from results import Origin, ResultsError, State

from .domains import SQUARE, Domains, deformation, frame_of, half_lengths, join, number_corners

MARGIN = 0.05

# As plane.Look, with the rows of the points that are cut and the names of the axes in the picture.
SliceLook = namedtuple("SliceLook", "state origin body domains frame start rows axes")


def read_slice(text):
    """Axis and place of "x=2.5"."""
    axis, _, place = text.partition("=")
    try:
        return "xyz".index(axis.strip()), float(place)
    except ValueError as error:
        raise ResultsError(f"--slice {text}: give an axis and a place, as z=0.5") from error


def nearest_of_columns(rows, away, place):
    """Of the points along one line at first, the one nearest to the plane."""
    rows = rows[np.argsort(np.abs(away[rows]), kind="stable")]
    _, first = np.unique(np.rint(place[rows] * 100.0).astype(np.int64), axis=0, return_index=True)
    return np.sort(rows[first])


def slice_look(results, scene, state, text):
    """What a slice looks like."""
    axis, place = read_slice(text)
    along = [k for k in range(3) if k != axis]
    origin, gradient, half = results.origin(state), deformation(state), half_lengths(state, results.origin(state))
    reach = np.einsum("pj,pj->p", np.abs(gradient[:, axis]), half)
    away = (state["position"][:, axis] - place) / reach
    rows = nearest_of_columns(
        np.flatnonzero(np.abs(away) <= 1.0 + 1e-9), away, origin.position[:, along] / origin.lengths.min()
    )
    if not len(rows):
        low, high = (state["position"][:, axis] - reach).min(), (state["position"][:, axis] + reach).max()
        raise ResultsError(f"--slice {text}: cuts nothing; the material is from {low:.4g} to {high:.4g} m")
    flat = Origin(origin.position[rows][:, along], origin.lengths[rows][:, along])
    local = SQUARE * half[rows][:, along][:, None]
    middle = (
        state["position"][rows][:, along]
        - (away[rows] * reach[rows] / gradient[rows, axis, axis])[:, None] * gradient[rows][:, along, axis]
    )
    corners = middle[:, None] + np.einsum("pij,pkj->pki", gradient[rows][:, along][:, :, along], local)
    start = flat.position[:, None] + 0.5 * SQUARE * flat.lengths[:, None]
    number = number_corners(start, flat.lengths, np.zeros(len(rows), int))
    found = Domains(join(corners, number, flat.lengths.min(axis=1)), np.arange(len(rows)), start, number)
    cut = State(
        state.step,
        state.time,
        {name: data[rows] for name, data in state.fields.items() if len(data) == len(state["id"])},
    )
    body = cut["material"].astype(int) if "material" in cut else np.zeros(len(rows), int)
    return SliceLook(cut, flat, body, found, frame_of(corners, MARGIN), None, rows, ["xyz"[k] for k in along])
