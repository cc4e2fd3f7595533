#!/usr/bin/env python3
"""What the program says: the manual, the usage, the lines of a run, and nothing when it is to be quiet."""
import re
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import EXAMPLES, ROOT, Run, Test, call, example  # noqa: E402

sys.path.insert(0, str(ROOT / "scripts"))
from fuzz import parse_scene  # noqa: E402

LINE = re.compile(r" +(\d+) +([\d.e+-]+) +([\d.e+-]+) +\d+ +\d+ +(\d+) +([\d.]+)% +(\d+:\d\d:\d\d)")


def check_manual(test):
    """-help: every option of every example but PETSc's, in groups, ours alone, in lines that fit."""
    place = test.folder()
    general = call([test.program, "-help"], place)
    test.check("help.status", general.returncode, 0, 0)
    for group in ("Scene", "Grid", "Materials", "Bodies", "Conditions", "Loads", "Tracks", "Time", "Output", "Solver"):
        test.check(f"help.{group}", f"\n{group}\n" in general.stdout, 1, 1)
    for law in (ROOT / "materials").glob("*.c"):
        test.check(f"help.{law.stem}", f"Material of type {law.stem}: " in general.stdout, 1, 1)
    test.check("help.width", max(map(len, general.stdout.splitlines())), None, 120)
    test.check("help.of_petsc", general.stdout.count("PETSc Team"), None, 0)
    for path in sorted(EXAMPLES.glob("*/case*.yaml")):
        plugin = {"mpm_plugin": Path(test.program).parent / "bp.so"} if path.parent.name == "bps" else {}
        manual = test.run(path, **plugin, help=None).output
        ours = [name for name in parse_scene(path.read_text(encoding="utf-8")) if name.startswith("mpm_")]
        missing = [name for name in ours if f"  -{name} " not in manual and f"  -{name}\n" not in manual]
        test.check(f"help.missing.{path.parent.name}", len(missing), None, 0)
        print("".join(f"    {name}\n" for name in missing), end="")


def check_usage(test):
    place = test.folder()
    nothing = call([test.program], place)
    test.check("usage.status", nothing.returncode, 2, 2)
    test.check("usage.text", nothing.stderr.startswith("usage: talus SCENE.yaml") and not nothing.stdout, 1, 1)
    version = call([test.program, "-version"], place)
    test.check("version", version.returncode == 0 and version.stdout.startswith("talus "), 1, 1)
    (place / "wrong.opts").write_text("-mpm_dim 2\nmpm_shape gimp\n", encoding="utf-8")
    for ranks in (1, 2):  # nobody may wait for the rank that found the fault
        wrong = call(["mpiexec", "--oversubscribe", "-n", ranks, test.program, "-options_file", "wrong.opts"], place)
        test.check(f"wrong_file_on_{ranks}", wrong.returncode == 2 and wrong.stderr.count("talus: error:") == 1, 1, 1)
    test.check("help_petsc", "-ksp_rtol" in call([test.program, "-help_petsc"], place).stdout, 1, 1)


