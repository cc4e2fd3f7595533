"""Parameters from data by the program's own exact derivatives, and its residuals for other optimisers."""
from __future__ import annotations

import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Optional, Union

import numpy as np
import numpy.typing as npt
import pandas as pd

from .results import Results
from .running import _scene, run
from .scene import Scene

Vector = npt.NDArray[np.float64]
Source = Union[Scene, Mapping[str, Any], str, Path]
Parameters = Union[Sequence[str], Mapping[str, Mapping[str, Any]]]
Blocks = Optional[Mapping[str, Mapping[str, Any]]]


@dataclass
class Inverse:
    """Outcome of an inverse analysis.

    Attributes:
        table: a row a parameter: value, lower and upper of 95 %, composite scaled sensitivity.
        covariance: of the transformed parameters.
        correlation: of these.
        not_told_apart: names of parameters of each combination that the data do not tell.
        predictions: a row a prediction: value, deviation, lower, upper.
        iterations: the way to the parameters.
        results: those of the run with the parameters found.
    """

    table: pd.DataFrame
    covariance: pd.DataFrame
    correlation: pd.DataFrame
    not_told_apart: list[list[str]]
    predictions: pd.DataFrame
    iterations: pd.DataFrame
    results: Results

    def _repr_html_(self) -> str:
        return str(self.table.to_html())


def _named(parameters: Parameters) -> dict[str, dict[str, Any]]:
    """Blocks by name; of a list of numbers as soil.E each gets one."""
    if isinstance(parameters, Mapping):
        return {name: dict(block) for name, block in parameters.items()}
    return {name.replace(".", "_"): {"of": name} for name in parameters}


def _flat(kind: str, blocks: Mapping[str, Mapping[str, Any]]) -> dict[str, Any]:
    return {f"{kind}_{name}_{key}": value for name, block in blocks.items() for key, value in block.items()}


def _asked(scene: Source, parameters: dict[str, dict[str, Any]], objectives: Mapping[str, Mapping[str, Any]],
           predictions: Blocks, folder: Path) -> Scene:
    """The scene with the blocks of an analysis; tables of data become files."""
    written: dict[str, dict[str, Any]] = {}
    for name, block in objectives.items():
        written[name] = dict(block)
        data = block.get("data")
        if isinstance(data, pd.DataFrame):
            written[name]["data"] = str(folder / f"{name}.csv")
            data.to_csv(written[name]["data"], index=False, float_format="%.17g")
        elif data is not None:
            written[name]["data"] = str(Path(data).resolve())
    options = {"task": "inverse", "parameters": ",".join(parameters), "objectives": ",".join(written),
               **_flat("parameter", parameters), **_flat("objective", written), **_flat("prediction", predictions or {})}
    if predictions:
        options["predictions"] = ",".join(predictions)
    return _scene(scene).changed(**options)


def invert(scene: Source, parameters: Parameters, objectives: Mapping[str, Mapping[str, Any]],
           predictions: Blocks = None, *, ranks: int = 1, **inverse: Any) -> Inverse:
    """Finds parameters with which runs agree best with data.

    Args:
        scene: a Scene, or its source.
        parameters: names as soil.E, or blocks by name: {"E": {"of": "soil.E", "transform": "log", "start": 1e6}}.
        objectives: blocks by name: {"crest": {"column": "track_crest_uy", "data": table, "deviation": 2e-3}}; data are
            a file or a DataFrame with the columns time and the objective's.
        predictions: blocks by name: {"last": {"column": "track_crest_uy"}}.
        ranks: number of processes.
        inverse: options of the block `inverse`, as method="blmvm".

    Raises:
        SceneError: the scene, a parameter or the data are wrong.
        RunError: the run with the start values gave up.
    """
    with tempfile.TemporaryDirectory(prefix="talus_data_") as folder:
        asked = _asked(scene, _named(parameters), objectives, predictions, Path(folder))
        results = run(asked, ranks=ranks, **{f"inverse_{key}": value for key, value in inverse.items()})
    found = results.summary["inverse"]
    names, none = found["parameters"], [np.nan] * len(found["parameters"])
    table = pd.DataFrame({"value": found["values"], "lower": found.get("lower", none), "upper": found.get("upper", none),
                          "sensitivity": found.get("sensitivities", none)}, index=names, dtype=float)
    square = {key: pd.DataFrame(found.get(key), names, names, dtype=float) for key in ("covariance", "correlation")}
    return Inverse(table, square["covariance"], square["correlation"], found.get("not_told_apart", []),
                   pd.DataFrame(found.get("predictions", {})).T, pd.read_csv(f"{results.prefix}_inverse.csv"), results)


