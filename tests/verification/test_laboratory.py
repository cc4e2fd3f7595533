#!/usr/bin/env python3
"""A laboratory test of each law that example laboratory has, by the example's own check; and that every law has such a test."""
import re
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import EXAMPLES, ROOT, Test, example  # noqa: E402

FOLDER = EXAMPLES / "laboratory"


def coverage(test):
    """Every law is the material of some example with physics stress_point."""
    shown = set()
    for path in EXAMPLES.glob("*/*.yaml"):
        text = path.read_text(encoding="utf-8")
        if "stress_point" in text:
            shown.update(re.findall(r"type: *(\w+)", text))
    for law in sorted((ROOT / "materials").glob("*.c")):
        test.check(f"scene_of.{law.stem}", law.stem in shown, 1, 1)


with Test() as test:
    coverage(test)
    test.check_example("j2", test.run(example("laboratory"), mpm_quiet=None), "laboratory")
    for path in sorted(FOLDER.glob("*.yaml")):
        if path.name == "nacc.yaml":
            test.check_example("nacc", test.run(path, mpm_quiet=None, mpm_point_table=FOLDER / "snow.csv"), "laboratory")
        elif path.name != "case.yaml":
            both = test.folder() / "both.opts"
            both.write_text(f"-options_file {example('laboratory')}\n-options_file {path}\n", encoding="utf-8")
            test.check_example(path.stem, test.run(both, mpm_quiet=None), "laboratory")
