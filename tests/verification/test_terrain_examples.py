#!/usr/bin/env python3
"""Examples of flow over terrain: exact solutions of a dam break, a bowl and a cap, a lake at rest, a real valley, mud, a torrent, a hillside.

Quick.
"""
import shutil
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import EXAMPLES, Test, call, example  # noqa: E402

import matplotlib  # noqa: E402

RUNS = (("ritter", 1, {}), ("cap", 3, {}), ("cap", 1, {"mpm_time_end": 5}), ("lake", 3, {}), ("bowl", 1, {}), ("mudflow", 1, {}), ("columns", 1, {}),
        ("valley", 1, {}), ("torrent", 1, {}), ("dem_slope", 1, {}))

with Test() as test:
    for name, ranks, options in RUNS:
        if name == "valley" and not list(Path(matplotlib.get_data_path()).glob("sample_data/jacksboro_fault_dem.npz")):
            continue
        folder = test.folder()
        if (EXAMPLES / name / "make.py").is_file() and name != "cap":
            made = call([sys.executable, EXAMPLES / name / "make.py", folder / "out"], folder)
            test.check(f"{name}.made", made.returncode, 0, 0)
        shutil.copy(example(name), folder / "case.yaml")
        for path in (EXAMPLES / name).glob("*.asc"):
            shutil.copy(path, folder)
        run = test.run(folder / "case.yaml", ranks=ranks, mpm_quiet=None, **options)
        test.check_example(f"{name}.{ranks}", run, name)
