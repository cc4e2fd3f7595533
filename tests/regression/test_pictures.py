#!/usr/bin/env python3
"""Pictures of short runs: all corners of all domains lie within the axes, and each picture looks like the one stored.

The stored ones, in pictures/, are small copies that a person has looked at. Two pictures are alike when the mean
colours of all blocks of 8 x 8 pixels are. With TALUS_PICTURES=FOLDER the pictures of this run go to that folder, small as the
stored ones and, in FOLDER/full, as they were drawn: look at them before they replace the stored ones.
"""

import os
import sys
from pathlib import Path

import numpy as np
from PIL import Image

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import ROOT, Test, example  # noqa: E402
from pictures import command, space, states, style  # noqa: E402
from pictures.scene import Scene  # noqa: E402

STORED = Path(__file__).resolve().parent / "pictures"
VERIFICATION = ROOT / "tests" / "verification"
WIDTH, BLOCK = 320, 8  # pixels, of a stored picture and of a block
MEAN, LARGEST = 1.0, 25.0  # of 255: differences of a picture's and of one block's mean colour

SHORT = {
    "mpm_stage_first_time_end": 4.32e4,
    "mpm_stage_pause_time_end": 1e6,
    "mpm_stage_second_time_end": 8.64e4,
    "mpm_stage_years_time_end": 1e6,
    "mpm_stage_years_time_step": 1e6,
    "mpm_stage_pause_time_step": 1e6,
    "mpm_output_every": 100,
}
# Name, scene, options of the run, pictures: name and words of the command line; the first is that of the last state.
RUNS = (
    ("lift", VERIFICATION / "lift.yaml", {}, {"lift": ()}),
    ("plate", STORED / "plate.yaml", {}, {"plate": ()}),
    (
        "road",
        STORED / "road.yaml",
        {},
        {
            "road": (),
            "road_scene": ("--scene",),
            "road_wall": ("--section", "wall"),
            "road_film": ("--steps", "4"),
            "road_curves": ("--history", "track_crest_uy", "track_toe_ux", "reaction_base_y"),
        },
    ),
    (
        "bank",
        STORED / "bank.yaml",
        {},
        {"bank": ("--scale", "5", "--arrows"), "bank_scene": ("--scene",), "bank_body": ("--field", "body")},
    ),
    (
        "collapse",
        example("collapse"),
        {"mpm_grid_cells": "16,8", "mpm_time_step": 0.1},
        {
            "collapse": ("--field", "stress", "--component", "yy", "--contours", "6"),
            "collapse_first": ("--step", "first"),
        },
    ),
    (
        "slump",
        example("slump3d"),
        {"mpm_body_block_points_per_cell": "2,2,2", "mpm_time_step": 0.25},
        {"slump": ("--field", "pressure"), "slump_slice": ("--slice", "x=0.3", "--field", "pressure")},
    ),
    (
        "discs",
        example("discs"),
        {"mpm_time_end": 2.0, "mpm_output_every": 1000},
        {"discs": ("--field", "von_mises", "--arrows", "velocity")},
    ),
    (
        "cantilever",
        example("cantilever"),
        {"mpm_time_step": 0.1},
        {"cantilever": ("--field", "stress", "--component", "xx")},
    ),
    ("embankment", example("embankment"), SHORT, {"embankment": ("--field", "pressure")}),
    ("seepage", example("seepage"), {"mpm_output_every": 100}, {"seepage": ("--field", "pressure")}),
    ("pipe", example("pipe"), {"mpm_time_end": 0.02}, {"pipe": ()}),
    ("cavity", example("cavity_axisymmetric"), {"mpm_time_end": 0.05}, {"cavity": ()}),
    ("triaxial", example("triaxial"), {}, {"triaxial": ()}),
)


def corners_within(figure, results, words):
    """How far inside the axes the outermost corner is, over their extent: negative where one is cut off."""
    arguments = command.plot_parser("plot").parse_args([results.prefix, *words])
    scene, state = Scene(results), results.state(arguments.step)
    axes = figure.axes[0]
    limits = np.array([axes.get_xlim(), axes.get_ylim()] + ([axes.get_zlim()] if state.dim == 3 else []))
    corners = (
        space.space_corners(results, state, arguments)
        if state.dim == 3
        else states.look_of(results, scene, state, arguments).domains.corners
    )
    corners = corners.reshape(-1, state.dim)
    inside = min(np.min(corners - limits[:, 0]), np.min(limits[:, 1] - corners))
    return inside / np.max(np.ptp(corners, axis=0))


def draw(results, words):
    """The figure of a command line, and its pixels as they would be stored."""
    arguments = command.plot_parser("plot").parse_args([results.prefix, *words])
    figure = command.draw(results, Scene(results), arguments)
    style.settle(figure)
    figure.set_dpi(style.DPI)
    figure.canvas.draw()
    whole = Image.fromarray(np.asarray(figure.canvas.buffer_rgba())[:, :, :3].copy())
    small = whole.resize((WIDTH, round(whole.height * WIDTH / whole.width)), Image.Resampling.BOX)
    return figure, whole, small.quantize(64, dither=Image.Dither.NONE)


def blocks(picture):
    """Mean colours of blocks, (rows, columns, 3)."""
    pixels = np.asarray(picture.convert("RGB")).astype(float)
    rows, columns = (size // BLOCK for size in pixels.shape[:2])
    return pixels[: rows * BLOCK, : columns * BLOCK].reshape(rows, BLOCK, columns, BLOCK, 3).mean(axis=(1, 3))


def compare(test, name, small):
    """Checks a picture beside the stored one."""
    stored = STORED / f"{name}.png"
    if not stored.exists():
        test.check(f"{name}.stored", 0, 1, 1)
        return
    other = Image.open(stored)
    test.check(f"{name}.height", abs(other.height - small.height), None, 2)
    one, two = blocks(small), blocks(other)
    rows = min(len(one), len(two))
    difference = np.abs(one[:rows] - two[:rows])
    test.check(f"{name}.mean", difference.mean(), None, MEAN)
    test.check(f"{name}.largest", difference.max(), None, LARGEST)


def keep(name, whole, small):
    folder = os.environ.get("TALUS_PICTURES")
    if folder:
        (Path(folder) / "full").mkdir(parents=True, exist_ok=True)
        small.save(Path(folder) / f"{name}.png", optimize=True)
        whole.save(Path(folder) / "full" / f"{name}.png", optimize=True)


def main():
    style.apply()
    with Test() as test:
        for label, path, options, pictures in RUNS:
            results = test.run(path, mpm_quiet=None, **options).results
            for number, (name, words) in enumerate(pictures.items()):
                figure, whole, small = draw(results, words)
                if number == 0 and label != "triaxial":
                    test.check(f"{label}.corners_within", corners_within(figure, results, words), 0.015)
                keep(name, whole, small)
                compare(test, name, small)
                command.plt.close(figure)


if __name__ == "__main__":
    main()
