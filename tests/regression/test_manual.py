#!/usr/bin/env python3
"""The command line and the manual: scenes by name and from standard input, pages of help, and its forms for other programs.

The JSON schema must accept every scene of the project and name the place of the fault in spoilt ones.

Quick.
"""
import copy
import json
import subprocess
import sys
from pathlib import Path

import jsonschema
import yaml

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import ENVIRONMENT, EXAMPLES, ROOT, Test, call  # noqa: E402

COLLAPSE = EXAMPLES / "collapse" / "case.yaml"
SHORT = ["-mpm_time_end", "0.01", "-mpm_output_every", "0"]


def piped(command, folder, text):
    """A process that reads `text` from its standard input."""
    return subprocess.run([str(word) for word in command], cwd=folder, input=text, capture_output=True, text=True,
                          env=ENVIRONMENT, timeout=120, check=False)


def check_scenes(test):
    """A scene by its name, with a second file over it, and from standard input; and what is none."""
    place = test.folder()
    text = COLLAPSE.read_text(encoding="utf-8")
    (place / "finer.yaml").write_text("mpm:\n  grid: {refine: 2}\n", encoding="utf-8")
    plain = call([test.program, COLLAPSE, *SHORT], place)
    test.check("scene.status", plain.returncode, 0, 0)
    test.check("scene.cells", "grid of 32 x 16 cells" in plain.stdout, 1, 1)
    test.check("second.cells", "grid of 64 x 32 cells" in call([test.program, COLLAPSE, "finer.yaml", *SHORT], place).stdout, 1, 1)
    for ranks in (1, 2):
        run = piped(["mpiexec", "--oversubscribe", "-n", ranks, test.program, "-", *SHORT], place, text)
        test.check(f"stdin.{ranks}", run.returncode == 0 and "grid of 32 x 16 cells" in run.stdout, 1, 1)
    for name, spoilt, message in (("no_yaml", "a: [1", "is no YAML"), ("no_scene", "a: 1", "has no block mpm")):
        run = piped([test.program, "-"], place, spoilt)
        test.check(f"stdin.{name}", run.returncode == 2 and message in run.stderr and run.stderr.count("\n") == 1, 1, 1)
    made = call([test.program, COLLAPSE, *SHORT, "-mpm_output_prefix", "new/er/run"], place)
    test.check("folder", made.returncode == 0 and (place / "new" / "er" / "run_summary.json").exists(), 1, 1)
    missing = call([test.program, "nowhere.yaml"], place)
    test.check("missing", missing.returncode == 2 and "nowhere.yaml: the file cannot be read" in missing.stderr, 1, 1)
    test.check("left", len(list(place.glob("talus-stdin*"))), 0, 0)


def check_pages(test):
    """Short help of at most 60 lines, version, topics, single options, and a topic that is none."""
    place = test.folder()
    for word in ("--help", "-h"):
        page = call([test.program, word], place)
        test.check(f"{word}.lines", len(page.stdout.splitlines()) * (page.returncode == 0), 20, 60)
        test.check(f"{word}.width", max(map(len, page.stdout.splitlines())), None, 120)
    scene = page.stdout.partition("  mpm:\n")[2].partition("\n\n")[0]
    (place / "ground.yaml").write_text(f"  mpm:\n{scene}\n", encoding="utf-8")
    test.check("help.scene_runs", call([test.program, "ground.yaml"], place).returncode, 0, 0)
    version = call([test.program, "--version"], place).stdout
    test.check("version", version.startswith("talus ") and "Petsc Release" in version and "compiled by" in version, 1, 1)
    topics = call([test.program, "help"], place).stdout
    test.check("topics", "Material of type mohr_coulomb" in topics and "Time" in topics, 1, 1)
    for topic, wanted, unwanted in (("mohr_coulomb", "cohesion_residual", "Material of type j2"), ("time", "-mpm_time_step ", "Grid"),
                                    ("-mpm_material_clay_yield_stress", "-mpm_material_NAME_yield_stress", "cohesion"),
                                    ("water", "-mpm_water_viscosity", "-mpm_grid_lower"), ("bc", "-mpm_bc_NAME_components", "Load"),
                                    ("permeability", "-mpm_material_NAME_permeability_law", "Young")):
        page = call([test.program, "help", topic], place)
        test.check(f"topic.{topic}", page.returncode == 0 and wanted in page.stdout and unwanted not in page.stdout, 1, 1)
    none = call([test.program, "help", "nonsense"], place)
    test.check("topic.none", none.returncode == 2 and "no such topic" in none.stderr and not none.stdout, 1, 1)


