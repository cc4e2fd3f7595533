"""Reads what a run of Talus leaves behind: <prefix>.h5, _history.csv, _options.yaml and _summary.json.

    results = Results("cantilever")
    last = results.state("last")            # or "first", or the number of a step
    last["stress"]                          # (points, 6): xx, yy, zz, xy, yz, xz, in Pa
    results.history["track_tip_uy"]         # one number a step
    results.option("mpm_grid_cells")        # text, as in force during the run
"""
import csv
import json
import re
from collections import namedtuple
from pathlib import Path

import h5py
import numpy as np

SYMMETRIC = ("xx", "yy", "zz", "xy", "yz", "xz")
FULL = ("xx", "xy", "xz", "yx", "yy", "yz", "zx", "zy", "zz")
AXES = ("x", "y", "z")


class ResultsError(Exception):
    """Something that was asked for is not in the result files; the text says what, and what there is."""


# Where points were first, and the edge lengths of their domains then: arrays (points, dim).
Origin = namedtuple("Origin", "position lengths")


def find_step(step, steps, what):
    """The number of a step, itself a number, "first" or "last", among the steps of which `what` holds something."""
    steps = [int(number) for number in steps]
    if not steps:
        raise ResultsError(f"{what} holds no steps")
    known = {"first": steps[0], "last": steps[-1]}
    try:
        number = known[step] if step in known else int(step)
    except ValueError as error:
        raise ResultsError(f"'{step}' is not a step: give a number, first or last") from error
    if number not in steps:
        raise ResultsError(f"{what} does not hold step {number}; it has {', '.join(map(str, steps))}")
    return number


def read_columns(path):
    """Columns of a CSV file by name."""
    with open(path, newline="", encoding="utf-8") as file:
        rows = [row for row in csv.reader(file) if row]
    rows = [row for row in rows if len(row) == len(rows[0])]  # the last one of a run that goes on may be half a row
    values = np.array([[float(value) for value in row] for row in rows[1:]]).reshape(-1, len(rows[0]))
    return {name.strip(): values[:, i] for i, name in enumerate(rows[0])}


class State:
    """The points at one time: fields by name, rows by id."""

    def __init__(self, step, time, fields):
        self.step, self.time, self.fields = step, time, fields

    def __getitem__(self, name):
        if name not in self.fields:
            raise ResultsError(f"step {self.step} has no field '{name}'; it has {', '.join(sorted(self.fields))}")
        return self.fields[name]

    def __contains__(self, name):
        return name in self.fields

    @property
    def dim(self):
        return self["position"].shape[1]


