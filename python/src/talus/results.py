"""Results of a run, as tables and arrays."""
from __future__ import annotations

import functools
import html
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pandas as pd

from .plot import Picture, draw
from .tools import results as files

ResultsError = files.ResultsError
Fields = dict[str, npt.NDArray[Any]]


class State(Fields):
    """Fields of the points at one time by name, rows by `id`; stress is Cauchy's: xx, yy, zz, xy, yz, xz."""

    def __init__(self, step: int, time: float, fields: Fields) -> None:
        super().__init__(fields)
        self.step, self.time = step, time


class Results:
    """What a run left behind, read when it is first asked for.

    Args:
        prefix: of the files, as `out/look` for out/look_history.csv.
        status: exit status of the run; by default as the summary says.
        output: the program's lines.
        keep: an object that lives as long as the results, as a folder for the while.
    """

    def __init__(self, prefix: str | Path, status: int | None = None, output: str = "", keep: object = None) -> None:
        self._files = files.Results(prefix)
        self._status, self._keep, self.output = status, keep, output

    @property
    def prefix(self) -> Path:
        """Common beginning of the files."""
        return Path(self._files.prefix)

    @property
    def status(self) -> int:
        """Exit status: 0 completed or interrupted, 3 gave up, 4 a file could not be written."""
        if self._status is not None:
            return self._status
        return 0 if self.summary["status"] in ("completed", "interrupted") else 3

    @functools.cached_property
    def history(self) -> pd.DataFrame:
        """A row a step."""
        return pd.read_csv(self._files.path("_history.csv"))

    @functools.cached_property
    def members(self) -> pd.DataFrame:
        """Of an ensemble: a row a member, with status (0 completed, 2 refused, 3 gave up), draws and results."""
        return pd.read_csv(self._files.path("_members.csv"))

    @functools.cached_property
    def statistics(self) -> pd.DataFrame:
        """Of an ensemble: a row a draw and a result."""
        return pd.read_csv(self._files.path("_statistics.csv"))

    @property
    def summary(self) -> dict[str, Any]:
        """How the run ended, its sizes and times."""
        return dict(self._files.summary)

    @property
    def options(self) -> dict[str, str]:
        """The options in force, defaults included, as text."""
        return dict(self._files.options)

    @property
    def states(self) -> list[int]:
        """Steps whose points were written."""
        return list(self._files.steps)

    def state(self, step: int | str = "last") -> State:
        """The points at a step: its number, "first" or "last"."""
        state = self._files.state(step)
        return State(state.step, state.time, state.fields)

    @functools.cached_property
    def points(self) -> State:
        """The points at the last written step."""
        return self.state("last")

    def table(self, kind: str, name: str) -> pd.DataFrame:
        """The file of a row of cuts (kind "section") or of a line ("profile")."""
        return pd.DataFrame(self._files.table(kind, name))

    def to_pyvista(self, step: int | str = "last") -> Any:
        """The points at a step as pyvista.PolyData, fields as point data; needs pyvista."""
        try:
            import pyvista
        except ImportError as error:
            raise ImportError("to_pyvista needs the package pyvista: pip install pyvista") from error
        state = self.state(step)
        position = state["position"]
        cloud = pyvista.PolyData(np.pad(position, ((0, 0), (0, 3 - position.shape[1]))))
        for name, values in state.items():
            flat = name in ("displacement", "velocity", "acceleration") and values.shape[1] == 2
            cloud.point_data[name] = np.pad(values, ((0, 0), (0, 1))) if flat else values
        return cloud

    def plot(self, **options: Any) -> Picture:
        """Draws the results; options are those of `talus plot`, see `talus.plot.draw`."""
        return draw(self, **options)

    def _repr_html_(self) -> str:
        summary = self.summary
        keys = ("title", "status", "physics", "dim", "points", "ranks", "steps", "newton_iterations", "time_total_s")
        texts = {key: html.escape(str(summary[key])) for key in keys if key in summary}
        last = self.statistics if summary.get("task") == "ensemble" else self.history.tail(3)
        rows = "".join(f"<tr><th>{key}</th><td>{text}</td></tr>" for key, text in texts.items())
        return f"<table>{rows}</table>{last.to_html(index=False)}"

    def __repr__(self) -> str:
        return f"Results({str(self.prefix)!r}, {self.summary['status']})"
