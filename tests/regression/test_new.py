#!/usr/bin/env python3
"""Scenes to start from: `talus new` lists and writes them, `talus check` passes them, they run, on coarser cells and for a part of their
time; and the module talus.templates.

The load on the footing after 2.5 mm is that of an elastic half space within a factor; the slope's factor of safety is that of a limit
analysis of its clay within what 1 m cells add.
"""
import os
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import Test, call  # noqa: E402

sys.path.insert(0, str(Path(__file__).resolve().parent.parent.parent / "python" / "src"))
NAMES = ["excavation", "footing", "slope", "triaxial"]
SHORT = {"slope": {"mpm_grid_cells": "40,14"}, "footing": {"mpm_grid_cells": "20,14", "mpm_stage_load_time_end": 0.1},
         "excavation": {"mpm_grid_cells": "30,16"}, "triaxial": {}}


def check_scene(test, name):
    folder = test.folder()
    words = [test.program, "new", name]
    test.check(f"{name}.written", call(words, folder).returncode, 0, 0)
    again = call(words, folder)
    test.check(f"{name}.kept", int(again.returncode == 2 and f"{name}.yaml cannot be written" in again.stderr), 1, 1)
    checked = call([test.program, "check", f"{name}.yaml"], folder)
    test.check(f"{name}.check", checked.returncode, 0, 0)
    test.check(f"{name}.effect", checked.stdout.count("has no effect"), 0, 0)
    return test.run(folder / f"{name}.yaml", mpm_output_prefix=name, **SHORT[name])


def check_python(test):
    os.environ["TALUS"] = str(test.program)
    from talus import SceneError, templates
    test.check("python.names", int(templates.names() == NAMES), 1, 1)
    for name in NAMES:
        scene = templates.scene(name)
        scene.check()
        test.check(f"python.{name}", int(scene["title"] in templates.text(name)), 1, 1)
    try:
        templates.text("pit")
    except SceneError as error:
        test.check("python.error", int(str(error).startswith("new pit: there is no such scene")), 1, 1)


with Test() as test:
    folder = test.folder()
    listed = call([test.program, "new"], folder).stdout
    test.check("list", int([line.split()[0] for line in listed.splitlines() if line.startswith("  ")] == NAMES), 1, 1)
    for words, error in ((["pit"], "new pit: there is no such scene; must be one of " + ", ".join(NAMES)),
                         (["slope", "a.yaml", "b"], "new slope: b is one word too many"), (["slope", "no/a.yaml"], "no/a.yaml cannot be written")):
        ended = call([test.program, "new", *words], folder)
        test.check(f"refused.{'.'.join(words)}", int(ended.returncode == 2 and error in ended.stderr), 1, 1)
    test.check("refused.files", len(list(folder.iterdir())), 0, 0)
    runs = {name: check_scene(test, name) for name in NAMES}
    test.check("slope.factor", runs["slope"].results.summary["factor_of_safety"], 1.7, 2.1)
    test.check("footing.load", -runs["footing"].results.column("reaction_push_y")[-1], 20e3, 200e3)
    heave = runs["excavation"].results.column("track_floor_uy")[-1]
    test.check("excavation.heave", heave, 1e-3, 0.05)
    test.check("excavation.strut", abs(runs["excavation"].results.column("reaction_strut_x")[-1]), 5e3, 500e3)
    test.near("triaxial.q", runs["triaxial"].results.column("q")[-1], 288.23e3, relative=5e-3)
    check_python(test)
