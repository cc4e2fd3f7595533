"""Exceptions of the package."""
from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .results import Results


class SceneError(ValueError):
    """A scene is wrong; the text names the place, the value and what is accepted."""


class RunError(RuntimeError):
    """A run gave up or could not start.

    Attributes:
        line: the program's own line.
        status: its exit status (3: gave up; 4: a file could not be written), None where it did not start.
        results: the results so far, where there are any.
    """

    def __init__(self, line: str, status: int | None = None, results: Results | None = None) -> None:
        super().__init__(line if status is None else f"{line} (exit status {status})")
        self.line, self.status, self.results = line, status, results
