#!/usr/bin/env python3
"""Runs that are killed without warning restart from their last checkpoint and end as if nothing had happened.

Each run on two ranks is killed at a random time, and continued on 1 to 4 ranks; points and history must be those of a run
that nobody disturbed. The scenes have plastic history, and steps that are cut. Checkpoints that are damaged, cut short, of
another scene or no checkpoints at all are refused. --full: 20 kills in place of 3, and many more damaged bits.
"""
import random
import re
import shutil
import sys
import time
from pathlib import Path

sys.path[:0] = [str(Path(__file__).resolve().parent), str(Path(__file__).resolve().parent.parent)]

from runs import Background, differences  # noqa: E402
from talus_test import FULL, Results, Test, call, example  # noqa: E402
from results import ResultsError  # noqa: E402

# Few Newton iterations are allowed in the first, so that steps are cut; the ghost penalty comes on when one fails.
SCENES = {
    "collapse": {"mpm_output_every": 3, "mpm_time_step": 0.1, "snes_max_it": 7},
    "bar_j2": {"mpm_output_every": 3, "mpm_time_step": 0.05, "mpm_material_column_hardening": 100},
    "slump3d": {"mpm_output_every": 2, "mpm_time_step": 0.1},
}
RANKS = {"collapse": (2, 1, 4, 3), "bar_j2": (3, 2, 1, 4), "slump3d": (1, 2, 4)}  # of the second part of a run
CHECKPOINTS = {"mpm_checkpoint_every": 2}
TOLERANCE = 1e-10


def kill_and_continue(test, number, name, ranks, reference, duration, generator):
    """One kill at a time that is drawn from the length of the run, and the run's second part."""
    folder, options = test.folder(), {**SCENES[name], **CHECKPOINTS}
    if number % 3 == 0:
        options["mpm_checkpoint_collective"] = 0  # written and read by all ranks together
    run = Background(test.program, folder, example(name), **options)
    run.wait_for((folder / "run_checkpoint.h5").exists)
    time.sleep(generator.uniform(0.0, duration))
    steps = run.steps()
    run.kill()
    rest = Background(test.program, folder, example(name), ranks=ranks, **options, mpm_restart="latest")
    status, text = rest.wait()
    label = f"kill_{number}_{name}_after_{steps}_steps_on_{ranks}"
    test.check(label + "_status", status, 0, 0)
    if status:
        print(text)
        return
    points, history = differences(reference, folder / "run")
    test.check(label + "_points", points, upper=TOLERANCE)
    test.check(label + "_history", history, upper=TOLERANCE)
    test.check(label + "_left_over", len(list(folder.glob("*.tmp"))) - (folder / "run_checkpoint.h5.tmp").exists(), 0, 0)


