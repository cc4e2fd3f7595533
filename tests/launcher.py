"""Runs of the program in forked processes of one that has its libraries loaded: see launcher.c. Half the time of a short run.

Used where it was built beside the program and from the same objects; otherwise the program itself is started.
"""
import atexit
import os
import select
import subprocess
import tempfile
import threading
from pathlib import Path

LAUNCHERS = threading.local()  # each thread has its own, by the program's path
TEXT = {"encoding": "utf-8", "errors": "backslashreplace"}


class Launcher:
    """A process that waits for requests, and the environment that it was started with."""

    def __init__(self, path, environment):
        self.environment = dict(environment)
        self.process = subprocess.Popen([path], env=self.environment, stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        self.place = tempfile.TemporaryDirectory(prefix="talus_launcher_")
        atexit.register(self.process.communicate)  # the end of its input ends it

    def run(self, command, folder, environment, limit):
        """Exit status, output and errors of a run; None for the status where it did not end within the limit, in s."""
        output, errors = (Path(self.place.name) / name for name in ("output", "errors"))
        settings = [f"{name}={value}" for name, value in environment.items() if self.environment.get(name) != value]
        words = [str(folder), str(output), str(errors), str(len(settings)), *settings, *command]
        self.process.stdin.write(b"".join(os.fsencode(word) + b"\0" for word in [str(len(words)), *words]))
        self.process.stdin.flush()
        status = None
        if select.select([self.process.stdout], [], [], limit)[0]:
            status = int(self.process.stdout.readline())
        else:
            self.process.kill()  # the run goes with it
        return status, output.read_text(**TEXT), errors.read_text(**TEXT)

    def serves(self, environment):
        """True where it still runs, and no setting was taken away or speaks to the dynamic linker."""
        changed = {name for name, value in environment.items() if self.environment.get(name) != value}
        return (self.process.poll() is None and self.environment.keys() <= environment.keys()
                and not any(name.startswith("LD_") for name in changed))


def launcher_of(program, environment):
    """The launcher of the program talus; None where there is none, or one that is older, and for other programs."""
    path = Path(program).parent / "tests" / "launcher"
    if Path(program).name != "talus" or not path.exists() or path.stat().st_mtime < Path(program).stat().st_mtime:
        return None
    known = LAUNCHERS.__dict__.setdefault("known", {})
    if str(path) not in known or not known[str(path)].serves(environment):
        known[str(path)] = Launcher(path, environment)
    return known[str(path)]


def run_alone(command, folder, environment, limit):
    """A run on one rank in a folder: exit status (None: not within the limit), output, errors."""
    command = [str(word) for word in command]
    launcher = launcher_of(command[0], environment)
    if launcher:
        return launcher.run(command, folder, environment, limit)
    try:
        process = subprocess.run(command, cwd=folder, env=environment, capture_output=True, timeout=limit, check=False,
                                 **TEXT)
    except subprocess.TimeoutExpired as late:
        return None, *((text or b"").decode(**TEXT) for text in (late.stdout, late.stderr))
    return process.returncode, process.stdout, process.stderr
