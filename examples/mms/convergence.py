#!/usr/bin/env python3
"""Prints the errors and observed orders of mms over refined grids: convergence.py PATH/TO/mms [SHAPE ...]"""
import math
import subprocess
import sys
import tempfile
from pathlib import Path

FOLDER = Path(__file__).resolve().parent
sys.path.insert(0, str(FOLDER.parent))
sys.path.insert(0, str(FOLDER))
from check import errors  # noqa: E402
from common import Results  # noqa: E402


def run(program, case, refine, shape):
    with tempfile.TemporaryDirectory() as folder:
        prefix = str(Path(folder) / "mms")
        subprocess.run([program, "-options_file", str(FOLDER / case), "-mpm_grid_refine", str(refine), "-mpm_shape", shape,
                        "-mpm_output_prefix", prefix, "-mpm_quiet"], check=True)
        return errors(Results(prefix))


def main():
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    print("| shape | grid | displacement | order | stress | order |\n|---|---|---|---|---|---|")
    for shape in sys.argv[2:] or ["gimp", "gimp_bspline2"]:
        for case, cells, dim, levels in (("case.yaml", 8, 2, (1, 2, 4, 8)), ("case3d.yaml", 4, 3, (1, 2, 4))):
            last = None
            for refine in levels:
                now = run(sys.argv[1], case, refine, shape)
                orders = [f"{math.log2(a / b):.2f}" for a, b in zip(last, now)] if last else ["", ""]
                print(f"| {shape} | {cells * refine}^{dim} | {now[0]:.3e} | {orders[0]} | {now[1]:.3e} | {orders[1]} |", flush=True)
                last = now


if __name__ == "__main__":
    main()
