"""Scenes: nested options as in the program's files, checked against its schema."""
from __future__ import annotations

import copy
import difflib
import os
import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
import numpy.typing as npt
import pandas as pd
import yaml

from .errors import SceneError
from .program import validator

Block = dict[str, Any]
AXES = ("x", "y", "z")
SYMMETRIC = ("xx", "yy", "zz", "xy", "yz", "xz")
FULL = ("xx", "xy", "xz", "yx", "yy", "yz", "zx", "zy", "zz")


class _Loader(yaml.SafeLoader):
    """Words and numbers as the program reads them: `10e6` is a number, `off` a word; no key stands twice."""

    def construct_mapping(self, node: Any, deep: bool = False) -> Block:
        keys = [key.value for key, _ in node.value]
        for key in keys:
            if keys.count(key) > 1:
                raise SceneError(f"{key}: is there twice, line {node.start_mark.line + 1}")
        return dict(super().construct_mapping(node, deep))


_PATTERNS = {"null": (r"~|null|", "~n"), "bool": (r"true|false", "tf"), "int": (r"[-+]?\d+", "-+0123456789"),
             "float": (r"[-+]?(\.\d+|\d+\.?\d*)([eE][-+]?\d+)?", "-+.0123456789")}
_Loader.yaml_implicit_resolvers = {}
for _kind, (_pattern, _first) in _PATTERNS.items():
    _Loader.add_implicit_resolver(f"tag:yaml.org,2002:{_kind}", re.compile(rf"^(?:{_pattern})$"), [*_first, ""])


class _Dumper(yaml.SafeDumper):
    """An option without a value has none in the file."""


_Dumper.add_representer(type(None), lambda dumper, _: dumper.represent_scalar("tag:yaml.org,2002:null", ""))


def _plain(value: Any, place: str) -> Any:
    """A value without types of numpy: dicts, lists, numbers, texts."""
    if isinstance(value, Mapping):
        return {str(key): _plain(inner, f"{place}/{key}" if place else str(key)) for key, inner in value.items()}
    if isinstance(value, (np.ndarray, list, tuple)):
        return [_plain(part, place) for part in (value.tolist() if isinstance(value, np.ndarray) else value)]
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, Path):
        return str(value)
    if value is None or isinstance(value, (bool, int, float, str)):
        return value
    raise SceneError(f"{place}: {value!r} is no text, number or list of these")


def _text(value: Any) -> Any:
    """A value as it stands in the file: lists are texts with commas."""
    if isinstance(value, dict):
        return {key: _text(inner) for key, inner in value.items()}
    return ",".join(str(part) for part in value) if isinstance(value, list) else value


def _find(block: Block, name: str) -> tuple[Block, str] | None:
    """The block that holds an option, and the option's name in it."""
    if name in block:
        return block, name
    for key, inner in block.items():
        if isinstance(inner, dict) and name.startswith(key + "_"):
            found = _find(inner, name[len(key) + 1:])
            if found is not None:
                return found
    return None


def _home(block: Block, name: str) -> tuple[Block, str]:
    """The innermost block that a new option belongs to, and the option's name in it."""
    heads = [key for key, inner in block.items() if isinstance(inner, dict) and name.startswith(key + "_")]
    if not heads:
        return block, name
    head = max(heads, key=len)
    return _home(block[head], name[len(head) + 1:])


def _flat(block: Block, head: str) -> Iterator[tuple[str, Any]]:
    for key, value in block.items():
        if isinstance(value, dict):
            yield from _flat(value, f"{head}{key}_")
        else:
            yield head + key, value