def check_lines(test):
    """One line a step, and the columns' titles once and again in a long run."""
    for step, count in ((1.0, 1), (0.01, 100)):
        run = test.run(example("bar_elastic"), mpm_time_step=step, mpm_grid_cells="1,8", mpm_output_every=0)
        lines = [match.groups() for match in map(LINE.fullmatch, run.output.splitlines()) if match]
        test.check("lines", len(lines), count, count)
        test.check("titles", run.output.count("time left"), (count + 49) // 50, (count + 49) // 50)
        test.check("done", float(lines[-1][4]), 100.0, 100.0)
        test.check("to_go", lines[-1][5] == "0:00:00", 1, 1)
    run = test.run(example("collapse"), mpm_time_step=0.1, mpm_output_every=0)  # jumps by 0.9 m in a step
    cuts = sum(int(match[4]) for match in map(LINE.fullmatch, run.output.splitlines()) if match)
    test.check("cuts", cuts, 1)
    test.check("reasons", run.output.count("the step is cut to"), cuts, cuts)
    run = test.run(example("dam_break"), mpm_time_end=0.1, mpm_output_every=0, mpm_output_history=50)
    summary = run.results.summary
    steps, rows = summary["steps"], list(map(int, run.results.column("step")))
    test.check("explicit.lines", sum(bool(LINE.fullmatch(line)) for line in run.output.splitlines()), 2, 2 + summary["time_total_s"])
    test.check("explicit.rows", rows == sorted({*range(50, steps, 50), steps}), 1, 1)
    for ranks in (1, 2):
        run = test.run(example("bar_elastic"), ranks=ranks, mpm_quiet=None, mpm_output_every=0)
        test.check("quiet", len(run.output + (run.errors if ranks == 1 else "")), None, 0)


def warnings(test, ranks=1, scene=example("bar_elastic"), status=0, **options):
    """The lines of warning of a run."""
    run = test.run(scene, ranks, status, **{"mpm_time_step": 0.5, "mpm_output_every": 0, **options})
    return [line for line in run.errors.splitlines() if line.startswith("talus: warning: ")]


def check_unknown(test):
    """Options that PETSc does not have end the run as the program's own do; of solvers within solvers, too."""
    slips = {"snes_typ": "snes_type", "pc_gamg_thresold": "pc_gamg_threshold", "mat_mumps_icntl_4x": "mat_mumps_icntl_4",
             "log_vew": "log_view", "mg_levels_1_ksp_max_itt": "mg_levels_1_ksp_max_it", "fieldsplit_u_pc_typ": "fieldsplit_u_pc_type",
             "grid_cells": "mpm_grid_cells", "Malloc_dmp": "malloc_dump", "colour": None, "ksp_colour_type": None}
    for ranks in (1, 2):
        for name, meant in slips.items() if ranks == 1 else (("snes_typ", "snes_type"),):
            run = Run(test.program, example("bar_elastic"), ranks, {name: "1"}, test.folder())
            line = f"talus: error: -{name}: unknown option" + (f"; did you mean -{meant}?" if meant else "")
            told = [text for text in run.errors.splitlines() if text.startswith("talus: ")]
            test.check(f"unknown.{name}.on_{ranks}", run.status == 2 and told == [line] and not run.files, 1, 1)
    late = {"mg_levels_2_ksp_type": "cg", "mg_coarse_sub_pc_type": "lu", "fieldsplit_u_mg_levels_ksp_max_it": "2", "pc_fieldsplit_0_fields": "0",
            "sub_3_pc_type": "ilu", "log_trace": "trace.txt", "info": ":info.txt", "malloc_view": ":malloc.txt", "device_enable_cuda": "none",
            "KSP_Type": "preonly", "options_view": None, "npc_snes_type": "newtonls"}
    run = test.run(example("bar_elastic"), mpm_time_step=1, mpm_output_every=0, mpm_quiet=None, **late)
    test.check("unknown.of_petsc", run.errors.count("unknown option"), None, 0)


def check_unused(test):
    """Options of PETSc's that the user gave and no solver of the run has; what PETSc asks for late, and presets, are none."""
    others = {"ksp_gmres_restart": "20", "pc_gamg_threshold": "0.1", "fieldsplit_u_ksp_type": "cg"}
    good = {"snes_rtol": "1e-9", "snes_monitor": None, "log_view": ":log.txt", "malloc_dump": None, "citations": "cite.txt",
            "options_left": None, "ksp_converged_reason": None, "snes_view": ":view.txt", "mat_view": "::ascii_info"}
    for ranks in (1, 2):
        lines = warnings(test, ranks, mpm_quiet=None, **others, **good)
        test.check("unused.lines", len(lines), len(others), len(others))
        for name, value in others.items():
            test.check(f"unused.{name}", sum(f": -{name} {value}: " in line for line in lines), 1, 1)
    other = warnings(test, mpm_solver="amg", pc_type="lu", pc_gamg_threshold="0.1")
    test.check("unused.of_another_solver", len(other) == 1 and "-pc_gamg_threshold 0.1" in other[0], 1, 1)
    multigrid = {"pc_gamg_threshold": "0.01", "mg_coarse_pc_type": "lu", "mg_levels_ksp_max_it": "3", "ksp_type": "cg"}
    for label, options in (("direct", {"mpm_solver": "direct"}), ("amg", {"mpm_solver": "amg", **multigrid}),
                           ("boomeramg", {"mpm_solver": "boomeramg", "pc_hypre_boomeramg_P_max": "4"}),
                           ("matfree", {"mpm_jacobian": "matfree"})):
        test.check(f"used.{label}", len(warnings(test, mpm_output_prefix="x", **options)), None, 0)
    for path in sorted(EXAMPLES.glob("*/case*.yaml")):
        short = {"mpm_time_end": 1e-3, "mpm_time_step": 1e-3, "mpm_time_step_min": 1e-3}  # one may give up so soon
        short |= {name: 1e-3 for name in parse_scene(path.read_text(encoding="utf-8")) if re.fullmatch(r"mpm_stage_\w+_time_end", name)}
        test.check(f"used.{path.parent.name}", len(warnings(test, 1, path, None, **short)), None, 0)


def check_unused_early(test):
    """An unused option of Newton's or the linear solver's is told of after the first step, not at the end."""
    command = [test.program, "-options_file", example("bar_elastic"), "-mpm_time_step", 0.1, "-mpm_output_every", 0]
    joined = ["sh", "-c", '"$@" 2>&1', "sh", *command, "-ksp_gmres_restart", 20, "-pc_gamg_threshold", 0.1]
    lines = call(joined, test.folder()).stdout.splitlines()
    steps = [index for index, line in enumerate(lines) if LINE.fullmatch(line)]
    places = [next(index for index, line in enumerate(lines) if name in line) for name in ("-ksp_gmres_restart", "-pc_gamg_threshold")]
    test.check("unused.early", steps[0] < places[0] < steps[1] and places[1] > steps[-1], 1, 1)


with Test() as test:
    check_manual(test)
    check_usage(test)
    check_lines(test)
    check_unknown(test)
    check_unused(test)
    check_unused_early(test)
