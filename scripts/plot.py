#!/usr/bin/env python3
"""Pictures of the results of a run: `talus plot PREFIX`, `talus view PREFIX`; `--help` lists what can be drawn."""

import os
import sys

os.environ.setdefault("HDF5_USE_FILE_LOCKING", "FALSE")  # a run that goes on has the file open

try:
    from pictures.command import main
except ModuleNotFoundError as missing:
    sys.exit(f"plot.py: Python package {missing.name} is missing: install numpy, h5py, matplotlib and pillow")

if __name__ == "__main__":
    program = os.environ.get("TALUS_COMMAND", "plot.py")
    sys.exit(main(program=program))
