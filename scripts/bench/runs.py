"""Runs of the program, their medians, and tables of them."""
import csv
import json
import os
import signal
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from random import Random

ROOT = Path(__file__).resolve().parents[2]
CANTILEVER = ROOT / "examples" / "cantilever" / "case.yaml"
TIMERS = ("setup", "transfer", "residual", "jacobian", "solve", "migrate", "output", "gradient")
# Open MPI as root, on more ranks than cores; no threads under the ranks.
ENVIRONMENT = {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1", "OMP_NUM_THREADS": "1",
               "OMPI_MCA_rmaps_base_oversubscribe": "1"}
COMPLETED = "completed"
GAVE_UP = 3  # exit status
LONG = 60.0  # s: a run that takes longer is not repeated


class BenchmarkError(Exception):
    """The benchmark cannot go on; the text says why."""


class Run:
    """One run: how it ended and, if it got that far, its summary and what was measured in its results."""

    def __init__(self, status, summary=None, value=None):
        self.status, self.summary, self.value = status, summary, value

    @property
    def completed(self):
        return self.status == COMPLETED

    def __getitem__(self, key):
        """An entry of the summary; "jacobian" and the other stages are seconds."""
        return self.summary["time"][key] if key in TIMERS else self.summary[key]


def words_of(options):
    """The command line's words for options by name; an option without a value has None."""
    words = []
    for name, value in options.items():
        words += [f"-{name}"] if value is None else [f"-{name}", str(value)]
    return words


def execute(words, limit=None):
    """Exit status, standard output and standard error; the status is None where the limit (s) has passed."""
    with subprocess.Popen(words, env={**os.environ, **ENVIRONMENT}, text=True, stdout=subprocess.PIPE,
                          stderr=subprocess.PIPE, start_new_session=True) as process:
        try:
            output, errors = process.communicate(timeout=limit)
            return process.returncode, output, errors
        except BaseException as error:  # an interrupt, too, must not leave ranks behind
            os.killpg(process.pid, signal.SIGTERM)
            try:
                process.communicate(timeout=10.0)
            except subprocess.TimeoutExpired:
                os.killpg(process.pid, signal.SIGKILL)
            if isinstance(error, subprocess.TimeoutExpired):
                return None, "", ""
            raise


def launcher(ranks):
    """The words before the program's. For one rank mpiexec takes longer than a small run; the shell between keeps the
    size of Python's process out of the program's, which inherits its parent's largest size."""
    return ["sh", "-c", '"$@"; exit $?', "sh"] if ranks == 1 else ["mpiexec", "-n", str(ranks)]


def check_program(path):
    if not os.access(path, os.X_OK):
        raise BenchmarkError(f"there is no program {path}: build it with scripts/build.sh, or name it with --program")


def run_scene(program, scene, options, ranks=1, limit=None, measure=None):
    """Runs a scene with options by name. measure(prefix) is called on the results of a completed run."""
    check_program(program)
    with tempfile.TemporaryDirectory() as folder:
        prefix = str(Path(folder) / "run")
        words = [*launcher(ranks), str(program), "-options_file", str(scene), "-mpm_quiet", "-mpm_output_prefix",
                 prefix]
        status, _, errors = execute(words + words_of(options), limit)
        summary = Path(prefix + "_summary.json")
        if status is None:
            return Run(f"over {limit:g} s")
        if status not in (0, GAVE_UP) or not summary.is_file():
            lines = [line for line in errors.splitlines() if "talus: error" in line or "ERROR" in line]
            return Run(f"failed, exit status {status}: {lines[0].strip() if lines else 'no message'}")
        contents = json.loads(summary.read_text(encoding="utf-8"))
        if status == GAVE_UP:
            return Run(f"gave up after {contents['steps']} steps: {contents['status']}", contents)
        return Run(COMPLETED, contents, measure(prefix) if measure else None)


def repeated(count, function):
    """Several runs of function(); one is enough where it fails or takes long."""
    runs = []
    while len(runs) < count:
        since = time.monotonic()
        runs.append(function())
        if not runs[-1].completed:
            return runs[-1:]
        if time.monotonic() - since > LONG:
            break
    return runs


def in_turn(count, functions):
    """For each of several functions its runs; they take turns, in an order of its own each time, so that all see the
    same machine. One run is enough where it fails or takes long."""
    runs, over, random = [[] for _ in functions], set(), Random(0)
    for _ in range(count):
        for k in random.sample(range(len(functions)), len(functions)):
            if k in over:
                continue
            since = time.monotonic()
            runs[k].append(functions[k]())
            if not runs[k][-1].completed or time.monotonic() - since > LONG:
                over.add(k)
    return [mine if mine[-1].completed else mine[-1:] for mine in runs]


def median(runs, key):
    """The median of an entry of the runs' summaries; None where there is no summary."""
    values = [run[key] for run in runs if run.summary]
    return statistics.median(values) if values else None


class Table:
    """Rows of named values: printed as CSV when they come and written to a file as well."""

    def __init__(self, folder, name, columns):
        self.columns, self.rows, self.path = list(columns), [], Path(folder) / f"{name}.csv"
        self.path.parent.mkdir(parents=True, exist_ok=True)
        self.path.write_text("", encoding="utf-8")
        self._write(self.columns)

    def _write(self, values):
        with open(self.path, "a", newline="", encoding="utf-8") as file:
            for stream in (sys.stdout, file):
                csv.writer(stream, lineterminator="\n").writerow(values)
        sys.stdout.flush()

    def add(self, **row):
        unknown = set(row) - set(self.columns)
        if unknown:
            raise BenchmarkError(f"{self.path.name} has no column {', '.join(sorted(unknown))}")
        self.rows.append(row)
        self._write([text(row.get(name)) for name in self.columns])

    def select(self, **values):
        """The rows with these values."""
        return [row for row in self.rows if all(row.get(name) == value for name, value in values.items())]


def text(value):
    """A cell of a table: four to six digits are all that a measurement has."""
    if value is None:
        return ""
    return f"{value:.6g}" if isinstance(value, float) else str(value)
