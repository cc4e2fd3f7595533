"""What the hostile scenes share: a run with a time limit, and what every run must look like once it has ended.

    with Hostile(limit=60) as test:                         # s, for one run; the command line may say --full
        run = test.ends("soft", SCENE, mpm_time_step=0.5)   # status 0, or 3 where `or_gives_up` allows it
        if run.completed:
            test.check(...)

A run has ended well when the program finished within the limit, either with status 0 and "completed" or with status 3
and one line that says why, which is also in the summary; when it printed no traceback; and when every number that it
wrote is finite, every volume positive, no mass was lost and no point stands outside the grid.
"""
import json
import os
import re
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import ENVIRONMENT, Run, Test, alone, run_alone  # noqa: E402
from results import ResultsError  # noqa: E402  (talus_test makes the folder known)

GRACE = 5.0  # s that a run which is told to stop has for it
GAVE_UP = re.compile(r"^talus: gave up after step \d+ at time \S+: (.+)$", re.MULTILINE)
SIGNS_OF_A_CRASH = ("PETSC ERROR", "Caught signal", "MPI_ABORT", "Segmentation", "runtime error:")


class Ended(Run):
    """A run that has ended or was ended: `hung` tells which; `completed` is true when it ended well, with status 0."""

    def __init__(self, program, scene, ranks, options, folder, limit):
        command = ["mpiexec", "--oversubscribe", "-n", ranks] if ranks > 1 else []
        command += [program, "-options_file", scene]
        for name, value in options.items():
            command += ["-" + name] if value is None else ["-" + name, value]
        self.folder, self.command = Path(folder), [str(word) for word in command]
        self.hung = self.completed = False
        if ranks > 1:
            self._run_ranks(limit)
        else:
            self.status, self.output, self.errors = run_alone(command, folder, {**ENVIRONMENT, **alone()}, limit)
            self.hung = self.status is None
        summaries = list(self.folder.glob("*_summary.json"))
        self.prefix = str(summaries[0])[: -len("_summary.json")] if summaries else None

    def _run_ranks(self, limit):
        with subprocess.Popen(self.command, cwd=self.folder, env=ENVIRONMENT, stdout=subprocess.PIPE,
                              stderr=subprocess.PIPE, text=True, start_new_session=True) as process:
            try:
                self.output, self.errors = process.communicate(timeout=limit)
            except subprocess.TimeoutExpired:
                self.hung = True
                self.output, self.errors = self._stop(process)
        self.status = process.returncode

    @staticmethod
    def _stop(process):
        """Ends the run with its ranks: the whole session, first asked, then forced."""
        for number in (signal.SIGTERM, signal.SIGKILL):
            try:
                os.killpg(process.pid, number)
                return process.communicate(timeout=GRACE)
            except (subprocess.TimeoutExpired, ProcessLookupError):
                continue
        return "", ""

    @property
    def reason(self):
        """What the one line of a run that gave up says, or None."""
        lines = GAVE_UP.findall(self.errors)
        return lines[0] if len(lines) == 1 else None

    def last(self, column):
        return self.results.column(column)[-1]


def wrong_ending(run, or_gives_up):
    """What is wrong with status, lines and summary."""
    if run.hung:
        yield "it did not end within its time limit"
        return
    for sign in SIGNS_OF_A_CRASH:
        if sign in run.errors + run.output:
            yield f"'{sign}' was printed"
    if run.status not in ((0, 3) if or_gives_up else (0,)):
        yield f"exit status {run.status}" + (f" ({run.reason})" if run.reason else "")
    if run.status == 3 and run.reason is None:
        yield f"{len(GAVE_UP.findall(run.errors))} lines that say why"
    if run.prefix is None:
        yield "no summary"
        return
    wanted = "completed" if run.status == 0 else run.reason
    text = Path(run.prefix + "_summary.json").read_text(encoding="utf-8")
    if wanted is not None and json.loads(text)["status"] != wanted:
        yield f"the summary says '{json.loads(text)['status']}'"
    if re.search(r"\b(null|nan|inf)\b", text, re.IGNORECASE):
        yield "the summary holds a number that is not finite"


def wrong_history(run):
    """What is wrong with the rows of the history."""
    history = run.results.history
    for name, values in history.items():
        if not np.all(np.isfinite(values)):
            yield f"history column {name} is not finite"
    time, end = history["time"], float(run.results.option("mpm_time_end", "1"))
    if np.any(np.diff(time) <= 0.0):
        yield "time does not increase"
    if run.status == 0 and not (time.size and abs(time[-1] - end) < 1e-9 * end):
        yield "the history does not reach the end"


def wrong_states(run):
    """What is wrong with the points in any of the written states."""
    results = run.results
    lower, upper = (np.array(results.numbers(f"mpm_grid_{end}")) for end in ("lower", "upper"))
    reach = 1e-6 * (upper - lower)
    mass = None
    for step in results.steps:
        state = results.state(step)
        for name, values in state.fields.items():
            if np.issubdtype(values.dtype, np.floating) and not np.all(np.isfinite(values)):
                yield f"step {step}: {name} is not finite"
        if np.any(state["volume"] <= 0.0):
            yield f"step {step}: a volume is not positive"
        mass = state["mass"].sum() if mass is None else mass
        if abs(state["mass"].sum() - mass) > 1e-9 * abs(mass):
            yield f"step {step}: mass has changed"
        outside = (state["position"] < lower - reach) | (state["position"] > upper + reach)
        if np.any(outside):
            yield f"step {step}: {np.count_nonzero(outside.any(axis=1))} points outside the grid"


def faults(run, or_gives_up):
    """Everything that is wrong with the way in which a run ended."""
    found = list(wrong_ending(run, or_gives_up))
    if run.prefix is not None and not run.hung:
        try:
            found += [*wrong_history(run), *wrong_states(run)]
        except (ResultsError, OSError, KeyError, ValueError) as error:
            found.append(f"results that cannot be read: {error}")
    return found


class Hostile(Test):
    """A test of hostile scenes: each run has `limit` seconds; `full` is true when the command line says --full."""

    def __init__(self, limit):
        self.limit = limit
        super().__init__()

    def takes(self, scene, **options):
        """Whether the program takes these options at all; what it does not have is refused with status 2."""
        folder = self.folder()
        run = Ended(self.program, scene, 1, {**options, "mpm_time_end": 1e-6, "mpm_quiet": None}, folder, self.limit)
        if run.status == 2:
            print(f"passed over: {run.errors.strip()}", flush=True)
        return run.status != 2

    def ends(self, label, scene, ranks=1, or_gives_up=False, **options):
        """Runs a scene, a path or a text; checks that it ends well, which may mean that it gives up. One line a run."""
        folder = self.folder()
        if not isinstance(scene, Path):
            (folder / "scene.yaml").write_text(scene, encoding="utf-8")
            scene = folder / "scene.yaml"
        run = Ended(self.program, scene, ranks, options, folder, self.limit)
        found = faults(run, or_gives_up)
        run.completed = not found and run.status == 0
        self.check(f"{label}.faults", len(found), None, 0)
        for fault in found:
            print(f"    {fault}")
        if found:
            print(f"    {' '.join(run.command)}\n    {run.errors.strip()[:600]}", flush=True)
        elif run.status == 3:
            print(f"    gave up: {run.reason}", flush=True)
        return run
