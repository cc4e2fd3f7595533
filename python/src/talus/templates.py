"""Scenes to start from: those of `talus new`.

    scene = talus.templates.scene("slope")
    scene["material_clay_cohesion"] = 20e3
    results = talus.run(scene)
"""
from __future__ import annotations

import subprocess

import yaml

from .errors import SceneError
from .program import find_program
from .scene import Scene


def _new(*words: str) -> str:
    """What `talus new` prints."""
    ended = subprocess.run([str(find_program()), "new", *words], capture_output=True, text=True, check=False)
    if ended.returncode:
        raise SceneError(ended.stderr.strip().removeprefix("talus: error: "))
    return ended.stdout


def names() -> list[str]:
    """Names of all templates."""
    return [line.split()[0] for line in _new().splitlines() if line.startswith("  ")]


def text(name: str) -> str:
    """A template as a file, with its comments."""
    return _new(name, "-")


def scene(name: str) -> Scene:
    """A template as a scene."""
    return Scene(yaml.safe_load(text(name)))
