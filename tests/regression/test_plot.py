#!/usr/bin/env python3
"""scripts/plot.py without a screen: pictures in 2D and 3D, films, also of bodies that come and go, curves, forces in cuts and
stress along lines, laboratory tests; and what it says of what is not there."""
import sys
from pathlib import Path

import numpy as np
from PIL import Image

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import ROOT, Test, call, difference, example  # noqa: E402
import plot as plot_module  # noqa: E402

PLOT = ROOT / "scripts" / "plot.py"


def plot(run, *words):
    return call([sys.executable, PLOT, run.prefix, *words], run.folder)


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


def check_frame(test, results, label, step="last"):
    """The picture's frame holds all domains, with their half lengths of that step."""
    state = results.state(step)
    for deformed in (False, True):
        lower, upper = plot_module.state_frame(state, results.origin(state), deformed)
        polygons = plot_module.domain_polygons(state, results.origin(state), deformed)
        size = np.max(np.ptp(polygons.reshape(-1, 2), axis=0))
        inside = min(np.min(polygons - lower), np.min(upper - polygons)) / size
        test.check(f"{label}.frame_{'deformed' if deformed else 'initial'}", inside, 0.035)
    sides = plot_module.domain_polygons(state, results.origin(state), True)
    one, two = sides[:, 1] - sides[:, 0], sides[:, 3] - sides[:, 0]
    start = plot_module.domain_polygons(state, results.origin(state), False).reshape(-1, 2)
    full = plot_module.domain_polygons(results.initial, results.origin(results.initial), False).reshape(-1, 2)
    test.check(f"{label}.first_places", np.abs(np.ptp(start, axis=0) - np.ptp(full, axis=0)).max(), None, 1e-9)
    test.check(f"{label}.domains", difference(state["volume"], np.abs(one[:, 0] * two[:, 1] - one[:, 1] * two[:, 0])), None, 1e-9)


with Test() as test:
    plane = test.run(example("collapse"), mpm_grid_cells="16,8", mpm_time_step=0.1, mpm_output_every=2)
    space = test.run(example("slump3d"), mpm_body_block_points_per_cell="2,2,2", mpm_time_step=0.25, mpm_output_every=2)
    check_picture(test, plane, "stress.png", "--field", "stress", "--component", "yy", "--deformed")
    check_picture(test, plane, "mises.png", "--field", "von_mises", "--step", "2")
    check_picture(test, space, "pressure.png", "--field", "pressure", "--deformed")
    check_picture(test, space, "displacement.png", "--step", "last")
    check_frame(test, plane.results, "collapse")
    check_frame(test, test.run(ROOT / "tests" / "verification" / "stretch.yaml").results, "divided")
    dig = test.run(ROOT / "tests" / "verification" / "dig.yaml")
    check_origin(test, dig.results)
    check_picture(test, dig, "removed.png", "--field", "stress", "--component", "yy", "--step", "2", "--deformed")
    check_picture(test, dig, "joined.png", "--field", "stress", "--component", "yy")
    for scene in (plane, space, dig):
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
    process = plot(plane, "--history", "track_top_uy", "track_toe_ux", "--output", "curves.svg")
    test.check("curves", process.returncode == 0 and "<svg" in (plane.folder / "curves.svg").read_text(), 1, 1)
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
        process = plot(plane, *words)
        test.check(f"wrong_{name}", process.returncode == 2 and process.stderr.startswith("plot.py:")
                   and len(process.stderr.splitlines()) == 1, 1, 1)
