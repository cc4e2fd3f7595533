"""Runs that are stopped and continued: starting one in the background, waiting for it to get somewhere, comparing results."""
import os
import signal
import subprocess
import time
from pathlib import Path

import numpy as np
from talus_test import ENVIRONMENT, TIME_LIMIT, Results, alone

# Sums that are zero but for rounding are compared with the largest number of their kind.
KINDS = ("reaction_", "track_")
COUNTS = ("newton", "linear", "cuts")


class Background:
    """A run in a folder of its own or in that of an earlier one, started and not waited for."""

    def __init__(self, program, folder, scene, ranks=2, **options):
        self.folder, self.prefix = Path(folder), Path(folder) / "run"
        command = ["mpiexec", "--oversubscribe", "-n", str(ranks)] if ranks > 1 else []
        command += [str(program), "-options_file", str(scene), "-mpm_output_prefix", "run"]
        for name, value in options.items():
            command += ["-" + name] if value is None else ["-" + name, str(value)]
        self.command, self.ranks = command, ranks
        self.output = open(self.folder / "log", "a+", encoding="utf-8")  # a file: a full pipe would stop the run
        self.start = self.output.tell()
        environment = ENVIRONMENT if ranks > 1 else {**ENVIRONMENT, **alone()}
        self.process = subprocess.Popen(command, cwd=folder, env=environment, stdout=self.output, stderr=subprocess.STDOUT)

    def steps(self):
        """Rows of the history so far."""
        path = self.folder / "run_history.csv"
        return max(path.read_bytes().count(b"\n") - 1, 0) if path.exists() else 0

    def wait_for(self, condition):
        """Until the condition holds or the run has ended; does it hold?"""
        end = time.monotonic() + TIME_LIMIT
        while self.process.poll() is None and time.monotonic() < end:
            if condition():
                return True
            time.sleep(0.002)
        return condition()

    def pids(self):
        """The processes of the ranks."""
        if self.ranks == 1:
            return [self.process.pid]
        text = Path(f"/proc/{self.process.pid}/task/{self.process.pid}/children").read_text(encoding="ascii")
        return [int(pid) for pid in text.split()]

    def kill(self):
        """Ends every rank at once, without a word."""
        try:
            pids = self.pids()
        except FileNotFoundError:
            pids = []
        for pid in [*pids, self.process.pid]:
            try:
                os.kill(pid, signal.SIGKILL)
            except ProcessLookupError:
                pass
        self.process.wait()
        for pid in pids:  # until they are gone: their files must not change any more
            while Path(f"/proc/{pid}/stat").exists() and " Z " not in stat_of(pid):
                time.sleep(0.01)

    def wait(self):
        """Exit status and what was printed."""
        status = self.process.wait(timeout=TIME_LIMIT)
        self.output.seek(self.start)
        text = self.output.read()
        self.output.close()
        return status, text


def stat_of(pid):
    try:
        return Path(f"/proc/{pid}/stat").read_text(encoding="ascii")
    except (FileNotFoundError, ProcessLookupError):
        return " Z "


def relative(one, other):
    scale = np.max(np.abs(one), initial=0.0)
    return float(np.max(np.abs(one - other), initial=0.0) / (scale if scale > 0.0 else 1.0))


def differences(reference, other):
    """Largest relative difference in the points and in the history of two runs; infinite where they hold not the same."""
    one, two = Results(reference), Results(other)
    if one.steps != two.steps or list(one.history) != list(two.history) or len(one.column("step")) != len(two.column("step")):
        return np.inf, np.inf
    points = history = 0.0
    for step in one.steps:
        fields, others = one.state(step).fields, two.state(step).fields
        if fields.keys() != others.keys() or one.state(step).time != two.state(step).time:
            return np.inf, np.inf
        points = max([points, *(relative(fields[name], others[name]) for name in fields)])
    for name, values in one.history.items():
        if name in COUNTS:
            continue
        kind = [k for k in KINDS if name.startswith(k)]
        scale = max([np.max(np.abs(v)) for n, v in one.history.items() if not kind or n.startswith(kind[0])] if kind
                    else [np.max(np.abs(values))])
        history = max(history, float(np.max(np.abs(values - two.history[name]))) / (scale if scale > 0.0 else 1.0))
    index = [Path(str(prefix) + ".xdmf").read_text(encoding="utf-8") for prefix in (reference, other)]
    return points, history if index[0].count("<Time") == index[1].count("<Time") else np.inf
