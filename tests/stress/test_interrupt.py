#!/usr/bin/env python3
"""Runs that are told to end, and runs that cannot write.

SIGINT, SIGTERM and SIGUSR1, be it to one rank alone, end the step, write a checkpoint and leave exit status 0; a second
SIGINT ends a run at once, and where SIGINT was ignored it stays so; the job script of
scripts/slurm brings a run to its end in three jobs. A full disk and a limit on the size of files end a run with one line
and the last checkpoint whole, from which it goes on where there is room.
"""
import json
import os
import resource
import shutil
import signal
import stat
import subprocess
import sys
import time
from pathlib import Path

sys.path[:0] = [str(Path(__file__).resolve().parent), str(Path(__file__).resolve().parent.parent)]
from runs import Background, differences  # noqa: E402
from talus_test import ENVIRONMENT, ROOT, TIME_LIMIT, Test, example  # noqa: E402

SCENE, OPTIONS = "collapse", {"mpm_time_step": 0.05, "mpm_output_every": 3}
TOLERANCE = 1e-10


def summary(folder):
    return json.loads((folder / "run_summary.json").read_text(encoding="utf-8"))


def compare(test, label, reference, folder):
    points, history = differences(reference, folder / "run")
    test.check(label + "_points", points, upper=TOLERANCE)
    test.check(label + "_history", history, upper=TOLERANCE)


# ---- signals ----


def interrupt(test, reference, label, number, ranks, to_rank):
    """A signal to mpiexec, or to one rank alone; then on from the options that the run has left."""
    folder = test.folder()
    run = Background(test.program, folder, example(SCENE), ranks=ranks, **OPTIONS)
    run.wait_for(lambda: run.steps() >= 4)
    os.kill(run.process.pid if to_rank is None else run.pids()[to_rank], number)
    steps = run.steps()
    status, _ = run.wait()
    test.check(label + "_status", status, 0, 0)
    test.check(label + "_interrupted", int(summary(folder)["status"] == "interrupted"), 1, 1)
    if ranks == 1 or to_rank is not None:  # when mpiexec hands a signal on is not the program's to say
        test.check(label + "_steps_after_the_signal", summary(folder)["steps"] - steps, 0, 1)
    test.check(label + "_history_rows", run.steps() - summary(folder)["steps"], 0, 0)
    status, _ = Background(test.program, folder, folder / "run_restart.yaml", ranks=ranks).wait()
    test.check(label + "_continued", status, 0, 0)
    compare(test, label, reference, folder)


def interrupt_rows(test):
    """With rows of the history every so many steps, the last step of an interrupted run has its row; the last line says so."""
    folder, options = test.folder(), {"mpm_output_every": 0, "mpm_output_history": 50, "mpm_time_end": 0.3}
    run = Background(test.program, folder, example("dam_break"), ranks=1, **options)
    run.wait_for(lambda: run.steps() >= 3)
    os.kill(run.process.pid, signal.SIGTERM)
    status, text = run.wait()
    steps = summary(folder)["steps"]
    rows = [int(line.split(",")[0]) for line in (folder / "run_history.csv").read_text().splitlines()[1:]]
    test.check("rows_status", status, 0, 0)
    test.check("rows_last", rows[-1] - steps, 0, 0)
    test.check("rows_others", int(all(row % 50 == 0 for row in rows[:-1])), 1, 1)
    line = text.splitlines()[-1]
    test.check("last_line", int(line.startswith(f"interrupted after step {steps} at time ") and "run_restart.yaml" in line), 1, 1)
    Background(test.program, folder, folder / "run_restart.yaml", ranks=1).wait()
    whole = test.folder()
    Background(test.program, whole, example("dam_break"), ranks=1, **options).wait()
    test.check("rows_continued", int((folder / "run_history.csv").read_bytes() == (whole / "run_history.csv").read_bytes()), 1, 1)


def interrupt_twice(test):
    """The second Ctrl-C does not wait for the end of the step."""
    folder = test.folder()
    run = Background(test.program, folder, example("cantilever"), ranks=1, mpm_grid_refine=16, mpm_output_every=0)
    run.wait_for(lambda: (folder / "run_history.csv").exists())
    time.sleep(0.3)  # the first step, which takes seconds, is under way: before it a checkpoint would be written at once
    os.kill(run.process.pid, signal.SIGINT)
    time.sleep(0.2)
    test.check("int_once_still_running", int(run.process.poll() is None), 1, 1)
    os.kill(run.process.pid, signal.SIGINT)
    status, _ = run.wait()
    test.check("int_twice_status", status, -signal.SIGINT, -signal.SIGINT)
    test.check("int_twice_checkpoints", len(list(folder.glob("*checkpoint*"))), 0, 0)