def _fault(error: Any) -> str:
    """Place and reason of an error of the schema: of alternatives, the innermost that is about more than the type."""
    while error.context:
        error = max(error.context, key=lambda inner: (len(inner.path), inner.validator != "type"))
    place = "/".join(map(str, error.absolute_path))
    if error.validator == "additionalProperties":
        known, patterns = list(error.schema["properties"]), "|".join(error.schema.get("patternProperties", ())) or "$^"
        name = next(key for key in error.instance if key not in known and not re.search(patterns, key))
        near = difflib.get_close_matches(name, known, 1)
        return f"{place}/{name}: no such option" + (f"; the nearest is {near[0]}" if near else "")
    if error.validator == "pattern":
        return f"{place}: {error.instance!r} is no number, nor numbers with commas"
    if error.validator == "not":
        return f"{place}: {error.schema.get('description', error.message)}"
    return f"{place}: {error.message}"


def _components(name: str, width: int, dim: int) -> list[str]:
    """Names of the columns of a field of points."""
    axes: dict[int, tuple[str, ...]] = {dim: AXES[:dim], 6: SYMMETRIC, 9: FULL}
    if width not in axes:
        raise SceneError(f"{name}: {width} components; {dim}, 6 or 9 are known")
    return [f"{name}_{axis}" for axis in axes[width]]


