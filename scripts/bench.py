#!/usr/bin/env python3
"""Benchmarks of Talus: seconds by stage, medians of several runs, as CSV on the terminal.

    scripts/bench.py stages [--ranks 2] [--repeat 3] [--cells 60 240] [--jacobian local coloring]
    scripts/bench.py box    [--ranks 2] [--repeat 5]

stages: the cantilever of examples/cantilever, its time by stage for cell counts and forms of the Jacobian.
box:    the same cantilever in a box four times as long on each axis, with the same cells: what unused grid costs.
Run it on a machine that does nothing else.
"""
import argparse
import json
import os
import statistics
import subprocess
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
SCENE = ROOT / "examples" / "cantilever" / "case.yaml"
ALLOW_ROOT = {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1", "OMP_NUM_THREADS": "1"}


def run(program, ranks, **options):
    """The summary of one run of the cantilever."""
    with tempfile.TemporaryDirectory() as folder:
        prefix = str(Path(folder) / "run")
        words = ["mpiexec", "-n", str(ranks), program, "-options_file", str(SCENE), "-mpm_quiet", "-mpm_output_prefix", prefix]
        for name, value in options.items():
            words += [f"-{name}", value]
        subprocess.run(words, check=True, env={**os.environ, **ALLOW_ROOT})
        return json.loads(Path(prefix + "_summary.json").read_text(encoding="utf-8"))


def median(runs, key):
    return statistics.median(run["time"][key] if key in run["time"] else run[key] for run in runs)


def stages(arguments):
    timers = ["setup", "transfer", "residual", "jacobian", "solve", "migrate", "output"]
    print("cells,points,jacobian,ranks,newton," + ",".join(timers) + ",total,us_per_point_iteration_core")
    for jacobian in arguments.jacobian:
        for cells in arguments.cells:
            runs = [run(arguments.program, arguments.ranks, mpm_grid_cells=f"{cells},{cells}", mpm_jacobian=jacobian)
                    for _ in range(arguments.repeat)]
            points, newton = runs[0]["points"], runs[0]["newton_iterations"]
            work = (median(runs, "residual") + median(runs, "jacobian")) * arguments.ranks / (points * newton) * 1e6
            values = [f"{median(runs, timer):.3f}" for timer in [*timers, "time_total_s"]]
            print(",".join([str(cells), str(points), jacobian, str(arguments.ranks), str(newton), *values, f"{work:.3f}"]),
                  flush=True)


def box(arguments):
    near, far = [], []
    for _ in range(arguments.repeat):  # in turn, so that both see the same machine
        near.append(run(arguments.program, arguments.ranks))
        far.append(run(arguments.program, arguments.ranks, mpm_grid_upper="60,60", mpm_grid_cells="240,240"))
    print("ranks,time_ratio,memory_ratio")
    print(f"{arguments.ranks},{median(far, 'time_total_s') / median(near, 'time_total_s'):.3f},"
          f"{median(far, 'memory_max_bytes') / median(near, 'memory_max_bytes'):.3f}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("benchmark", choices=["stages", "box"])
    parser.add_argument("--program", default=str(ROOT / "build" / "talus"))
    parser.add_argument("--ranks", type=int, default=2)
    parser.add_argument("--repeat", type=int, default=3)
    parser.add_argument("--cells", type=int, nargs="+", default=[60, 240])
    parser.add_argument("--jacobian", nargs="+", default=["local", "coloring"])
    arguments = parser.parse_args()
    {"stages": stages, "box": box}[arguments.benchmark](arguments)


if __name__ == "__main__":
    main()
