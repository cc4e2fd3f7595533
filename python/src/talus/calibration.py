"""Parameters from measurements, by least squares."""
from __future__ import annotations

import threading
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Union

import numpy as np
import numpy.typing as npt
import pandas as pd
from scipy.optimize import least_squares

from .errors import RunError, SceneError
from .running import _scene, run
from .scene import Scene
from .tools import tables

Vector = npt.NDArray[np.float64]
Source = Union[Scene, Mapping[str, Any], str, Path]
Data = Union[pd.DataFrame, str, Path]
DIFFERENCE = 1e-4  # of a parameter's start value: history has 15 digits, solutions about 12
REFUSED = 1e3  # residual of a run without a history, in units of the largest measurement: the step is rejected


@dataclass
class Calibration:
    """Outcome of a calibration.

    Attributes:
        parameters: by option.
        covariance: of the parameters, from the residual and its derivatives at the end.
        residual: root of the mean square, as a fraction of the largest measured value of each column.
        runs: number of runs of the program.
        converged: whether the least squares ended by themselves.
        message: why they ended.
        scenes: the scenes with the parameters found.
    """

    parameters: pd.Series
    covariance: pd.DataFrame
    residual: float
    runs: int
    converged: bool
    message: str
    scenes: list[Scene]

    @property
    def deviations(self) -> pd.Series:
        """Standard deviations of the parameters."""
        return pd.Series(np.sqrt(np.diag(self.covariance)), index=self.covariance.index)

    def _repr_html_(self) -> str:
        return str(pd.DataFrame({"value": self.parameters, "deviation": self.deviations}).to_html())


class _Experiment:
    """One scene with its measurements."""

    def __init__(self, scene: Source, data: Data, abscissa: str | None) -> None:
        self.scene = _scene(scene)
        table = data if isinstance(data, pd.DataFrame) else pd.DataFrame(tables.read_table(data))
        self.abscissa = str(tables.find(table.columns, abscissa or table.columns[0], "measured: the table"))
        self.columns = [str(name) for name in table.columns if name != self.abscissa]
        if not self.columns:
            raise ValueError(f"measured: no column beside {self.abscissa}")
        self.at = table[self.abscissa].to_numpy(float)
        self.values = {name: table[name].to_numpy(float) for name in self.columns}
        self.scales = {name: float(np.nanmax(np.abs(values))) or 1.0 for name, values in self.values.items()}

    def residual(self, options: Mapping[str, Any], first: bool) -> Vector:
        """Computed less measured values over the largest measured ones; large ones of a refused set but the first."""
        try:
            history = run(self.scene, check=False, **options).history
        except (SceneError, RunError):
            if first:
                raise
            history = pd.DataFrame()
        if history.empty:
            return np.full(sum(int(np.isfinite(values).sum()) for values in self.values.values()), REFUSED)
        there = {name: tables.find(history.columns, name, "measured: the history") for name in (self.abscissa, *self.columns)}
        history = history.sort_values(there[self.abscissa])
        parts = []
        for name, values in self.values.items():
            computed = np.interp(self.at, history[there[self.abscissa]], history[there[name]])
            parts.append(((computed - values) / self.scales[name])[np.isfinite(values)])
        return np.concatenate(parts)


