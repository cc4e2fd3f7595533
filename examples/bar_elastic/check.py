#!/usr/bin/env python3
"""Compares a run of bar_elastic with its exact solution."""
import sys
from pathlib import Path

FOLDER = Path(__file__).resolve().parent
sys.path.insert(0, str(FOLDER.parent))
import bar  # noqa: E402
import common  # noqa: E402

COLUMN = bar.ElasticColumn
RELATIVE = 0.01  # how near the tabulated error has to be

if __name__ == "__main__":
    common.main(lambda results: bar.check(results, COLUMN, FOLDER, RELATIVE), lambda results: bar.draw(results, COLUMN))
