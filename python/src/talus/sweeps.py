"""Parameter studies: many runs of one scene."""
from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any, Union

import pandas as pd

from .errors import RunError, SceneError
from .running import REFUSED, _scene, run
from .scene import Scene

Parameters = Union[Mapping[str, Sequence[Any]], Sequence[Mapping[str, Any]]]


def sweep(scene: Scene | Mapping[str, Any] | str | Path, parameters: Parameters, jobs: int = 2, ranks: int = 1,
          folder: str | Path | None = None, progress: Callable[[float], None] | None = None) -> pd.DataFrame:
    """Runs a scene with many sets of parameters, several at a time, each in a process of its own.

    Args:
        scene: a Scene, or its source.
        parameters: lists of values by option, of which all combinations run; or a list of dicts, one a run.
        jobs: runs at a time.
        ranks: processes of each run.
        folder: results of run 7 stay in folder/0007; by default none stay.
        progress: called with the completed fraction.

    Returns:
        a row a run: the parameters, `status` (0 completed, 2 refused, 3 gave up), `message` (the program's line), and
        the last row of the history, NaN where there is none.
    """
    base = _scene(scene)
    if isinstance(parameters, Mapping):
        sets = [dict(zip(parameters, values)) for values in itertools.product(*parameters.values())]
    else:
        sets = [dict(one) for one in parameters]

    def single(number: int) -> dict[str, Any]:
        place = None if folder is None else Path(folder) / f"{number:04d}"
        return {**sets[number], **_outcome(base, sets[number], ranks, place)}

    rows = []
    with ThreadPoolExecutor(max_workers=max(1, jobs)) as pool:
        for row in pool.map(single, range(len(sets))):
            rows.append(row)
            if progress is not None:
                progress(len(rows) / len(sets))
    return pd.DataFrame(rows)


def _outcome(scene: Scene, options: Mapping[str, Any], ranks: int, folder: Path | None) -> dict[str, Any]:
    """Status, message and last values of one run."""
    try:
        results, status, message = run(scene, ranks=ranks, folder=folder, **options), 0, ""
    except SceneError as error:
        return {"status": REFUSED, "message": str(error)}
    except RunError as error:
        if error.status is None:  # no run would start
            raise
        if error.results is None:
            return {"status": error.status, "message": error.line}
        results, status, message = error.results, error.status, error.line
    last = results.history.iloc[-1].to_dict() if len(results.history) else {}
    return {"status": status, "message": message, **last}
