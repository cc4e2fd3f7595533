#!/usr/bin/env python3
"""The example inverse_excavation: readings in stages tell the ground's parameters, and what the next stage brings.

Quick.
"""
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import Test, example  # noqa: E402

with Test() as test:
    test.check_example("inverse_excavation", test.run(example("inverse_excavation"), mpm_quiet=None), "inverse_excavation")
