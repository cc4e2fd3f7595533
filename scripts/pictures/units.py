"""Numbers as engineers read them: units with a metric prefix, settlement in mm, time in days or years."""

import re

import numpy as np

PLACE = "place"  # m, of coordinates, which are read in m whatever their size
UNITS = {
    "stress": "Pa",
    "von_mises": "Pa",
    "pressure": "Pa",
    "displacement": "m",
    "position": PLACE,
    "position0": PLACE,
    "volume": "m³",
    "mass": "kg",
    "velocity": "m/s",
    "acceleration": "m/s²",
    "flux": "m/s",
    "half_length": "m",
}
LARGE = {"Pa": "", "N": "", "N m": "", "N/m": "", "N m/m": "", "J": ""}
PREFIXES = ((1e9, "G"), (1e6, "M"), (1e3, "k"))
MILLIMETRES, SLOW = 1.0, 0.01  # m, m/s: below it displacements are read in mm, velocities in mm/s
MICRO = 2e-5  # of them: below it they are read in µm
HOUR, DAY, YEAR = 3600.0, 86400.0, 365.25 * 86400.0
NOISE = 1e-8  # of the field's size: what rounding and the solver's tolerance leave
AXES = "xyz"


def largest(values):
    """Largest size of the numbers that are numbers."""
    values = np.asarray(values, float)
    return float(np.max(np.abs(values[np.isfinite(values)]), initial=0.0))


def readable(size, unit):
    """Factor and unit in which numbers up to `size` are read."""
    if unit == PLACE:
        return 1.0, "m"
    if unit in LARGE:
        for factor, prefix in PREFIXES:
            if size >= factor:
                return 1.0 / factor, prefix + unit
    limit = {"m": MILLIMETRES, "m/s": SLOW}.get(unit, 0.0)
    if 0.0 < size < limit:
        rest = unit[1:]
        return (
            (1e3, "mm" + rest)
            if size > MICRO * limit
            else (1e6, "µm" + rest) if size > MICRO**2 * limit else (1.0, unit)
        )
    return 1.0, unit


def with_unit(label, unit):
    return f"{label} ({unit})" if unit else label


def amount(value, unit):
    """A number with its unit, as text: "15 kPa"."""
    factor, shown = readable(abs(value), unit)
    return f"{factor * value:.4g} {shown}".rstrip()


def column_label(column):
    """What a column of the history is, and its unit."""
    for pattern, label, unit in COLUMNS:
        match = re.fullmatch(pattern, column)
        if match:
            groups = {f"g{i}": text for i, text in enumerate(match.groups(), 1)}
            return label.format(**groups, upper=groups.get("g2", "").upper()), unit
    return column.replace("_", " "), {"time": "s", "dt": "s", "eps_v": "-"}.get(column, "").replace("-", "")


COLUMNS = (
    (r"track_(\w+)_u([xyz])", "$u_{g2}$ of {g1}", "m"),
    (r"track_(\w+)_v([xyz])", "$v_{g2}$ of {g1}", "m/s"),
    (r"reaction_(\w+)_(p)", "water by {g1}", "m³"),
    (r"reaction_(\w+)_(\w+)", "reaction {g2} of {g1}", "N"),
    (r"force_(\w+)_(\w+)", "force {g2} of {g1}", "N"),
    (r"moment_(\w+)_([xyz])", "moment {g2} of {g1}", "N m"),
    (r"depth_(\w+)", "depth behind {g1}", "m"),
    (r"position_(\w+)_([xyz])", "{g2} of {g1}", PLACE),
    (r"rotation_(\w+)_([xyz])", "rotation of {g1}", "°"),
    (r"outflow_(\w+)", "outflow of {g1}", "m³"),
    (r"section_(\w+)_([mt]\d?)", "{upper} of {g1}", "N m"),
    (r"section_(\w+)_([nv]\d?)", "{upper} of {g1}", "N"),
    (r"profile_(\w+)_(\w+)", "mean {g2} of {g1}", "Pa"),
    (r"energy_(\w+)", "energy, {g1}", "J"),
    (r"grid_(lower|upper)_([xyz])", "{g1} end of the grid, {g2}", PLACE),
    (r"(stress)_(\w\w)", "$\\sigma_{{{g2}}}$", "Pa"),
    (r"(strain)_(\w\w)", "$\\epsilon_{{{g2}}}$", ""),
    (r"([pq])", "{g1}", "Pa"),
    (r"reduction", "strength reduction factor", ""),
)


def time_unit(scene, span):
    """Seconds of a time unit and its name: the largest of which there are more than two; "" of a pseudo-time."""
    if not scene.has_time:
        return 1.0, ""
    return next(
        ((one, name) for one, name in ((YEAR, "years"), (DAY, "days"), (HOUR, "hours")) if span > 2.0 * one), (1.0, "s")
    )


def time_text(scene, time, span=None):
    seconds, unit = time_unit(scene, time if span is None else span)
    return f"time {time / seconds:.4g} {unit}" if unit else f"pseudo-time {time:.4g}"


def is_uniform(values, size):
    """True where a field differs from one number by rounding alone; `size` is that of the whole tensor."""
    values = values[np.isfinite(values)]
    return values.size == 0 or np.ptp(values) <= NOISE * max(size, largest(values))
