"""Numbers by which points are coloured: a field, a component, or what is derived from stress; and their colours."""

from collections import namedtuple

import numpy as np

from results import ResultsError, component_names, pressure, von_mises

from . import style, units

DERIVED = {"von_mises": (von_mises, "von Mises stress"), "pressure": (pressure, "mean pressure")}
SYMBOLS = {
    "stress": "\\sigma",
    "displacement": "u",
    "velocity": "v",
    "strain": "\\epsilon",
    "flux": "q",
    "acceleration": "a",
}
LABELS = {"pressure": "water pressure", "equivalent_plastic_strain": "equivalent plastic strain"}
NOISE_LENGTH = 1e-6  # of the extent of the material: less of a displacement is the tolerance of the solver
GROUPS = ("material", "body")  # fields of numbers that name something

# values of the points in the unit shown, and label with it; `uniform`: one number apart from rounding
Field = namedtuple("Field", "values label unit factor uniform")
# colour map and ends of its bar
Scale = namedtuple("Scale", "colours low high")


def field_values(state, field, component):
    """One number a point, its label without unit, and the size beside which it is rounding."""
    if field in DERIVED and field not in state:
        derive, label = DERIVED[field]
        return derive(state["stress"]), label, units.largest(state["stress"])
    data = state[field]
    data = data.reshape(len(data), -1)
    names = component_names(data.shape[1])
    symbol, size = SYMBOLS.get(field, f"\\mathrm{{{field}}}"), units.largest(data)
    if field == "displacement":
        size = max(size, NOISE_LENGTH * np.max(np.ptp(state["position"], axis=0)))
    if data.shape[1] == 1:
        return data[:, 0].astype(float), LABELS.get(field, field.replace("_", " ")), size
    if component is None:
        if data.shape[1] > 3:
            raise ResultsError(f"field '{field}' is a tensor: choose a --component out of {', '.join(names)}")
        return np.linalg.norm(data, axis=1), f"$|{symbol}|$", size
    if component not in names:
        raise ResultsError(f"field '{field}' has no component '{component}'; it has {', '.join(names)}")
    return data[:, names.index(component)].astype(float), f"${symbol}_{{{component}}}$", size


def read_field(state, field, component, size=None):
    """A field in a readable unit; `size`: the largest number of a series, which chooses the unit for all."""
    values, label, whole = field_values(state, field, component)
    factor, unit = units.readable(units.largest(values) if size is None else size, units.UNITS.get(field, ""))
    return Field(values * factor, units.with_unit(label, unit), unit, factor, units.is_uniform(values, whole))


def colour_scale(values, limits=None, colours=None, percentile=None):
    """Colour map and limits: symmetric and diverging where the field clearly takes both signs."""
    values = values[np.isfinite(values)]
    if limits:
        return Scale(colours or style.SEQUENTIAL, *limits)
    if not len(values):
        return Scale(colours or style.SEQUENTIAL, 0.0, 1.0)
    low, high = (
        np.percentile(values, (percentile, 100.0 - percentile)) if percentile else (np.min(values), np.max(values))
    )
    if low < 0.0 < high and min(-low, high) > 0.1 * max(-low, high):
        high = max(-low, high)
        return Scale(colours or style.DIVERGING, -high, high)
    return Scale(colours or style.SEQUENTIAL, low, high if high > low else low + 1.0)
