#!/usr/bin/env python3
"""scripts/plot.py without a screen: pictures in 2D and 3D, films, also of bodies that come and go, curves, forces in cuts and
stress along lines, laboratory tests; `talus plot`, `talus check --picture`; and what they say of what is not there."""
import contextlib
import io
import os
import sys
from collections import namedtuple
from pathlib import Path

import numpy as np
from PIL import Image

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import ENVIRONMENT, ROOT, Test, call, difference, example  # noqa: E402
from pictures import command, curves, domains, fields, plane, units  # noqa: E402
from results import Origin  # noqa: E402
from pictures.scene import Scene  # noqa: E402

Done = namedtuple("Done", "returncode stderr")


def plot(run, *words):
    """The command line of scripts/plot.py, in this process: loading matplotlib takes longer than most pictures."""
    before, said = os.getcwd(), io.StringIO()
    os.chdir(run.folder)
    try:
        with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(said):
            status = command.main([run.prefix, *words])
    except SystemExit as end:
        status = end.code
    finally:
        os.chdir(before)
    return Done(status, said.getvalue())


def colours(path):
    """How many colours a picture has that are not grey."""
    pixels = np.asarray(Image.open(path).convert("RGB")).reshape(-1, 3).astype(int)
    return len(np.unique(pixels[np.ptp(pixels, axis=1) > 30], axis=0))


def check_picture(test, run, name, *words):
    """A command that must draw a picture of many colours."""
    process = plot(run, *words, "--output", name)
    test.check(f"{name}.status", process.returncode, 0, 0)
    test.check(f"{name}.colours", colours(run.folder / name) if process.returncode == 0 else 0, 50)


def check_origin(test, results):
    """Ground and fill of dig.yaml, when the cover has gone and the fill has come: where each point was first."""
    state = results.state("last")
    ground = results.initial["position0"][results.initial["position0"][:, 1] < 4.0]
    origin = results.origin(state)
    test.check("origin.gone", len(results.initial["id"]) - len(ground), 32, 32)
    test.check("origin.ground", difference(ground, origin.position[: len(ground)]), None, 0.0)
    fill = np.sort(origin.position[len(ground):, 1])  # two rows of eight
    test.check("origin.fill", np.abs(fill - np.repeat([4.125, 4.375], 8)).max(), None, 1e-3)
    test.check("origin.lengths", np.abs(origin.lengths - 0.25).max(), None, 1e-6)


def check_domains(test, results, label, step="last"):
    """Domains have the points' volumes, those at first fill the body; what is drawn joins them."""
    state = results.state(step)
    origin = results.origin(state)
    sides = domains.domain_polygons(state, origin, True)
    one, two = sides[:, 1] - sides[:, 0], sides[:, 3] - sides[:, 0]
    start = domains.domain_polygons(state, origin, False).reshape(-1, 2)
    full = domains.domain_polygons(results.initial, results.origin(results.initial), False).reshape(-1, 2)
    test.check(f"{label}.first_places", np.abs(np.ptp(start, axis=0) - np.ptp(full, axis=0)).max(), None, 1e-9)
    test.check(f"{label}.domains", difference(state["volume"], np.abs(one[:, 0] * two[:, 1] - one[:, 1] * two[:, 0])), None, 1e-9)
    look = plane.look_at(results, Scene(results), state)
    away = np.abs(look.domains.corners - sides[look.domains.owner]).max() if look.domains.corners.shape[1] == 4 else 0.0
    test.check(f"{label}.joined", away / origin.lengths.max(), None, domains.APART)


def check_cut(test):
    """A disc on a lattice: its pieces have the disc's area, and one outline without stairs."""
    x, y = (axis.ravel() for axis in np.meshgrid(np.arange(-0.95, 1.0, 0.1), np.arange(-0.95, 1.0, 0.1)))
    place = np.column_stack([x, y])[x**2 + y**2 < 0.81]
    ring = 0.9 * np.column_stack([np.cos(np.linspace(0, 2 * np.pi, 200, endpoint=False)), np.sin(np.linspace(0, 2 * np.pi, 200, endpoint=False))])
    first = domains.first_domains(Origin(place, np.full(place.shape, 0.1)), [domains.Region(ring, np.arange(len(place)), [])])
    test.near("disc.area", sum(domains.area(corners) for corners in first.corners), domains.area(ring), relative=1e-9)
    segments, _ = domains.outline(first, np.zeros(len(place), int))
    test.check("disc.outline", np.abs(np.linalg.norm(segments, axis=2) - 0.9).max(), None, 1e-3)