def check_check(test):
    """`talus check`: sizes, parts, the first step; no file; a first step that cannot converge, and a wrong scene."""
    place = test.folder()
    for ranks in (1, 3):
        page = call(["mpiexec", "--oversubscribe", "-n", ranks, test.program, "check", COLLAPSE], place)
        lines = dict((line[:24].strip(), line[25:]) for line in page.stdout.splitlines())
        right = (lines.get("cells") == "512, 32 x 16", lines.get("points") == "2304", lines.get("unknowns") == "578", "MB" in lines.get("memory", ""),
                 "40 are planned" in lines.get("time", ""), lines.get("condition base") == "17 nodes", lines.get("load weight") == "2304 points",
                 lines.get("track top") == "1 point", lines.get("first step") == "converged",
                 lines.get("body block", "").startswith("2304 points, 64 m2, material soil, x 0.08"))
        test.check(f"check.{ranks}", sum(right) * (page.returncode == 0), len(right), len(right))
    fails = call([test.program, "check", COLLAPSE, "-mpm_bcs", "symmetry"], place)
    test.check("check.unheld", fails.returncode == 3 and "nothing holds" in fails.stdout, 1, 1)
    wrong = call([test.program, "check", COLLAPSE, "-mpm_grid_cells", "0,0"], place)
    test.check("check.wrong", wrong.returncode == 2 and "-mpm_grid_cells" in wrong.stderr, 1, 1)
    test.check("check.files", len(list(place.iterdir())), 0, 0)


def check_json(test, options):
    """Every option has all keys; those of a physics name it."""
    by_name = {}
    for option in options:
        by_name.setdefault(option["option"], []).append(option)
        test_keys = {"option", "section", "type", "count", "unit", "default", "required", "physics", "help"}
        if not test_keys <= set(option):
            test.check(f"json.{option['option']}", 0, 1, 1)
    test.check("json.options", len(by_name), 300)
    porosity, = by_name["mpm_material_NAME_porosity"]
    test.check("json.physics", porosity["physics"] == ["poro"], 1, 1)
    test.check("json.range", porosity["exclusiveMinimum"] == 0 and porosity["exclusiveMaximum"] == 1, 1, 1)
    test.check("json.axes", by_name["mpm_grid_lower"][0]["count"] == "axes" and by_name["mpm_grid_lower"][0]["unit"] == "m", 1, 1)
    test.check("json.choices", "gimp" in by_name["mpm_shape"][0]["choices"] and by_name["mpm_shape"][0]["default"] == "gimp", 1, 1)
    physics = {name for option in options for name in option["physics"]}
    test.check("json.all_physics", physics == {"solid", "poro", "damage", "depth_averaged", "stress_point"}, 1, 1)


def scenes():
    """Every scene of the project, but those that need a plugin."""
    for path in sorted([*EXAMPLES.glob("*/*.yaml"), *(ROOT / "tests").glob("[!i]*/**/*.yaml"), *(ROOT / "scripts").rglob("*.yaml")]):
        scene = yaml.safe_load(path.read_text(encoding="utf-8"))
        if isinstance(scene, dict) and "mpm" in scene:
            yield path, scene


