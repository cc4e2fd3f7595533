#!/usr/bin/env python3
"""The example inverse_field: a stiff inclusion from displacements of the surface, as close as their noise allows.

Quick.
"""
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import Test, example  # noqa: E402

with Test() as test:
    test.check_example("inverse_field", test.run(example("inverse_field"), mpm_quiet=None), "inverse_field")