def check_scales(test, results):
    """Uniform fields, units of settlement and time, displacement that goes on over resets."""
    state = results.state("last")
    state.fields["noise"] = 5.0 + 1e-12 * np.arange(len(state["id"]))
    state.fields["slope"] = 5.0 + np.arange(len(state["id"]))
    test.check("uniform", [fields.read_field(state, name, None).uniform for name in ("noise", "slope")] == [True, False], 1, 1)
    for size, unit, text in ((0.03, "m", "30 mm"), (2.0, "m", "2 m"), (15e3, "Pa", "15 kPa"), (3e-6, "m", "3 µm")):
        test.check(f"amount.{text.replace(' ', '_')}", units.amount(size, unit) == text, 1, 1)

    class Timed:
        has_time = True

    for time, text in ((100.0, "time 100 s"), (3.0 * 86400.0, "time 3 days"), (1e8, "time 3.169 years")):
        test.check(f"time.{time:g}", units.time_text(Timed, time) == text, 1, 1)
    test.check("time.pseudo", units.time_text(Scene(results), 1.0) == "pseudo-time 1", 1, 1)


def check_resets(test, results):
    """Tracks go on where a stage sets displacement back to zero."""
    scene = Scene(results)
    name = next(column for column in results.history if column.startswith("track_") and column.endswith("_uy"))
    total, stage = curves.continued(results, scene, name), results.column("stage")
    row = int(np.flatnonzero(stage == 4)[0])
    test.near("resets.total", total[row] - total[row - 1], results.column(name)[row], absolute=1e-12)
    test.check("resets.reset", abs(results.column(name)[row - 1] - total[row - 1]) < 1e-12 and abs(total[row - 1]) > 0.0, 1, 1)


def check_program(test, run, scene):
    """`talus plot` and `talus check --picture`; one line where Python or a package is missing."""
    environment = os.environ.get("TALUS_PYTHON")
    os.environ["TALUS_PYTHON"] = ENVIRONMENT["TALUS_PYTHON"] = sys.executable
    process = call([test.program, "plot", run.prefix, "--output", "program.png"], run.folder)
    test.check("program.plot", process.returncode == 0 and colours(run.folder / "program.png") > 50, 1, 1)
    process = call([test.program, "plot", run.prefix, "--field", "colour"], run.folder)
    test.check("program.wrong", process.returncode == 2 and process.stderr.startswith("talus plot: "), 1, 1)
    folder = test.folder()
    process = call([test.program, "check", scene, "--picture", "scene.png"], folder)
    test.check("program.check", process.returncode == 0 and colours(folder / "scene.png") > 3, 1, 1)
    test.check("program.files", sorted(path.name for path in folder.iterdir()) == ["scene.png"], 1, 1)
    ENVIRONMENT["TALUS_PYTHON"] = "/bin/false"
    for words in (("plot", run.prefix), ("check", scene, "--picture", "scene.png"), ("check", scene, "--picture")):
        process = call([test.program, *words], folder)
        said = process.stderr.splitlines()
        test.check(f"program.none.{words[0]}{len(words)}", process.returncode in (1, 2) and 1 <= len(said) <= 2 and said[0].startswith("talus: error: "), 1, 1)
    ENVIRONMENT["TALUS_PYTHON"] = environment or sys.executable


