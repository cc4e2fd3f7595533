"""Pictures: of results, of scenes before a run, films.

    import talus

    results = talus.Results("out/look")
    talus.plot.draw(results, field="stress", component="yy").save("look.png")
    talus.plot.film(results, "look.gif", field="von_mises")
    talus.plot.scene("case.yaml")

Options are those of `talus plot`, underscores for dashes: steps=6, history=["track_tip_uy"], x="load", slice="z=0.5".
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from . import program
from .errors import SceneError
from .scene import Scene
from .tools import results as files

if TYPE_CHECKING:
    from .results import Results

SCRIPT = Path(__file__).parent / "tools" / "plot.py"


class Picture:
    """A picture that notebooks show."""

    def __init__(self, png: bytes) -> None:
        self.png = png

    def _repr_png_(self) -> bytes:
        return self.png

    def save(self, path: str | Path) -> None:
        """Writes the picture as PNG."""
        Path(path).write_bytes(self.png)


def _call(results: Results | str | Path, output: Path, options: Mapping[str, Any]) -> None:
    """Runs the script; its line is the text of the exception."""
    prefix = Path(results) if isinstance(results, (str, Path)) else results.prefix
    words = [str(prefix.resolve()), "--output", str(output)]
    for name, value in options.items():
        if value is False or value is None:
            continue
        values = [] if value is True else value if isinstance(value, (list, tuple)) else [value]
        words += ["--" + name.replace("_", "-"), *map(str, values)]
    done = subprocess.run([sys.executable, str(SCRIPT), *words], capture_output=True, text=True, check=False)
    if done.returncode or not output.exists():
        raise files.ResultsError((done.stderr.strip().splitlines() or ["plot.py drew nothing"])[-1])


def draw(results: Results | str | Path, **options: Any) -> Picture:
    """Draws results, or those of a prefix.

    Args:
        results: of a run, or the prefix of its files.
        options: those of `talus plot`, as field="stress", component="yy", step=20.

    Raises:
        ResultsError: a field, step or column is not there; the text says what is.
    """
    with tempfile.TemporaryDirectory(prefix="talus_") as folder:
        picture = Path(folder) / "picture.png"
        _call(results, picture, options)
        return Picture(picture.read_bytes())


def film(results: Results | str | Path, path: str | Path, **options: Any) -> Path:
    """Writes the states as a film, GIF or with ffmpeg MP4; its path.

    Args:
        results: of a run, or the prefix of its files.
        path: of the film.
        options: those of `talus plot`, as field="von_mises", fps=12.
    """
    place = Path(path).resolve()
    _call(results, place, {**options, "film": True})
    return place


def scene(source: Scene | Mapping[str, Any] | str | Path) -> Picture:
    """Draws a scene before any run, by `talus check --picture`.

    Raises:
        SceneError: the scene is wrong; the text is the program's line.
    """
    whole = source if isinstance(source, Scene) else Scene(source)
    with tempfile.TemporaryDirectory(prefix="talus_") as folder:
        picture = Path(folder) / "scene.png"
        words = [
            str(program.find_program()),
            "check",
            str(whole.write(Path(folder) / "scene.yaml")),
            "--picture",
            str(picture),
        ]
        environment = {**program.environment(1, folder), "TALUS_PYTHON": sys.executable}
        done = subprocess.run(words, env=environment, capture_output=True, text=True, check=False)
        if not picture.exists():
            raise SceneError(
                (done.stderr.strip().splitlines() or ["talus check drew nothing"])[-1].removeprefix("talus: error: ")
            )
        return Picture(picture.read_bytes())
