#!/usr/bin/env python3
"""Makes ground.csv, the ground that is sought, and readings.csv: displacements of the surface with it, and noise of 1 %.

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
CELLS, SIZE = (40, 25), 0.5  # of the grid, m
NOISE = 0.01  # of the root mean square of the readings


def ground():
    """Places and stiffness of the cells."""
    x, y = np.meshgrid((np.arange(CELLS[0]) + 0.5) * SIZE, (np.arange(CELLS[1]) + 0.5) * SIZE)
    inside = ((x - 8.0) / 4.0)**2 + ((y - 8.0) / 3.0)**2 < 1.0
    return x.ravel(), y.ravel(), np.where(inside, 200e6, 50e6).ravel()


def write(name, columns, rows):
    (FOLDER / name).write_text("\n".join([",".join(columns)] + [",".join(f"{value:.9g}" for value in row) for row in rows]) + "\n",
                               encoding="utf-8")


def main(program):
    write("ground.csv", ("x", "y", "value"), zip(*ground()))
    scene = yaml.safe_load((FOLDER / "case.yaml").read_text(encoding="utf-8"))
    names = scene["mpm"]["tracks"].split(",")
    scene["mpm"] = {key: value for key, value in scene["mpm"].items() if not key.startswith(ANALYSIS)}
    scene["mpm"]["field_stiff"] = {"of": "rock.E", "by": "cell", "file": str(FOLDER / "ground.csv")}
    with tempfile.TemporaryDirectory() as place:
        file = Path(place) / "truth.yaml"
        file.write_text(yaml.safe_dump(scene), encoding="utf-8")
        subprocess.run([program, file, "-mpm_quiet"], cwd=place, check=True)
        history = read_table(Path(place) / "inverse_field_history.csv")
    columns = [f"track_{name}_u{axis}" for name in names for axis in "xy"]
    exact = np.stack([history[name] for name in columns], axis=1)
    deviation = NOISE * np.sqrt((exact**2).mean())
    noisy = exact + deviation * np.random.default_rng(7).standard_normal(exact.shape)
    print(f"{exact.size} readings, deviation {deviation:.4g} m")
    write("readings.csv", ["time"] + columns, np.column_stack([history["time"], noisy]))


if __name__ == "__main__":
    main(Path(sys.argv[1]).resolve())