class Residuals:
    """Residuals of data and priors, and their derivatives, at any parameters: for scipy's least_squares and others.

    Args:
        scene: a Scene, or its source.
        parameters: as of `invert`.
        objectives: as of `invert`.
        ranks: number of processes.

    Parameters are the transformed ones: logarithms where the block has `transform: log`.
    """

    def __init__(self, scene: Source, parameters: Parameters, objectives: Mapping[str, Mapping[str, Any]],
                 ranks: int = 1) -> None:
        self._folder = tempfile.TemporaryDirectory(prefix="talus_data_")
        self._parameters, self._ranks = _named(parameters), ranks
        self._scene = _asked(scene, self._parameters, objectives, None, Path(self._folder.name))
        self._last: tuple[Vector, Vector, Vector] | None = None

    @property
    def start(self) -> Vector:
        """Transformed values to start from, of blocks that have `start`."""
        return np.array([self._transform(block, float(block["start"])) for block in self._parameters.values()])

    @staticmethod
    def _bounds(block: Mapping[str, Any]) -> tuple[float, float]:
        bounds = block["bounds"]
        low, high = bounds.split(",") if isinstance(bounds, str) else bounds
        return float(low), float(high)

    def _transform(self, block: Mapping[str, Any], value: float) -> float:
        kind = block.get("transform", "none")
        if kind == "logit":
            low, high = self._bounds(block)
            return float(np.log((value - low) / (high - value)))
        return float(np.log(value)) if kind == "log" else value

    def values(self, theta: npt.ArrayLike) -> Vector:
        """The parameters of transformed ones."""
        found = []
        for block, t in zip(self._parameters.values(), np.asarray(theta, float)):
            kind = block.get("transform", "none")
            if kind == "logit":
                low, high = self._bounds(block)
                found.append(low + (high - low) / (1.0 + np.exp(-t)))
            else:
                found.append(np.exp(t) if kind == "log" else t)
        return np.array(found)

    def _slopes(self, values: Vector) -> Vector:
        """Derivatives of the parameters by the transformed ones."""
        found = []
        for block, value in zip(self._parameters.values(), values):
            kind = block.get("transform", "none")
            low, high = self._bounds(block) if kind == "logit" else (0.0, 1.0)
            found.append((value - low) * (high - value) / (high - low) if kind == "logit" else value if kind == "log" else 1.0)
        return np.array(found)

    def both(self, theta: npt.ArrayLike) -> tuple[Vector, Vector]:
        """Residuals, and their derivatives by the transformed parameters."""
        theta = np.asarray(theta, float)
        if self._last is None or not np.array_equal(self._last[0], theta):
            values = self.values(theta)
            options: dict[str, Any] = {f"parameter_{name}_start": float(value) for name, value in zip(self._parameters, values)}
            results = run(self._scene, ranks=self._ranks, inverse_iterations=0, **options)
            table, jacobian = (pd.read_csv(f"{results.prefix}_{name}.csv") for name in ("residuals", "jacobian"))
            slopes = jacobian[list(self._parameters)].to_numpy() * self._slopes(values) / table[["deviation"]].to_numpy()
            rows, prior = [table["residual"].to_numpy()], [slopes]
            for k, block in enumerate(self._parameters.values()):
                if "prior" in block:
                    deviation = float(block["deviation"])
                    rows.append(np.array([(theta[k] - self._transform(block, float(block["prior"]))) / deviation]))
                    prior.append(np.eye(len(theta))[k:k + 1] / deviation)
            self._last = (theta.copy(), np.concatenate(rows), np.concatenate(prior))
        return self._last[1], self._last[2]

    def residual(self, theta: npt.ArrayLike) -> Vector:
        """Residuals alone; derivatives there are kept."""
        return self.both(theta)[0]

    def jacobian(self, theta: npt.ArrayLike) -> Vector:
        """Derivatives of the residuals, [row, parameter]."""
        return self.both(theta)[1]


def residuals(scene: Source, theta: npt.ArrayLike, parameters: Parameters, objectives: Mapping[str, Mapping[str, Any]], *,
              ranks: int = 1) -> tuple[Vector, Vector]:
    """Residuals of a scene at transformed parameters, and their derivatives.

    Args:
        scene: a Scene, or its source.
        theta: transformed parameters.
        parameters: as of `invert`.
        objectives: as of `invert`.
        ranks: number of processes.
    """
    return Residuals(scene, parameters, objectives, ranks).both(theta)
