"""Runs of the program."""
from __future__ import annotations

import re
import subprocess
import tempfile
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import IO, Any, Union

from . import program
from .errors import RunError, SceneError
from .results import Results
from .scene import Scene

Progress = Union[bool, Callable[[float], None], None]
DONE = re.compile(r"\s(\d+(?:\.\d+)?)%(?:\s|$)")
REFUSED = 2


def _scene(scene: Scene | Mapping[str, Any] | str | Path) -> Scene:
    return scene if isinstance(scene, Scene) else Scene(scene)


def run(scene: Scene | Mapping[str, Any] | str | Path, ranks: int = 1, folder: str | Path | None = None,
        progress: Progress = None, check: bool = True, **options: Any) -> Results:
    """Runs a scene and waits for its end.

    Args:
        scene: a Scene, or its source.
        ranks: number of processes.
        folder: of the results, made if need be; by default one that goes with the results.
        progress: True prints the program's lines; a function is called with the completed fraction.
        check: False returns the results of a run that gave up, too.
        options: further options by name, as material_soil_E=20e6.

    Raises:
        SceneError: the scene is wrong; nothing was run.
        RunError: the run gave up, or could not start.
    """
    changed = _scene(scene).changed(**options)
    changed["output_prefix"] = prefix = Path(str(changed.get("output_prefix", "talus"))).name
    keep = tempfile.TemporaryDirectory(prefix="talus_") if folder is None else None
    place = Path(keep.name if keep is not None else folder or "").resolve()
    place.mkdir(parents=True, exist_ok=True)
    status, output, errors = _call(changed.write(place / f"{prefix}.yaml"), ranks, progress)
    line = _own_line(errors)
    if status == REFUSED:
        raise SceneError(line)
    results = Results(place / prefix, status, output, keep) if (place / f"{prefix}_summary.json").is_file() else None
    if results is None or (check and status != 0):
        raise RunError(line or "the program ended without a line", status, results)
    return results


def _call(scene: Path, ranks: int, progress: Progress) -> tuple[int, str, str]:
    """Runs the program in the scene's folder: exit status, output and errors."""
    words = program.command(scene, ranks)
    with tempfile.TemporaryDirectory(prefix="talus_mpi_", ignore_cleanup_errors=True) as session, \
            tempfile.TemporaryFile("w+", errors="replace") as errors:
        try:
            process = subprocess.Popen(words, cwd=scene.parent, env=program.environment(ranks, session),
                                       stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=errors, text=True,
                                       errors="replace")
        except OSError as error:
            raise RunError(f"{words[0]}: {error.strerror}") from error
        assert process.stdout is not None
        try:
            output = _follow(process.stdout, progress)
            status = process.wait()
        except BaseException:
            process.terminate()
            process.wait()
            raise
        errors.seek(0)
        return status, output, errors.read()


def _follow(stream: IO[str], progress: Progress) -> str:
    """The lines of a run as they come."""
    lines = []
    for line in stream:
        lines.append(line)
        if progress is True:
            print(line, end="", flush=True)
        elif callable(progress):
            done = DONE.search(line)
            if done:
                progress(float(done[1]) / 100.0)
    return "".join(lines)


def _own_line(errors: str) -> str:
    """The program's line among those of mpiexec, without its beginning."""
    own = [line for line in errors.splitlines() if line.startswith("talus: ") and not line.startswith("talus: warning")]
    if own:
        return own[-1].removeprefix("talus: ").removeprefix("error: ")
    return next((line for line in errors.splitlines() if line.strip("- ")), "")
