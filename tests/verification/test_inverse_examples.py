#!/usr/bin/env python3
"""Examples of inverse analyses by twins: the friction of a bed from a deposit, clay from settlements, the ramp of a load that leaves a bar at rest.

Quick.
"""
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import Test, example  # noqa: E402

with Test() as test:
    for name in ("inverse_runout", "inverse_embankment", "optimal_ramp"):
        test.check_example(name, test.run(example(name), mpm_quiet=None), name)