def interrupt_ignored(test):
    """A shell's job in the background shares the terminal and has been told to ignore its Ctrl-C."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    folder = test.folder()
    run = Background(test.program, folder, example(SCENE), ranks=1, **OPTIONS)
    signal.signal(signal.SIGINT, signal.default_int_handler)
    run.wait_for(lambda: run.steps() >= 2)
    os.kill(run.process.pid, signal.SIGINT)
    status, _ = run.wait()
    test.check("int_ignored", int(status == 0 and summary(folder)["status"] == "completed"), 1, 1)


def jobs(test, reference):
    """The job script under a batch system that sends SIGUSR1 after some steps; `sbatch` only takes down what it is given."""
    folder, job = test.folder(), ROOT / "scripts" / "slurm" / "talus.sbatch"
    sbatch = folder / "sbatch"
    sbatch.write_text(f"#!/bin/sh\necho \"$@\" >>'{folder}/submitted'\n", encoding="utf-8")
    sbatch.chmod(sbatch.stat().st_mode | stat.S_IXUSR)
    options = " ".join(f"-{name} {value}" for name, value in OPTIONS.items())
    launch = f"mpiexec --oversubscribe -n 2 {test.program} {options}"
    environment = {**ENVIRONMENT, "PATH": f"{folder}:{os.environ['PATH']}", "TALUS_JOB": "talus.sbatch", "TALUS_PREFIX": "run",
                   "TALUS_SCENE": str(example(SCENE)), "TALUS_LAUNCH": launch, "TALUS_PIECE": str(job.parent / "piece.sh")}
    status, pieces = None, 0
    while pieces < 5 and (not pieces or len((folder / "submitted").read_text().split()) == pieces):
        with open(folder / "log", "a", encoding="utf-8") as log:
            process = subprocess.Popen(["bash", str(job)], cwd=folder, env=environment, stdout=log, stderr=subprocess.STDOUT)
        end, rows = time.monotonic() + TIME_LIMIT, 5 + 6 * pieces
        path = folder / "run_history.csv"
        while pieces < 2 and process.poll() is None and time.monotonic() < end:
            if path.exists() and path.read_bytes().count(b"\n") > rows:
                process.send_signal(signal.SIGUSR1)
                break
            time.sleep(0.002)
        status = process.wait(timeout=TIME_LIMIT)
        pieces += 1
        if status or not (folder / "submitted").exists():
            print((folder / "log").read_text(encoding="utf-8"))
            break
    test.check("jobs_status", status, 0, 0)
    test.check("jobs", pieces, 3, 3)
    compare(test, "jobs", reference, folder)


def gave_up(test):
    """A run that gives up leaves a checkpoint, from which it goes on with better options."""
    folder = test.folder()
    unsolvable = {"mpm_time_step": 0.1, "snes_max_it": 4, "mpm_time_step_min": 0.09}
    better = {"snes_max_it": 25, "mpm_time_step_min": 1e-3}  # a step of 0.1 jumps by two cells, which halving takes back
    status, _ = Background(test.program, folder, example(SCENE), **unsolvable).wait()
    test.check("gave_up_status", status, 3, 3)
    test.check("gave_up_reason", int("limit" in summary(folder)["status"]), 1, 1)
    steps = summary(folder)["steps"]
    status, _ = Background(test.program, folder, folder / "run_restart.yaml", **better).wait()
    test.check("gave_up_continued", status, 0, 0)
    test.check("gave_up_then_steps", summary(folder)["steps"] - steps, lower=1)


# ---- files that cannot be written ----


def one_line(test, label, status, text, file):
    """Exit status 4 and one line of ours that names the file."""
    lines = [line for line in text.splitlines() if line.startswith("talus: error: ")]
    good = status == 4 and len(lines) == 1 and file in lines[0] and "PETSC ERROR" not in text and "HDF5-DIAG" not in text
    if not good:
        print(f"{label}: status {status}\n{text}")
    test.check(label, int(good), 1, 1)


def continue_elsewhere(test, label, reference, folder):
    """What the run has left goes on where there is room."""
    place = test.folder()
    for path in folder.glob("run*"):
        shutil.copy(path, place)
    status, text = Background(test.program, place, example(SCENE), **OPTIONS, mpm_restart="latest").wait()
    if status:
        print(text)
    test.check(label + "_continued", status, 0, 0)
    compare(test, label, reference, place)


def limited(test, reference, sizes):
    """A limit on the size of files, set while the run is on its way: the results outgrow it, or the next checkpoint does."""
    cases = {"results": (2, {}, (sizes["run.h5"] + sizes["run_checkpoint.h5"]) // 2),
             "checkpoint": (2, {"mpm_output_every": 0}, sizes["run_checkpoint.h5"] // 2),
             "checkpoint_together": (2, {"mpm_output_every": 0, "mpm_checkpoint_collective": 0}, sizes["run_checkpoint.h5"] // 2),
             "checkpoint_alone": (1, {"mpm_output_every": 0}, sizes["run_checkpoint.h5"] // 2)}
    for label, (ranks, changed, size) in cases.items():
        folder, options = test.folder(), {**OPTIONS, "mpm_checkpoint_every": 2, **changed}
        run = Background(test.program, folder, example(SCENE), ranks=ranks, **options)
        run.wait_for((folder / "run_checkpoint.h5").exists)
        for pid in run.pids():
            resource.prlimit(pid, resource.RLIMIT_FSIZE, (size, size))
        status, text = run.wait()
        one_line(test, "limit_" + label, status, text, "run.h5" if label == "results" else "run_checkpoint.h5")
        test.check(f"limit_{label}_left_over", len(list(folder.glob("*.tmp"))), 0, 0)
        if label == "results":
            continue_elsewhere(test, "limit_" + label, reference, folder)
        else:
            status, _ = Background(test.program, folder, example(SCENE), **options, mpm_restart="latest").wait()
            test.check(f"limit_{label}_continued", status, 0, 0)


def full_disk(test, reference, sizes):
    """A small file system of its own; passed over where it may not be mounted."""
    alone = test.folder()  # without results beside it a checkpoint is smaller
    options = {**OPTIONS, "mpm_output_every": 0, "mpm_checkpoint_every": 2}
    Background(test.program, alone, example(SCENE), ranks=2, **options).wait()
    state = (alone / "run_checkpoint.h5").stat().st_size
    # run.h5 has 8 states; three and a checkpoint stand after step 2, a fourth has no room
    for label, size in (("during_a_checkpoint", int(2.4 * state)),
                        ("during_output", int(sizes["run_checkpoint.h5"] + 3.6 / 8 * sizes["run.h5"]))):
        disk = test.folder()
        mounted = subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={size}", "none", str(disk)], capture_output=True,
                                 check=False)
        if mounted.returncode:
            print("no file system could be mounted: a full disk was not tried")
            return
        try:
            options = {**OPTIONS, "mpm_output_every": 0 if label == "during_a_checkpoint" else 1}
            run = Background(test.program, disk, example(SCENE), ranks=2, **options, mpm_checkpoint_every=2)
            status, text = run.wait()
            one_line(test, label, status, text, "run_checkpoint.h5" if label == "during_a_checkpoint" else "run")
            (disk / "log").unlink()
            newest = disk / "run_checkpoint.h5"
            test.check(label + "_checkpoint", int(newest.exists()), 1, 1)
            place = test.folder()
            for path in disk.glob("run*"):
                shutil.copy(path, place)
            status, text = Background(test.program, place, example(SCENE), **options, mpm_restart="latest").wait()
            test.check(label + "_continued", status, 0, 0)
            test.check(label + "_whole", int("damaged" not in text), 1, 1)
            test.near(label + "_tip", summary(place)["steps"], summary(reference.parent)["steps"])
        finally:
            subprocess.run(["umount", str(disk)], check=False)


def main():
    signal.signal(signal.SIGINT, signal.default_int_handler)  # runs must not inherit that it is ignored
    with Test() as test:
        folder = test.folder()
        Background(test.program, folder, example(SCENE), **OPTIONS, mpm_checkpoint_every=10).wait()
        sizes = {path.name: path.stat().st_size for path in folder.iterdir()}
        reference = folder / "run"
        interrupt(test, reference, "usr1_to_mpiexec", signal.SIGUSR1, 2, None)
        interrupt(test, reference, "term_to_the_last_rank", signal.SIGTERM, 2, 1)
        interrupt(test, reference, "term_to_one_process", signal.SIGTERM, 1, None)
        interrupt(test, reference, "int_to_the_first_rank", signal.SIGINT, 2, 0)
        interrupt(test, reference, "int_to_one_process", signal.SIGINT, 1, None)
        interrupt_rows(test)
        interrupt_twice(test)
        interrupt_ignored(test)
        jobs(test, reference)
        gave_up(test)
        limited(test, reference, sizes)
        full_disk(test, reference, sizes)


main()
