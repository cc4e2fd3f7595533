"""Runs of the program in forked processes of one that has its libraries loaded: half the time of a short run.

See launcher.c. Used where it was built beside the program and from the same objects; otherwise the program itself is
started. Python scripts run in a fork of the test, which has numpy and h5py loaded: a sixth of the time of a short one.
"""
import atexit
import os
import runpy
import select
import subprocess
import sys
import tempfile
import threading
import traceback
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


def become(script, words, folder, environment, root):
    """In a forked process: runs a script as the main program, with none of our own modules loaded; its exit status."""
    for name, module in list(sys.modules.items()):
        if Path(getattr(module, "__file__", None) or "/").is_relative_to(root):
            del sys.modules[name]
    os.chdir(folder)
    os.environ.clear()
    os.environ.update(environment)
    sys.argv, sys.path[:0] = [str(script), *words], [str(Path(script).parent)]
    try:
        runpy.run_path(str(script), run_name="__main__")
    except SystemExit as end:
        if isinstance(end.code, str):
            print(end.code, file=sys.stderr)
        return end.code if isinstance(end.code, int) else int(end.code is not None)
    except BaseException:  # pylint: disable=broad-except  (as the interpreter itself ends)
        traceback.print_exc()
        return 1
    return 0


def run_script(command, folder, environment, root):
    """A Python script with its words, run in a fork: as subprocess.run, with its output as text."""
    script, *words = [str(word) for word in command]
    with tempfile.TemporaryFile() as output, tempfile.TemporaryFile() as errors:
        sys.stdout.flush()
        process = os.fork()
        if not process:
            status = 1
            try:
                os.dup2(output.fileno(), 1)
                os.dup2(errors.fileno(), 2)
                sys.stdout, sys.stderr = open(1, "w", **TEXT, closefd=False), open(2, "w", **TEXT, closefd=False)
                status = become(script, words, folder, environment, root)
                sys.stdout.flush()
                sys.stderr.flush()
            finally:
                os._exit(status)
        status = os.waitstatus_to_exitcode(os.waitpid(process, 0)[1])
        texts = []
        for file in (output, errors):
            file.seek(0)
            texts.append(file.read().decode(**TEXT))
    return subprocess.CompletedProcess([script, *words], status, *texts)