with Test() as test:
    block = test.run(example("collapse"), mpm_grid_cells="16,8", mpm_time_step=0.1, mpm_output_every=2)
    space = test.run(example("slump3d"), mpm_body_block_points_per_cell="2,2,2", mpm_time_step=0.25, mpm_output_every=2)
    check_picture(test, block, "stress.png", "--field", "stress", "--component", "yy", "--deformed")
    check_picture(test, block, "mises.png", "--field", "von_mises", "--step", "2")
    check_picture(test, space, "pressure.png", "--field", "pressure", "--deformed")
    check_picture(test, space, "displacement.png", "--step", "last")
    check_domains(test, block.results, "collapse")
    check_domains(test, test.run(ROOT / "tests" / "verification" / "stretch.yaml").results, "divided")
    check_cut(test)
    check_scales(test, block.results)
    check_resets(test, test.run(example("slope_stages"), mpm_stage_load_time_end=0.1).results)
    check_program(test, block, example("collapse"))
    dig = test.run(ROOT / "tests" / "verification" / "dig.yaml")
    check_origin(test, dig.results)
    check_picture(test, dig, "removed.png", "--field", "stress", "--component", "yy", "--step", "2", "--deformed")
    check_picture(test, dig, "joined.png", "--field", "stress", "--component", "yy")
    for scene in (block, space, dig):
        count = len(scene.results.steps)  # a picture for each state: how many steps are cut is not for this test
        test.check("film.states", count, 3)
        process = plot(scene, "--field", "von_mises", "--animate", "--output", "film.gif")
        test.check("film.status", process.returncode, 0, 0)
        test.check("film.pictures", Image.open(scene.folder / "film.gif").n_frames, count, count)
    laboratory = test.run(example("triaxial"), mpm_quiet=None)
    (laboratory.folder / "measured.csv").write_text("# remark\nstrain_yy,q,p\n-0.01,250e3,\n-0.05,260e3,-187e3\n")
    check_picture(test, laboratory, "laboratory.png")
    check_picture(test, laboratory, "measured.png", "--measured", "measured.csv")
    (laboratory.folder / "sheet.csv").write_text('\ufeff"STRAIN_YY";q;p\n-0,01;250e3;\n-0,05;260e3;-187e3\n;;\n', encoding="utf-8")
    check_picture(test, laboratory, "sheet.png", "--measured", "sheet.csv")
    pictures = [np.asarray(Image.open(laboratory.folder / name)).astype(int) for name in ("measured.png", "sheet.png")]
    test.check("sheet.same", np.abs(pictures[0] - pictures[1]).max(), None, 0)
    (laboratory.folder / "twice.csv").write_text("q,p,q\n1,2,3\n", encoding="utf-8")
    for name, words in (("twice", ("--measured", "twice.csv")), ("measured", ("--measured", "none.csv")), ("columns", ("--measured", "triaxial_summary.json"))):
        process = plot(laboratory, *words)
        test.check(f"wrong_{name}", process.returncode == 2 and len(process.stderr.splitlines()) == 1, 1, 1)
    process = plot(block, "--history", "track_top_uy", "track_toe_ux", "--output", "curves.svg")
    test.check("curves", process.returncode == 0 and "<svg" in (block.folder / "curves.svg").read_text(), 1, 1)
    bracket = test.run(ROOT / "tests" / "verification" / "sections.yaml", mpm_quiet=None)
    for name, words in (("forces", ("--section", "row")), ("stress", ("--profile", "up")), ("start", ("--profile", "up", "--step", "first")),
                        ("cut", ("--history", "section_mid_n", "section_low_t", "profile_up_n"))):
        process = plot(bracket, *words, "--output", f"{name}.svg")
        test.check(f"line_{name}", process.returncode == 0 and "<svg" in (bracket.folder / f"{name}.svg").read_text(), 1, 1)
    for name, words in (("section", ("--section", "none")), ("section_step", ("--section", "row", "--step", "1"))):
        process = plot(bracket, *words)
        test.check(f"wrong_{name}", process.returncode == 2 and len(process.stderr.splitlines()) == 1, 1, 1)
    for name, words in (("field", ("--field", "colour")), ("step", ("--step", "1")), ("column", ("--history", "load_x")),
                        ("component", ("--field", "stress", "--component", "xyz")), ("map", ("--colours", "none")),
                        ("tensor", ("--field", "stress")), ("run", ("--measured", "a.csv"))):
        process = plot(block, *words)
        test.check(f"wrong_{name}", process.returncode == 2 and process.stderr.startswith("plot.py:")
                   and len(process.stderr.splitlines()) == 1, 1, 1)
