#!/usr/bin/env python3
"""Sixty spoilt scenes, command lines and files, always the same ones: see scripts/fuzz.py."""
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "scripts"))
import fuzz  # noqa: E402  (the folder has to be known first)

if len(sys.argv) != 2:
    sys.exit(f"usage: {Path(sys.argv[0]).name} path/to/talus")
sys.exit(fuzz.main([sys.argv[1], "--cases", "60", "--seed", "6", "--jobs", "2", "--time", "20"]))