class _Problem:
    """Residuals of all experiments and their derivatives, by parameters over their scales."""

    def __init__(self, experiments: list[_Experiment], names: list[str], lower: Vector, upper: Vector,
                 pool: ThreadPoolExecutor) -> None:
        self.experiments, self.names, self.pool = experiments, names, pool
        self.start = np.array([_start(experiments[0].scene, name) for name in names])
        for name, value, low, high in zip(names, self.start, lower, upper):
            if not low <= value <= high:
                raise ValueError(f"{name}: starts at {value:g}, which is not within its bounds {low:g} and {high:g}")
        width = np.where(np.isfinite(upper - lower), upper - lower, 1.0)
        self.scale = np.where(self.start != 0.0, np.abs(self.start), width)
        self.lower, self.upper = lower / self.scale, upper / self.scale
        self.runs, self.lock = 0, threading.Lock()
        self.last: tuple[Vector, Vector] | None = None

    def options(self, x: Vector) -> dict[str, float]:
        return {name: float(value) for name, value in zip(self.names, x * self.scale)}

    def many(self, points: Sequence[Vector], first: bool = False) -> list[Vector]:
        """Residuals at several points, side by side."""
        def single(job: tuple[Vector, _Experiment]) -> Vector:
            with self.lock:
                self.runs += 1
            return job[1].residual(self.options(job[0]), first)

        jobs = [(x, experiment) for x in points for experiment in self.experiments]
        found, count = list(self.pool.map(single, jobs)), len(self.experiments)
        return [np.concatenate(found[k * count:(k + 1) * count]) for k in range(len(points))]

    def residual(self, x: Vector) -> Vector:
        """Residual at one point; the last one is kept for the derivatives there."""
        if self.last is None or not np.array_equal(self.last[0], x):
            self.last = (x.copy(), self.many([x], first=self.last is None)[0])
        return self.last[1]

    def jacobian(self, x: Vector) -> Vector:
        """Differences in each parameter, away from its nearer bound; to the other side where the program refuses."""
        size, at = len(x), self.residual(x)
        steps = np.where(x + DIFFERENCE <= self.upper, DIFFERENCE, -DIFFERENCE)
        moved = self.many([x + step * row for step, row in zip(steps, np.eye(size))])
        refused = [k for k in range(size) if np.any(moved[k] == REFUSED)]
        for k, other in zip(refused, self.many([x - steps[k] * np.eye(size)[k] for k in refused])):
            moved[k], steps[k] = other, -steps[k]
        return np.stack([(moved[k] - at) / steps[k] for k in range(size)], axis=1)


def _start(scene: Scene, name: str) -> float:
    """A parameter's value in the scene."""
    try:
        return float(scene[name])
    except (KeyError, TypeError, ValueError) as error:
        raise SceneError(f"{name}: no number in the scene to start from") from error


def calibrate(scene: Source | None, measured: Data | Sequence[tuple[Source, Data]], parameters: Sequence[str],
              bounds: Mapping[str, tuple[float, float]] | None = None, abscissa: str | None = None,
              jobs: int = 2) -> Calibration:
    """Finds parameters with which runs agree best with measurements.

    Args:
        scene: a Scene or its source, with the values to start from.
        measured: a table or its file in CSV, written as the program's own tables may be: the abscissa and columns of the
            history; or a list of pairs of scene and table, of which the first scene has the start values.
        parameters: names of options.
        bounds: least and largest value by option.
        abscissa: column that the others are compared at, by default the table's first.
        jobs: runs at a time.

    Raises:
        SceneError: the program refuses the start values.
    """
    if isinstance(measured, (pd.DataFrame, str, Path)):
        if scene is None:
            raise ValueError("scene: None; a scene is needed unless `measured` has them")
        measured = [(scene, measured)]
    experiments = [_Experiment(one, data, abscissa) for one, data in measured]
    names = list(parameters)
    limits = [(bounds or {}).get(name, (-np.inf, np.inf)) for name in names]
    lower, upper = (np.array([limit[k] for limit in limits], float) for k in (0, 1))
    with ThreadPoolExecutor(max_workers=max(1, jobs)) as pool:
        problem = _Problem(experiments, names, lower, upper, pool)
        found = least_squares(problem.residual, problem.start / problem.scale, jac=problem.jacobian,
                              bounds=(problem.lower, problem.upper), xtol=1e-6, ftol=1e-6)
    return _outcome(problem, found)


def _outcome(problem: _Problem, found: Any) -> Calibration:
    count, size = found.jac.shape
    variance = 2.0 * found.cost / max(count - size, 1)
    covariance = variance * np.linalg.pinv(found.jac.T @ found.jac) * np.outer(problem.scale, problem.scale)
    options = problem.options(found.x)
    return Calibration(pd.Series(options), pd.DataFrame(covariance, problem.names, problem.names),
                       float(np.sqrt(2.0 * found.cost / count)), problem.runs, bool(found.status > 0),
                       str(found.message), [experiment.scene.changed(**options) for experiment in problem.experiments])
