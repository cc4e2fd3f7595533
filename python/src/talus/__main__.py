"""python -m talus import FILE: ground from other programs' files."""
from __future__ import annotations

import argparse
import sys
from pathlib import Path

from . import importers
from .errors import SceneError


def _numbers(text: str) -> list[float]:
    return [float(number) for number in text.split(",")]


def main(words: list[str] | None = None) -> int:
    """The command line; returns the exit status, 2 where the file is wrong."""
    parser = argparse.ArgumentParser(prog="python -m talus", description="Ground for Talus from other programs' files.")
    command = parser.add_subparsers(dest="command", required=True).add_parser(
        "import", help="blocks of a scene and a picture from a drawing, a mesh, a terrain or boreholes",
        description="Writes FILE.yaml, bodies for a scene, and FILE.png. Read are DXF (closed lines), Gmsh and other meshes, GeoTIFF "
                    "(a profile) and boreholes (CSV: name, x, top, bottom, material).")
    command.add_argument("file", type=Path)
    command.add_argument("--output", type=Path, metavar="SCENE.yaml", help="the scene's file; the picture stands beside it")
    command.add_argument("--start", type=_numbers, metavar="X,Y", help="where a profile through a terrain begins")
    command.add_argument("--end", type=_numbers, metavar="X,Y", help="where it ends")
    command.add_argument("--tolerance", type=float, metavar="M", help="of arcs and splines of a drawing, m (0.01)")
    given = parser.parse_args(words)
    output = given.output or Path(given.file.name).with_suffix(".yaml")
    options = {name: value for name in ("start", "end", "tolerance") if (value := getattr(given, name)) is not None}
    try:
        blocks = importers.read(given.file, folder=output.parent, **options)
        importers.write(blocks, output)
        importers.picture(blocks, output.with_suffix(".png"), output.parent)
    except (SceneError, OSError) as error:
        print(f"talus: error: {error}", file=sys.stderr)
        return 2
    print(f"{output} and {output.with_suffix('.png')} written: bodies {blocks['bodies'].replace(',', ', ')}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
