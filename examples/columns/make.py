#!/usr/bin/env python3
"""Writes FOLDER/columns_depth.asc: the depth 10 - sin(2 x) cos(y), with a pixel at the middle of each column of 0.125 m."""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent.parent / "scripts"))
from maps import write_ascii  # noqa: E402

SIZE = 0.125  # m


def main(folder):
    x = SIZE * (np.arange(42) - 0.5)
    write_ascii(Path(folder) / "columns_depth.asc", x, x, 10 - np.outer(np.cos(x), np.sin(2 * x)))


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else "out")
