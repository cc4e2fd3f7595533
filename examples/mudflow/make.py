#!/usr/bin/env python3
"""Writes FOLDER/mudflow_bed.asc: a gully that winds down a slope and opens on a fan, pixels of 5 m."""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent.parent / "scripts"))
from maps import gully_on_fan, write_ascii  # noqa: E402

FAN = 450.0  # m: where the slope ends and the fan begins


def middle(x):
    """y of the gully."""
    return 160.0 + 25.0 * np.sin(x / 70.0) * np.exp(-((x / 420.0) ** 6))


def bed(x, y):
    return gully_on_fan(x, y, FAN, middle(x), (0.45, 0.06), 40.0, ends=30.0, depth=18.0, width=38.0, dome=0.0006, centre=160.0)


def main(folder):
    x, y = np.arange(-5.0, 805.1, 5.0), np.arange(-5.0, 325.1, 5.0)
    write_ascii(Path(folder) / "mudflow_bed.asc", x, y, bed(*np.meshgrid(x, y)))


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else "out")
