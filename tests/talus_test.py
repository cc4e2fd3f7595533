"""What the script tests share: running the program in a folder of its own, comparing, one line a check.

    with Test() as test:                                    # reads the program's path from the command line
        run = test.run(example("cantilever"), ranks=2, mpm_grid_refine=2)
        test.check("tip", run.results.column("track_tip_uy")[-1], lower=-8.3, upper=-8.2)

Each check prints `name value bound`; the test fails when one is out of bounds, or when a run ends otherwise than it
should.
"""
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
EXAMPLES = ROOT / "examples"
sys.path[:0] = [str(EXAMPLES), str(ROOT / "scripts"), str(ROOT / "tests")]
from common import Quantity, read_table  # noqa: E402,F401  (the folder has to be known first; tests use read_table)
from launcher import run_alone, run_script  # noqa: E402
from results import Results  # noqa: E402

# Ranks on one machine need shared memory only, and are bound to no core: looking for hardware takes longer than most runs here.
ENVIRONMENT = {**os.environ, "OMP_NUM_THREADS": "1", "OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
               "OMPI_MCA_pml": "ob1", "OMPI_MCA_btl": "self,vader", "HWLOC_COMPONENTS": "no_os,stop", "MPLBACKEND": "Agg"}
# One rank needs no daemon beside it; each run has a folder of its own for what Open MPI leaves there for the while.
SESSION = tempfile.TemporaryDirectory(prefix="talus_mpi_")
TIME_LIMIT = 600.0  # s, for one run
FULL = "--full" in sys.argv  # all that a test has, by hand; otherwise what CI runs
sys.argv = [word for word in sys.argv if word != "--full"]


def example(name):
    """Path of an example's scene."""
    return EXAMPLES / name / "case.yaml"


def alone():
    """The environment of a run on one rank without mpiexec."""
    return {"OMPI_MCA_ess_singleton_isolated": "1", "OMPI_MCA_orte_tmpdir_base": tempfile.mkdtemp(dir=SESSION.name)}


def call(command, folder):
    """Runs a command in a folder; the completed process, with its output as text."""
    if command[0] == sys.executable and str(command[1]).endswith(".py"):
        return run_script(command[1:], folder, ENVIRONMENT, ROOT)
    environment = ENVIRONMENT if command[0] == "mpiexec" else {**ENVIRONMENT, **alone()}
    return subprocess.run([str(word) for word in command], cwd=folder, env=environment, capture_output=True, text=True,
                          errors="backslashreplace", timeout=TIME_LIMIT, check=False)


def must(test, name, command, folder):
    """Runs a command that must succeed; its output."""
    process = call(command, folder)
    test.check(name, process.returncode, 0, 0)
    if process.returncode:
        print(process.stdout[-3000:], process.stderr[-3000:])
    return process.stdout


class Run:
    """A run that has ended: exit status, output, the files that it left."""

    def __init__(self, program, scene, ranks, options, folder):
        command = ["mpiexec", "--oversubscribe", "-n", ranks] if ranks > 1 else []
        command += [program, "-options_file", scene]
        for name, value in options.items():
            command += ["-" + name] if value is None else ["-" + name, value]
        self.folder, self.command = Path(folder), command
        if ranks > 1:
            process = call(command, folder)
            self.status, self.output, self.errors = process.returncode, process.stdout, process.stderr
        else:
            self.status, self.output, self.errors = run_alone(command, folder, {**ENVIRONMENT, **alone()}, TIME_LIMIT)
        if self.status is None:
            sys.exit(f"no end within {TIME_LIMIT} s: {' '.join(map(str, command))}")
        summaries = list(self.folder.glob("*_summary.json"))
        self.prefix = str(summaries[0])[: -len("_summary.json")] if summaries else None

    @property
    def files(self):
        return sorted(path.name for path in self.folder.iterdir())

    @property
    def results(self):
        return Results(self.prefix)

    @property
    def newton(self):
        """Newton iterations of each step."""
        return self.results.column("newton").astype(int)

    def table(self, name, step="last"):
        """A field of the points at a step, rows by id."""
        return self.results.state(step)[name]


class Test:
    """A test script: the program under test, a place for runs, and what has been checked so far."""

    def __init__(self):
        if len(sys.argv) != 2:
            sys.exit(f"usage: {Path(sys.argv[0]).name} path/to/talus")
        self.program = Path(sys.argv[1]).resolve()
        self.count, self.failures = 0, []

    def __enter__(self):
        self._place = tempfile.TemporaryDirectory(prefix="talus_")
        return self

    def __exit__(self, kind, value, traceback):
        self._place.cleanup()
        if kind is not None:
            return False
        if not self.count:
            sys.exit("nothing was checked")
        if self.failures:
            sys.exit(f"{len(self.failures)} of {self.count} checks failed: " + ", ".join(self.failures))
        print(f"{self.count} checks passed")
        return False

    def folder(self):
        """A new empty folder."""
        return Path(tempfile.mkdtemp(dir=self._place.name))

    def run(self, scene, ranks=1, status=0, **options):
        """Runs a scene with further options (name=value; None: no value); it must end with this status."""
        run = Run(self.program, scene, ranks, options, self.folder())
        if status is not None and run.status != status:
            sys.exit(f"exit status {run.status} instead of {status}: {' '.join(map(str, run.command))}\n{run.output}\n{run.errors}")
        return run

    def check(self, name, value, lower=None, upper=None):
        self.take(Quantity(name, value, lower, upper))

    def near(self, name, value, reference, relative=0.0, absolute=0.0):
        self.take(Quantity.near(name, value, reference, relative, absolute))

    def take(self, quantity):
        self.count += 1
        print(quantity if quantity.good else f"{quantity}  FAILED", flush=True)
        if not quantity.good:
            self.failures.append(quantity.name)

    def check_example(self, label, run, name):
        """Applies an example's own check.py to a run; its quantities by name, each of which counts as a check."""
        process = call([sys.executable, EXAMPLES / name / "check.py", run.prefix], run.folder)
        lines = [line.split() for line in process.stdout.splitlines()]
        if process.returncode not in (0, 1) or not lines:
            sys.exit(f"{label}: check.py ended with status {process.returncode}\n{process.stdout}{process.stderr}")
        for words in lines:
            print(label + "." + " ".join(words), flush=True)
        self.count += len(lines)
        if process.returncode:
            self.failures.append(f"{label} ({process.stderr.strip()})")
        return {words[0]: float(words[1]) for words in lines}


def difference(one, other):
    """Largest difference of two arrays over the largest size of the first."""
    scale = np.max(np.abs(one))
    return float(np.max(np.abs(one - other)) / (scale if scale > 0.0 else 1.0))
