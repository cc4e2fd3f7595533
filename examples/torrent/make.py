#!/usr/bin/env python3
"""Writes FOLDER/torrent_bed.asc and torrent_soil.asc, a gully that opens on a fan and the debris in it, and torrent.csv, a flood."""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent.parent / "scripts"))
from maps import gully_on_fan, write_ascii  # noqa: E402

FAN = 420.0  # m: where the gully ends and the fan begins


def middle(x):
    """y of the gully."""
    return 120.0 + 14.0 * np.sin(x / 60.0) * np.exp(-((x / 400.0) ** 6))


def bed(x, y):
    return gully_on_fan(x, y, FAN, middle(x), (0.28, 0.07), 40.0, ends=25.0, depth=15.0, width=24.0, dome=0.0008, centre=120.0)


def soil(x, y):
    """Depth of loose debris: most in the middle of the gully."""
    return 1.5 * np.exp(-(((y - middle(x)) / 10.0) ** 2)) / (1.0 + np.exp((x - FAN) / 15.0))


def main(folder):
    x, y = np.arange(-4.0, 704.1, 4.0), np.arange(-4.0, 244.1, 4.0)
    write_ascii(Path(folder) / "torrent_bed.asc", x, y, bed(*np.meshgrid(x, y)))
    write_ascii(Path(folder) / "torrent_soil.asc", x, y, soil(*np.meshgrid(x, y)))
    (Path(folder) / "torrent.csv").write_text("time,discharge\n0,0\n5,60\n15,60\n40,0\n", encoding="utf-8")


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else "out")