class Scene:
    """A scene: the options of a run, nested as in its file in YAML.

    Args:
        source: path of a file in YAML, or a dict with the block `mpm` and PETSc's options beside it.
        check: False leaves out the comparison with the schema, for laws and terms of plugins.

    Options are read and set by name, in whatever blocks they stand:

        scene = Scene("case.yaml")
        scene["material_soil_E"] = 20e6
        scene["-snes_rtol"] = 1e-10         # with a dash, PETSc's own

    Raises:
        SceneError: the file is no scene, or an option is unknown or out of bounds.
    """

    def __init__(self, source: Mapping[str, Any] | str | Path, check: bool = True) -> None:
        self.checked = check
        self.base: Path | None = None  # folder of relative names of files
        self._tables: dict[str, pd.DataFrame] = {}  # points of bodies by the body's name
        if isinstance(source, Mapping):
            self.content: Block = _plain(source, "")
        else:
            self.base = Path(source).resolve().parent
            self.content = self._read(Path(source))
        if not isinstance(self.content.get("mpm"), dict):
            raise SceneError("mpm: the scene has no such block")
        self.check()

    @staticmethod
    def _read(path: Path) -> Block:
        try:
            content = yaml.load(path.read_text(encoding="utf-8"), Loader=_Loader)
        except OSError as error:
            raise SceneError(f"{path}: cannot be read: {error.strerror}") from error
        except yaml.YAMLError as error:
            raise SceneError(f"{path}: is no YAML: {' '.join(str(error).split())}") from error
        return content if isinstance(content, dict) else {}

    def check(self) -> None:
        """Compares the scene with the program's schema.

        Raises:
            SceneError: the text is the place, as `mpm/grid/cells`, and what is wrong there.
        """
        self.options()
        errors = list(validator().iter_errors(self.content)) if self.checked else []
        if errors:
            raise SceneError(_fault(max(errors, key=jsonschema.exceptions.relevance)))

    def _block(self, name: str) -> tuple[Block, str]:
        """The outermost block of an option, and its name in it."""
        name = name.replace(".", "_")
        if name.startswith("-") and not name.startswith("-mpm_"):
            return self.content, name[1:]
        return self.content["mpm"], name.removeprefix("-").removeprefix("mpm_")

    def __getitem__(self, name: str) -> Any:
        """An option or a block by name; `material_soil_E`, `material_soil.E` and `-mpm_material_soil_E` are equal."""
        found = _find(*self._block(name))
        if found is None:
            raise KeyError(f"{name}: the scene does not set it")
        block, key = found
        return block[key]

    def __setitem__(self, name: str, value: Any) -> None:
        outer, inner = self._block(name)
        block, key = _find(outer, inner) or _home(outer, inner)
        block[key] = _plain(value, name)

    def __delitem__(self, name: str) -> None:
        found = _find(*self._block(name))
        if found is None:
            raise KeyError(f"{name}: the scene does not set it")
        block, key = found
        del block[key]

    def __contains__(self, name: object) -> bool:
        return isinstance(name, str) and _find(*self._block(name)) is not None

    def get(self, name: str, default: Any = None) -> Any:
        """An option, or a default where the scene does not set it."""
        return self[name] if name in self else default

    def options(self) -> dict[str, Any]:
        """All options by whole name, as `mpm_material_soil_E`.

        Raises:
            SceneError: an option stands twice.
        """
        flat: dict[str, Any] = {}
        for name, value in _flat(self.content, ""):
            if name in flat:
                raise SceneError(f"{name}: is there twice")
            flat[name] = value
        return flat

    def changed(self, **options: Any) -> Scene:
        """A copy with other options."""
        other = copy.deepcopy(self)
        for name, value in options.items():
            other[name] = value
        return other

    def add_body(self, name: str, positions: npt.ArrayLike, volumes: npt.ArrayLike, material: str,
                 columns: Mapping[str, npt.ArrayLike] | None = None, **options: Any) -> None:
        """Adds a body of points.

        Args:
            name: of the body.
            positions: m, (points, dim).
            volumes: m3, in plane strain m2; (points).
            material: name of a material of the scene.
            columns: further fields by name, (points) or (points, components), as velocity, stress, pressure.
            options: of the block `body_NAME`.
        """
        table = self._table(name, np.asarray(positions, float), {"volume": volumes, **(columns or {})})
        bodies = self.get("bodies", [])
        names = bodies if isinstance(bodies, list) else [word.strip() for word in str(bodies).split(",")]
        self["bodies"] = [*names, *([] if name in names else [name])]
        self.content["mpm"][f"body_{name}"] = {"region": "file", "material": material, **_plain(options, name)}
        self._tables[name] = table

    @staticmethod
    def _table(name: str, positions: npt.NDArray[np.float64], columns: Mapping[str, npt.ArrayLike]) -> pd.DataFrame:
        if positions.ndim != 2 or positions.shape[1] not in (2, 3) or not len(positions):
            raise SceneError(f"body_{name}/positions: shape {positions.shape}; (points, 2) or (points, 3) is accepted")
        dim = positions.shape[1]
        table = pd.DataFrame(positions, columns=list(AXES[:dim]))
        for key, given in columns.items():
            values = np.asarray(given, float)
            if values.shape[:1] != (len(table),) or values.ndim > 2:
                raise SceneError(f"body_{name}/{key}: shape {values.shape}; a row a point ({len(table)}) is accepted")
            names = [key] if values.ndim == 1 else _components(key, values.shape[1], dim)
            table[names] = values.reshape(len(table), -1)
        if not np.isfinite(table.to_numpy()).all():
            raise SceneError(f"body_{name}: a value is not finite")
        if not (table["volume"] > 0).all():
            raise SceneError(f"body_{name}/volumes: {table['volume'].min():g}; positive ones are accepted")
        return table

    def write(self, path: str | Path) -> Path:
        """Writes the scene in YAML, and beside it the points of its bodies as CSV; names of files become absolute.

        Returns:
            the scene's path.
        """
        path = Path(path).resolve()
        self.check()
        content = self._resolved(copy.deepcopy(self.content))
        for name, table in self._tables.items():
            block = content["mpm"].get(f"body_{name}")
            if block is not None:
                block["file"] = f"{path.stem}_{name}.csv"
                table.to_csv(path.with_name(block["file"]), index=False)
        path.write_text(yaml.dump(_text(content), Dumper=_Dumper, sort_keys=False, width=1000), encoding="utf-8")
        return path

    def _resolved(self, block: Block) -> Block:
        for key, value in block.items():
            if isinstance(value, dict):
                self._resolved(value)
            elif isinstance(value, str) and self.base is not None and os.path.isfile(self.base / value):
                block[key] = str(self.base / value)
        return block

    def __repr__(self) -> str:
        return f"Scene({self.get('title') or len(self.options())!r})"
