#!/usr/bin/env python3
"""Writes what the laboratory needs to follow a run of biaxial_nor_sand: PREFIX_path.csv, a row a step.

The axial strain is that of the specimen: displacements of a homogeneous one grow with height. The platen's indentation, a
millionth of its height, is in it. The lateral stress is the load on the sides over the height that they have.
"""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "scripts"))
from results import Results  # noqa: E402


def ramp(results, name):
    """Times and factors."""
    return np.array([[float(part) for part in pair.split(":")] for pair in results.option(name).split(",")]).T


def path(results):
    """Time, axial stretch and lateral stress by step."""
    time = results.column("time")
    stretch = 1.0 + results.column("track_specimen_uy") / results.initial["position0"][:, 1].mean()
    load = results.numbers("mpm_load_right_value")[0] * np.interp(time, *ramp(results, "mpm_load_right_ramp"))
    return time, stretch, load / stretch


def main():
    if len(sys.argv) != 2:
        sys.exit(f"usage: {Path(sys.argv[0]).name} PREFIX")
    results = Results(sys.argv[1])
    time, stretch, lateral = path(results)
    np.savetxt(f"{results.prefix}_path.csv", np.column_stack([time, stretch - 1.0, 0.0 * time, lateral]), fmt="%.17g",
               delimiter=",", comments="", header="time,strain_yy,strain_zz,stress_xx")


if __name__ == "__main__":
    main()