SPOILT = ([(block, "colour", "red") for block in ("", "grid", "material_*", "body_*", "bc_*", "load_*", "time", "output", "track_*")]
          + [("", key, "nonsense") for key in ("dim", "shape", "jacobian", "kinematics")] + [("", "grid", 3), ("", "dim", 4), ("", "dim", 0)]
          + [("grid", "cells", -1), ("grid", "refine", 0), ("grid", "lower", "a,b"), ("grid", "upper", True), ("grid", "mode", "bend")]
          + [("material_*", key, value) for key, value in (("type", "jelly"), ("E", -1), ("nu", 0.7), ("density", -2000), ("yield_stress", 0),
                                                             ("E", [1, "x"]), ("hardening", -1), ("cohesion", 1e3), ("Nu", 0.3))]
          + [("body_*", key, value) for key, value in (("region", "cube"), ("points_per_cell", 0), ("points_per_cell", "2;2"), ("lower", "x"),
                                                         ("radius", -1), ("velocity", "fast"), ("fill", "perhaps"))]
          + [("bc_*", key, value) for key, value in (("region", "corner"), ("value", "much"), ("component", "x"))]
          + [("load_*", key, value) for key, value in (("type", "wind"), ("value", "down"), ("nearest", 0))]
          + [("time", key, value) for key, value in (("end", 0), ("step", -1), ("integrator", "euler"), ("growth", "fast"), ("cfl", -0.5),
                                                       ("scheme", "third"), ("adaptive", "perhaps"))]
          + [("output", key, value) for key, value in (("every", -1), ("grid", "perhaps"), ("precision", "half"))])


def check_schema(test, schema):
    """Accepts what is right, and names the place of what is not."""
    validator = jsonschema.Draft7Validator(schema)
    accepted = 0
    for path, scene in scenes():
        errors = [error.message for error in validator.iter_errors(scene)]
        accepted += not errors
        if errors:
            test.check(f"schema.{path.relative_to(ROOT)}", len(errors), 0, 0)
    test.check("schema.accepts", accepted, 100)
    right = yaml.safe_load(COLLAPSE.read_text(encoding="utf-8"))
    right["mpm"]["tracks"], right["mpm"]["track_top"] = "top", {"at": "0,8", "nearest": 1}
    test.check("schema.right", len(list(validator.iter_errors(right))), 0, 0)
    for block, key, value in SPOILT:
        wrong = copy.deepcopy(right)
        name = next((name for name in wrong["mpm"] if block.endswith("*") and name.startswith(block[:-1])), block)
        (wrong["mpm"][name] if name else wrong["mpm"])[key] = value
        error = jsonschema.exceptions.best_match(validator.iter_errors(wrong))
        place = "/".join(map(str, error.absolute_path)) + " " + error.message if error else "accepted"
        test.check(f"spoilt.{name}.{key}.{value}", (name or key) in place and key in place, 1, 1)
    test.check("spoilt.count", len(SPOILT), 50)


def check_forms(test):
    """Man page without a warning, completions that complete."""
    place = test.folder()
    form = {name: must_make(test, name) for name in ("man", "bash", "zsh")}
    (place / "talus.1").write_text(form["man"], encoding="utf-8")
    lint = call(["mandoc", "-Tlint", "-Wwarning", "talus.1"], place)
    test.check("man.lint", lint.stdout.count("WARNING") + lint.stdout.count("ERROR"), 0, 0)
    test.check("man.options", form["man"].count("\n.TP\n"), 300)
    (place / "talus").write_text(form["bash"], encoding="utf-8")
    for words, wanted in ((["talus", "-mpm_sha"], "-mpm_shape"), (["talus", "-mpm_shape", "bsp"], "bspline2"),
                          (["talus", "help", "mohr"], "mohr_coulomb"), (["talus", "he"], "help")):
        line = " ".join(f'"{word}"' for word in words)
        script = f"source ./talus; COMP_WORDS=({line}); COMP_CWORD={len(words) - 1}; _talus; echo ${{COMPREPLY[@]}}"
        test.check(f"bash.{words[-1]}", wanted in call(["bash", "-c", script], place).stdout.split(), 1, 1)
    test.check("zsh", form["zsh"].startswith("#compdef talus\n") and "-mpm_shape) compadd -- linear" in form["zsh"], 1, 1)


def must_make(test, form):
    """A form of the manual."""
    made = call([sys.executable, ROOT / "scripts" / "manual.py", test.program, form], test.folder())
    test.check(f"{form}.status", made.returncode, 0, 0)
    return made.stdout


if __name__ == "__main__":
    with Test() as run_test:
        ENVIRONMENT["TMPDIR"] = str(run_test.folder())
        check_scenes(run_test)
        check_pages(run_test)
        check_check(run_test)
        check_json(run_test, json.loads(call([run_test.program, "-help=json"], run_test.folder()).stdout))
        check_schema(run_test, json.loads(must_make(run_test, "schema")))
        check_forms(run_test)