def kills(test, count):
    generator = random.Random(20240 + count)
    names = list(SCENES) if FULL else ["collapse", "bar_j2"]
    references = {}
    for number in range(count):
        name = names[number % len(names)]
        if name not in references:
            folder, since = test.folder(), time.monotonic()
            status, _ = Background(test.program, folder, example(name), **SCENES[name]).wait()
            references[name] = (folder / "run", time.monotonic() - since)
            test.check(f"{name}_undisturbed", status, 0, 0)
        ranks = RANKS[name][(number // len(names)) % len(RANKS[name])]
        kill_and_continue(test, number, name, ranks, *references[name], generator)


# ---- damage ----


def refused(test, label, folder, words, ranks=1, **options):
    """The run must end with status 2 and one line that holds the words, and leave the results alone."""
    before = {path.name: path.read_bytes() for path in folder.iterdir() if path.name != "log"}
    status, text = Background(test.program, folder, example("bar_j2"), ranks=ranks, **options).wait()
    lines = [line for line in text.splitlines() if line.startswith("talus: error: ")]
    good = status == 2 and len(lines) == 1 and all(word in lines[0] for word in words)
    if not good:
        print(f"{label}: status {status}\n{text}")
    test.check(label, int(good), 1, 1)
    after = {path.name: path.read_bytes() for path in folder.iterdir() if path.name != "log"}
    test.check(label + "_files_as_before", int(before == after), 1, 1)


def damage(test):
    """A run of ten steps with two checkpoints, of which the newest is spoiled in every way."""
    folder, generator = test.folder(), random.Random(7)
    options = {"mpm_time_step": 0.1, "mpm_time_end": 0.8, "mpm_checkpoint_every": 4}
    Background(test.program, folder, example("bar_j2"), ranks=1, **options).wait()
    options["mpm_time_end"] = 1
    newest, older = folder / "run_checkpoint.h5", folder / "run_checkpoint_000004.h5"
    test.check("kept", len(list(folder.glob("run_checkpoint*.h5"))), 2, 2)
    bytes_of = newest.read_bytes()
    whole = {**options, "mpm_restart": "run_checkpoint.h5"}
    for length in (0, 512, len(bytes_of) - 1):
        newest.write_bytes(bytes_of[:length])
        refused(test, f"cut_to_{length}", folder, ["run_checkpoint.h5"], **whole)
    newest.write_bytes(bytes_of + b"\0")
    refused(test, "a_byte_longer", folder, ["run_checkpoint.h5", "damaged"], **whole)
    places = [3, 60, 90, 512] + [generator.randrange(len(bytes_of)) for _ in range(200 if FULL else 3)]
    for place in places:
        spoiled = bytearray(bytes_of)
        spoiled[place] ^= 1 << generator.randrange(8)
        newest.write_bytes(spoiled)
        refused(test, f"bit_in_byte_{place}", folder, ["run_checkpoint.h5"], ranks=2 if place == 512 else 1, **whole)
    newest.write_bytes(re.sub(rb"format \d+\n", b"format 0\n", bytes_of, count=1))
    refused(test, "another_format", folder, ["run_checkpoint.h5", "version"], **whole)
    refused(test, "no_checkpoint_but_another_file", folder, ["run_history.csv"], **{**options, "mpm_restart": "run_history.csv"})
    refused(test, "no_such_file", folder, ["nowhere.h5", "No such file"], **{**options, "mpm_restart": "nowhere.h5"})
    newest.write_bytes(bytes_of)
    for option, value in (("mpm_material_column_E", "11e3"), ("mpm_grid_refine", 2), ("mpm_track_top_nearest", 2)):
        refused(test, "other_" + option, folder, ["run_checkpoint.h5", "-" + option], **whole, **{option: value})
    latest(test, folder, newest, older, bytes_of, options)


def latest(test, folder, newest, older, bytes_of, options):
    """The newest is damaged: one line says so, and the one before it is taken; with both damaged the run is refused."""
    spoiled = bytearray(bytes_of)
    spoiled[len(spoiled) // 2] ^= 16
    newest.write_bytes(spoiled)
    old_bytes = older.read_bytes()
    older.write_bytes(old_bytes[:-1])
    refused(test, "both_damaged", folder, ["-mpm_restart latest", "run_checkpoint"], **options, mpm_restart="latest")
    older.write_bytes(old_bytes)
    status, text = Background(test.program, folder, example("bar_j2"), ranks=1, **options, mpm_restart="latest").wait()
    test.check("from_the_one_before", status, 0, 0)
    test.check("one_line_of_the_damage", sum("run_checkpoint.h5" in line for line in text.splitlines()), 1, 1)
    reference = test.folder()
    Background(test.program, reference, example("bar_j2"), ranks=1, mpm_time_step=0.1, mpm_checkpoint_every=4).wait()
    points, history = differences(reference / "run", folder / "run")
    test.check("from_the_one_before_points", points, upper=TOLERANCE)
    test.check("from_the_one_before_history", history, upper=TOLERANCE)
    empty = test.folder()
    refused(test, "none_there", empty, ["-mpm_restart latest", "run_checkpoint.h5"], **options, mpm_restart="latest")
    others_results(test, folder, reference, options)


def inconsistent_results(test):
    """A results file in which every list of groups is garbage, as an interrupted write may leave it, is rolled back."""
    options = {"mpm_time_step": 0.1, "mpm_checkpoint_every": 3}
    reference, folder = test.folder(), test.folder()
    for place in (reference, folder):
        Background(test.program, place, example("bar_j2"), ranks=1, **options).wait()
    (folder / "run_checkpoint.h5").unlink()  # the checkpoint of step 9 is the last one but the end's
    results = folder / "run.h5"
    content = bytearray(results.read_bytes())
    spoiled = 0
    for signature in (b"TREE", b"SNOD", b"HEAP"):
        place = content.find(signature)
        while place >= 0:
            content[place:place + 48] = b"\xa5" * 48
            spoiled += 1
            place = content.find(signature, place + 1)
    results.write_bytes(content + b"and half a state")
    test.check("spoiled_lists", spoiled, lower=6)
    try:
        readable = int(Results(folder / "run").steps == [0, 10])
    except (ResultsError, OSError, RuntimeError, KeyError):
        readable = 0
    test.check("spoiled_results_are_readable", readable, 0, 0)
    status, _ = Background(test.program, folder, example("bar_j2"), ranks=2, **options, mpm_restart="latest").wait()
    test.check("spoiled_results_continued", status, 0, 0)
    points, history = differences(reference / "run", folder / "run")
    test.check("spoiled_results_points", points, upper=TOLERANCE)
    test.check("spoiled_results_history", history, upper=TOLERANCE)


def others_results(test, folder, reference, options):
    """Result files that are not those of the checkpoint are not touched; where there are none, new ones are begun."""
    for suffix in (".h5", "_history.csv"):
        place = test.folder()
        for path in reference.glob("run*"):
            shutil.copy(path, place)
        path = place / ("run" + suffix)
        content = bytearray(path.read_bytes())
        content[:] = content[: len(content) // 5]
        path.write_bytes(content)
        refused(test, "shortened_run" + suffix, place, ["run" + suffix, "shorter"], **options, mpm_restart="latest")
    place = test.folder()
    status, _ = Background(test.program, place, example("bar_j2"), ranks=1, **options,
                           mpm_restart=folder / "run_checkpoint_000008.h5").wait()
    test.check("into_an_empty_folder", status, 0, 0)
    process = call([sys.executable, "-c", "import h5py; print('position0' in h5py.File('run.h5')['points/000008'])"], place)
    test.check("first_state_has_position0", int(process.stdout.strip() == "True"), 1, 1)


def main():
    with Test() as test:
        kills(test, 20 if FULL else 3)
        damage(test)
        inconsistent_results(test)


main()