class Results:
    """The result files of one prefix, read when they are first asked for."""

    def __init__(self, prefix):
        self.prefix = re.sub(r"\.(h5|xdmf)$", "", str(prefix))
        self._history = self._options = self._given = self._summary = self._initial = None
        self._born, self._ids, self._origin, self._half = 0, np.empty(0, np.int64), None, None  # states looked at; their points
        self._births = np.empty(0, np.int64)

    def path(self, suffix):
        path = Path(self.prefix + suffix)
        if not path.is_file():
            raise ResultsError(f"there is no file {path}")
        return path

    def _file(self):
        path = self.path(".h5")
        try:
            return h5py.File(path, "r")
        except OSError as error:
            raise ResultsError(f"cannot read {path}: {error}") from error

    @property
    def steps(self):
        """The steps that were written, in order."""
        with self._file() as file:
            return sorted(int(name) for name in file.get("points", ()))

    def state(self, step="last"):
        """The points at a step: its number, "first" or "last"."""
        number = find_step(step, self.steps, f"{self.prefix}.h5")
        with self._file() as file:
            group = file[f"points/{number:06d}"]
            return State(number, float(group.attrs["time"]), {name: data[()] for name, data in group.items()})

    @property
    def initial(self):
        """The first state, which has position0."""
        if self._initial is None:
            self._initial = self.state("first")
        return self._initial

    def origin(self, state):
        """The origin of a state's points, row by row: bodies may come and go, points may be divided."""
        while not np.isin(state["id"], self._ids).all():
            self._take_births()
        order = np.argsort(self._ids)
        rows = order[np.searchsorted(self._ids, state["id"], sorter=order)]
        position, lengths = self._origin.position[rows], self._origin.lengths[rows]
        if "half_length" in state and "displacement" in state:
            ratio = state["half_length"] / self._half[rows]
            divided = np.any(ratio < 0.75, axis=1)  # halved, once or more
            position[divided] = (state["position"] - state["displacement"])[divided]
            lengths[divided] *= ratio[divided]
        return Origin(position, lengths)

    def births(self, state):
        """The step of the first state that has each of a state's points."""
        self.origin(state)
        order = np.argsort(self._ids)
        return self._births[order[np.searchsorted(self._ids, state["id"], sorter=order)]]

    def _take_births(self):
        """Adds the points of the next state that none before it has."""
        state = self.state(self.steps[self._born])
        new = ~np.isin(state["id"], self._ids)
        self._born += 1
        if not new.any():
            return
        born = State(state.step, state.time, {name: values[new] for name, values in state.fields.items()})
        if "position0" not in born:
            born.fields["position0"] = born["position"] - (born["displacement"] if "displacement" in born else 0.0)
        origin = Origin(born["position0"], initial_lengths(born, self._born > 1))
        self._origin = Origin(*map(np.concatenate, zip(self._origin, origin))) if self._origin else origin
        half = born["half_length"] if "half_length" in born else np.full(born["position"].shape, np.nan)
        self._half = np.concatenate([self._half, half]) if self._half is not None else half
        self._ids = np.concatenate([self._ids, born["id"]])
        self._births = np.concatenate([self._births, np.full(len(born["id"]), born.step)])

    @property
    def history(self):
        """Columns of the history by name."""
        if self._history is None:
            self._history = read_columns(self.path("_history.csv"))
        return self._history

    def table(self, kind, name):
        """Columns of the file of a row of cuts (kind "section") or of a line ("profile")."""
        return read_columns(self.path(f"_{kind}_{name}.csv"))

    def column(self, name):
        if name not in self.history:
            raise ResultsError(f"the history has no column '{name}'; it has {', '.join(self.history)}")
        return self.history[name]

    @property
    def options(self):
        """Options in force as text, defaults included (they may stand as comments in the file)."""
        if self._options is None:
            text = self.path("_options.yaml").read_text(encoding="utf-8")
            pairs = re.findall(r'^(?:# )?"?(\w+)"?: (?:"((?:[^"\\]|\\.)*)"|(\S.*?))\s*$', text, re.MULTILINE)
            self._options = {name: quoted or plain for name, quoted, plain in pairs}
            self._given = set(re.findall(r'^"?(\w+)"?: ', text, re.MULTILINE))
        return self._options

    def is_given(self, name):
        """True where the scene gives this option, or where the default counts as if it did."""
        return name in self.options and name in self._given

    def option(self, name, default=None):
        if default is None and name not in self.options:
            raise ResultsError(f"{self.prefix}_options.yaml does not hold {name}")
        return self.options.get(name, default)

    def numbers(self, name, default=None):
        """An option that is a comma-separated list of numbers."""
        return [float(part) for part in self.option(name, default).split(",")]

    @property
    def summary(self):
        if self._summary is None:
            self._summary = json.loads(self.path("_summary.json").read_text(encoding="utf-8"))
        return self._summary


def von_mises(stress):
    """sqrt(3 J2) of symmetric tensors with the components xx, yy, zz, xy, yz, xz."""
    xx, yy, zz, xy, yz, xz = stress.T
    return np.sqrt(0.5 * ((xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2) + 3.0 * (xy**2 + yz**2 + xz**2))


def pressure(stress):
    """Minus the mean stress: positive in compression."""
    return -stress[:, :3].sum(axis=1) / 3.0


def component_names(count):
    """Names of a field's components."""
    return {1: ("",), 2: AXES[:2], 3: AXES, 6: SYMMETRIC, 9: FULL}.get(count, tuple(map(str, range(count))))


def initial_lengths(initial, joined=False):
    """Edge lengths of each point's domain before deformation, (points, dim): written, or from where the points stand.

    Along each axis it is the smallest distance between two points; where that does not give the points' volumes (points
    that are not on a lattice), the domains are taken as squares or cubes.
    """
    position, dim = initial["position0"], initial.dim
    if "half_length" in initial:  # of the domain that F deforms, also in the first state; halves of points are born deformed
        first = "F" in initial and not joined
        stretch = np.linalg.norm(initial["F"].reshape(-1, 3, 3), axis=1)[:, :dim] if first else 1.0
        return 2.0 * initial["half_length"] * stretch
    lengths = np.empty(dim)
    for axis in range(dim):
        gaps = np.diff(np.unique(np.round(position[:, axis], 9)))
        lengths[axis] = gaps.min() if gaps.size else 0.0
    if "volume" not in initial:  # nor anything else that tells
        return np.tile(np.where(lengths > 0.0, lengths, lengths.max() if lengths.max() > 0.0 else 1.0), (len(position), 1))
    volume = initial["volume"] / (np.linalg.det(initial["F"].reshape(-1, 3, 3)) if "F" in initial else 1.0)
    # One point a row on some axis leaves its length open: the volume tells it.
    if np.count_nonzero(lengths == 0.0) == 1:
        lengths[lengths == 0.0] = np.median(volume) / np.prod(lengths[lengths > 0.0])
    if np.allclose(np.prod(lengths), volume, rtol=1e-3):
        return np.tile(lengths, (len(volume), 1))
    return np.repeat(volume[:, None] ** (1.0 / dim), dim, axis=1)
