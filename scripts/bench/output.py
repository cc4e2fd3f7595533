"""Bytes per second of written states, against dd on the same disk, and what no output costs.

The program bench_output writes one state of ten million points of a 3D run (24 reals and 2 integers each) with Talus's
own writer, brings it to the disk, reads it back and compares every number. dd writes as many bytes to the same folder,
with conv=fsync, in turn. Then a scene is run with and without output: the seconds of the stage `output`, which without
states holds the history alone.
"""
import shutil
import statistics
import subprocess
import tempfile
import time
from pathlib import Path

from bench.runs import CANTILEVER, BenchmarkError, Table, check_program, execute, in_turn, launcher, median, run_scene

MIB = 1 << 20


def add_arguments(parser):
    parser.set_defaults(ranks=2)
    parser.add_argument("--points", type=int, metavar="N", help="points of the state (10000000; quick 100000)")
    parser.add_argument("--folder", default=tempfile.gettempdir(), help="on the disk that is measured")
    parser.add_argument("--helper", metavar="PROGRAM", help="the program bench_output (beside --program)")


def dd(path, size):
    """Seconds that dd takes to write so many bytes and to bring them to the disk."""
    since = time.monotonic()
    subprocess.run(["dd", "if=/dev/zero", f"of={path}", f"bs={MIB}", f"count={size // MIB + 1}", "conv=fsync"],
                   check=True, capture_output=True)
    seconds = time.monotonic() - since
    path.unlink()
    return seconds


def written(arguments, folder, precision):
    """Runs bench_output once; its lines as numbers, and the size of the file."""
    words = [*launcher(arguments.ranks), arguments.helper, "-bench_prefix", str(folder / "run"), "-bench_points",
             str(arguments.points), "-bench_rounds", "1"] + (["-bench_single"] if precision == "single" else [])
    status, output, errors = execute(words)
    if status != 0:
        raise BenchmarkError(f"bench_output: exit status {status}\n{errors.strip()}")
    numbers = {name: float(value) for name, value in (line.split() for line in output.splitlines())}
    size = (folder / "run.h5").stat().st_size
    (folder / "run.h5").unlink()
    return numbers, size


def states(arguments):
    table = Table(arguments.out, "output", ("points", "ranks", "precision", "bytes", "write_s", "write_and_sync_s",
                                            "read_s", "wrong", "dd_s", "bytes_per_s", "dd_bytes_per_s", "over_dd"))
    with tempfile.TemporaryDirectory(dir=arguments.folder) as name:
        folder = Path(name)
        if shutil.disk_usage(folder).free < 3 * 210 * arguments.points:
            raise BenchmarkError(f"{folder} has no room for {arguments.points} points")
        for precision in ("double", "single"):
            rows, plain = [], []
            for _ in range(arguments.repeat):
                numbers, size = written(arguments, folder, precision)
                rows.append(numbers)
                plain.append(dd(folder / "dd", size))
            middle = {key: statistics.median(row[key] for row in rows) for key in rows[0]}
            seconds = statistics.median(plain)
            table.add(points=arguments.points, ranks=arguments.ranks, precision=precision, bytes=size,
                      write_s=middle["write_s"], write_and_sync_s=middle["write_and_sync_s"], read_s=middle["read_s"],
                      wrong=int(max(row["wrong"] for row in rows)), dd_s=seconds,
                      bytes_per_s=size / middle["write_and_sync_s"], dd_bytes_per_s=size / seconds,
                      over_dd=seconds / middle["write_and_sync_s"])


def switched_off(arguments):
    table = Table(arguments.out, "output_off", ("every", "grid", "steps", "output_s", "total_s"))
    kinds = [(0, "false"), (1, "false"), (1, "true")]
    runs = in_turn(arguments.repeat, [
        lambda every=every, grid=grid: run_scene(arguments.program, CANTILEVER, {
            "mpm_output_every": every, "mpm_output_grid": grid}, arguments.ranks) for every, grid in kinds])
    for (every, grid), mine in zip(kinds, runs):
        table.add(every=every, grid=grid, steps=mine[0]["steps"], output_s=median(mine, "output"),
                  total_s=median(mine, "time_total_s"))


def run(arguments):
    check_program(arguments.program)
    arguments.helper = arguments.helper or str(Path(arguments.program).parent / "bench_output")
    check_program(arguments.helper)
    arguments.repeat = arguments.repeat or (1 if arguments.quick else 3)
    arguments.points = arguments.points or (100_000 if arguments.quick else 10_000_000)
    states(arguments)
    switched_off(arguments)
