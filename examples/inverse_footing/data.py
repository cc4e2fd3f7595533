#!/usr/bin/env python3
"""Makes plate.csv: the curve of the footing on clay with the scene's own stiffness, at settlements between the steps.

    data.py PROGRAM
"""
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import yaml

FOLDER = Path(__file__).resolve().parent
sys.path.insert(0, str(FOLDER.parent))
from common import read_table  # noqa: E402

ANALYSIS = ("task", "parameter", "objective", "prediction", "inverse")
COLUMNS = ("track_centre_uy", "reaction_footing_y")


def main(program):
    scene = yaml.safe_load((FOLDER / "case.yaml").read_text(encoding="utf-8"))
    scene["mpm"] = {key: value for key, value in scene["mpm"].items() if not key.startswith(ANALYSIS)}
    with tempfile.TemporaryDirectory() as place:
        file = Path(place) / "truth.yaml"
        file.write_text(yaml.safe_dump(scene), encoding="utf-8")
        subprocess.run([program, file, "-mpm_quiet"], cwd=place, check=True)
        history = read_table(Path(place) / "inverse_footing_history.csv")
    settlement, force = (np.concatenate([[0.0], history[name]]) for name in COLUMNS)
    places = settlement[-1] * np.arange(1, 11) / 10.5
    rows = zip(places, np.interp(-places, -settlement, force))
    (FOLDER / "plate.csv").write_text(",".join(COLUMNS) + "\n" + "".join(f"{a:.17g},{b:.17g}\n" for a, b in rows),
                                      encoding="utf-8")


if __name__ == "__main__":
    main(Path(sys.argv[1]).resolve())
