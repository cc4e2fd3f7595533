#!/usr/bin/env python3
"""Writes FOLDER/dem_slope_ground.asc and dem_slope_rock.asc: a slope of 2:1 with a hollow, and the rock beneath its soil."""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent.parent / "scripts"))
from maps import write_ascii  # noqa: E402

CREST, TOE = (17.0, 15.0), (37.0, 5.0)  # m: x and height
HOLLOW, WIDTH = 3.0, 28.0  # m: how far the slope moves back in the middle and on at the sides; from side to side


def ground(x, y):
    moved = HOLLOW * np.cos(2.0 * np.pi * y / WIDTH)
    return np.interp(x - moved, [CREST[0], TOE[0]], [CREST[1], TOE[1]])


def soil(x, y):
    """Depth: most in the hollow, and in the middle of the slope."""
    moved = HOLLOW * np.cos(2.0 * np.pi * y / WIDTH)
    across = 1.5 + 3.5 * np.exp(-(((y - 0.5 * WIDTH) / 6.0) ** 2))
    return np.maximum(across * np.clip(1.0 - ((x - moved - 27.0) / 18.0) ** 2, 0.2, 1.0), 1.0)


def main(folder):
    x, y = np.arange(-2.0, 58.1, 2.0), np.arange(-2.0, 30.1, 2.0)
    top = ground(*np.meshgrid(x, y))
    write_ascii(Path(folder) / "dem_slope_ground.asc", x, y, top)
    write_ascii(Path(folder) / "dem_slope_rock.asc", x, y, top - soil(*np.meshgrid(x, y)))


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else "out")
