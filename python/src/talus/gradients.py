"""Derivatives of results by parameters, from the program's own adjoint or tangent run."""
from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Union

import pandas as pd

from .results import Results
from .running import _scene, run
from .scene import Scene

Objective = Union[str, Mapping[str, Mapping[str, Any]]]


@dataclass
class Gradient:
    """An objective and its derivatives.

    Attributes:
        objective: its value.
        values: derivatives by parameter, in the order asked for.
        results: those of the run.
    """

    objective: float
    values: pd.Series
    results: Results

    def _repr_html_(self) -> str:
        return str(pd.DataFrame({"derivative": self.values}).to_html())


def gradient(scene: Scene | Mapping[str, Any] | str | Path, parameters: Sequence[str], objective: Objective, *,
             method: str = "adjoint", ranks: int = 1, **options: Any) -> Gradient:
    """Runs a scene, and differentiates an objective through all of its steps.

    Args:
        scene: a Scene, or its source.
        parameters: names as soil.E or tip.factor: a number of a law, or the factor of a load.
        objective: a column of the history, whose last value it is; or blocks by name, whose sum it is:
            {"crest": {"column": "track_crest_uy", "data": "crest.csv", "deviation": 2e-3}}.
        method: adjoint, one run backward for all parameters; or tangent, one forward for each.
        ranks: number of processes.
        options: further options by name.

    Raises:
        SceneError: the scene, a parameter or an objective is wrong, or has no derivative yet.
        RunError: the run gave up.
    """
    blocks = {"objective": {"column": objective, "kind": "value"}} if isinstance(objective, str) else objective
    asked = {f"objective_{name}_{key}": value for name, block in blocks.items() for key, value in block.items()}
    changed = _scene(scene).changed(task="gradient", gradient_parameters=",".join(parameters), gradient_method=method,
                                    objectives=",".join(blocks), **asked)
    results = run(changed, ranks=ranks, **options)
    found = results.summary
    return Gradient(float(found["objective"]), pd.Series(found["gradient"], index=list(parameters), dtype=float), results)
