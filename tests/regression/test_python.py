#!/usr/bin/env python3
"""The Python package: installed in a virtual environment, from a folder with a blank in its path.

The script makes the environment and runs itself there. Without a package index pip cannot fetch the build backend; the
environment then reads the package from the tree.
"""
import importlib.util
import inspect
import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import ENVIRONMENT, EXAMPLES, FULL, ROOT, Test, call  # noqa: E402

PACKAGE = ROOT / "python"
COLLAPSE = EXAMPLES / "collapse" / "case.yaml"
SAND = {"E": 30e6, "cohesion": 20e3, "friction": 32.0, "dilation": 10.0}
NO_INDEX = ("Could not find a version", "No matching distribution", "Connection", "Temporary failure in name resolution")


def install(folder):
    """A virtual environment with the package; its Python."""
    subprocess.run([sys.executable, "-m", "venv", "--system-site-packages", "--without-pip", folder], check=True)
    python = folder / "bin" / "python"
    isolation = ["--no-build-isolation"] if importlib.util.find_spec("scikit_build_core") else []
    done = subprocess.run([sys.executable, "-m", "pip", "--python", python, "install", "--quiet", "--no-deps", "--retries", "1",
                           *isolation, PACKAGE], cwd=folder, capture_output=True, text=True, check=False)
    if done.returncode and any(text in done.stderr for text in NO_INDEX):
        print("no package index: the package is read from the tree")
        site, = folder.glob("lib/python3*/site-packages")
        (site / "talus.pth").write_text(str(PACKAGE / "src"), encoding="utf-8")
    elif done.returncode:
        sys.exit(done.stderr)
    subprocess.run([python, "-m", "ipykernel", "install", "--sys-prefix"], check=True, capture_output=True)
    return python


def refusal(action, kind=None):
    """Text of the error that an action raises, by default a SceneError."""
    try:
        action()
    except kind or talus.SceneError as error:
        return str(error)
    return "accepted"


def check_package(test):
    """Public names with docstrings, the program by TALUS and by PATH, one version."""
    for name in talus.__all__:
        test.check(f"docstring.{name}", len(inspect.getdoc(getattr(talus, name)) or ""), 20)
    version = re.search(r'^version = "(.*)"', (PACKAGE / "pyproject.toml").read_text(encoding="utf-8"), re.MULTILINE)[1]
    test.check("version", f"project(talus VERSION {version} " in (ROOT / "CMakeLists.txt").read_text(encoding="utf-8"), 1, 1)
    test.check("program.named", talus.find_program() == test.program, 1, 1)
    place = test.folder()
    (place / "talus").symlink_to(test.program)
    path, named = os.environ["PATH"], os.environ.pop("TALUS")
    os.environ["PATH"] = f"{place}{os.pathsep}{path}"
    test.check("program.path", talus.find_program() == test.program, 1, 1)
    os.environ["PATH"], os.environ["TALUS"] = path, str(place / "nothing")
    try:
        talus.run(COLLAPSE)
        test.check("program.none", 0, 1, 1)
    except talus.RunError as error:
        test.check("program.none", "nothing: no such program" in error.line and error.status is None, 1, 1)
    os.environ["TALUS"] = named


def check_scene(test):
    """Options by name, from a file and from a dict; refusals that name the place; the file that is written."""
    scene = talus.Scene(COLLAPSE)
    test.check("scene.get", scene["material_soil_E"] == scene["-mpm_material.soil.E"] == scene["material_soil"]["E"] == 1e6, 1, 1)
    scene["material_soil_E"], scene["-snes_rtol"], scene["time_growth"] = np.float64(2e6), 1e-9, 1.5
    options = scene.options()
    test.check("scene.set", options["mpm_material_soil_E"] == 2e6 and options["snes_rtol"] == 1e-9 and scene["time"]["growth"] == 1.5, 1, 1)
    test.check("scene.copy", scene.changed(dim=3)["dim"] == 3 and scene["dim"] == 2 and "shape" in scene and "water" not in scene, 1, 1)
    again = talus.Scene(scene.write(test.folder() / "a scene.yaml"))
    test.check("scene.write", again.options() == options, 1, 1)
    for place, value in (("grid/cels", 1), ("material_soil/nu", 0.7), ("material_soil/type", "jelly"), ("time/step", -1), ("shape", "round"),
                         ("grid/lower", [0, "a"]), ("colour", "red"), ("bc_base/region", "corner")):
        said = refusal(scene.changed(**{place.replace("/", "_"): value}).check)
        test.check(f"refused.{place}", said.startswith("mpm/" + place.removesuffix("/type")) and len(said) < 350, 1, 1)
    test.check("refused.nearest", "the nearest is cells" in refusal(scene.changed(grid_cels=1).check), 1, 1)
    for name, source in (("none", {"a": 1}), ("missing", "nowhere.yaml"), ("twice", {"mpm": {"grid_cells": 1, "grid": {"cells": 1}}})):
        test.check(f"refused.{name}", refusal(lambda source=source: talus.Scene(source)) != "accepted", 1, 1)
    said = refusal(lambda: talus.run(scene, material_soil_E="soft"))
    test.check("refused.program", "-mpm_material_soil_E soft" in said and "talus:" not in said, 1, 1)


def check_body(test, scene):
    """Points from arrays, with stress."""
    x, y = (axis.ravel() for axis in np.meshgrid(np.arange(0.125, 8, 0.25), np.arange(0.125, 4, 0.25)))
    columns = {"stress": np.tile([-1e3, -2e3, -1e3, 0, 0, 0], (x.size, 1))}
    scene.add_body("heap", np.column_stack([x, y]), np.full(x.size, 0.0625), "soil", columns)
    scene["bodies"], scene["track_top_at"] = "heap", [7.9, 3.9]
    del scene["body_block"]
    results = talus.run(scene, folder="of arrays", time_end=0.025)
    test.check("body.points", len(results.points["id"]), x.size, x.size)
    for name, positions, volumes in (("shape", x, 1.0), ("volumes", np.ones((2, 2)), [1.0, -1.0]), ("rows", np.ones((2, 2)), [1.0])):
        said = refusal(lambda p=positions, v=volumes: scene.add_body("bad", p, v, "soil"))
        test.check(f"body.{name}", said.startswith("body_bad"), 1, 1)


def check_run(test):
    """Runs on one and two ranks, progress, tables, pictures, and runs that give up."""
    seen = []
    one = talus.run(COLLAPSE, time_end=0.1, progress=seen.append)
    two = talus.run(COLLAPSE, ranks=2, folder="two ranks", time_end=0.1)
    test.check("run.status", one.status == two.status == 0 and one.summary["status"] == "completed", 1, 1)
    test.check("run.progress", len(seen) > 1 and seen == sorted(seen) and seen[-1] == 1.0, 1, 1)
    moved = [results.history["track_toe_ux"].iloc[-1] for results in (one, two)]
    test.near("run.ranks", moved[1], moved[0], relative=1e-10)
    test.check("run.points", one.points["stress"].shape == (2304, 6) and one.states == [0, 4] and one.points.step == 4, 1, 1)
    test.check("run.first", one.state("first").time, 0, 0)
    test.check("run.html", "completed" in one._repr_html_() and "track_toe_ux" in one._repr_html_(), 1, 1)
    test.check("run.film", talus.plot.film(one, test.folder() / "film.gif", field="von_mises").read_bytes()[:3] == b"GIF", 1, 1)
    test.check("run.scene", talus.plot.scene(COLLAPSE).png[:4] == b"\x89PNG", 1, 1)
    test.check("run.picture", one.plot(field="stress", component="yy")._repr_png_()[:4] == b"\x89PNG", 1, 1)
    if importlib.util.find_spec("pyvista"):
        test.check("run.pyvista", one.to_pyvista().point_data["displacement"].shape == (2304, 3), 1, 1)
    test.check("run.opened", talus.Results("two ranks/collapse").history.equals(two.history), 1, 1)
    heavy = {"load_weight_value": "0,-1000", "material_soil_yield_stress": 1e3, "time_end": 0.1}
    try:
        talus.run(COLLAPSE, **heavy)
        test.check("run.gives_up", 0, 1, 1)
    except talus.RunError as error:
        test.check("run.gives_up", error.status == 3 and error.line.startswith("gave up") and error.results is not None, 1, 1)
    test.check("run.unchecked", talus.run(COLLAPSE, check=False, **heavy).status, 3, 3)
    check_body(test, talus.Scene(COLLAPSE))


def triaxial(pressure):
    """A drained triaxial test."""
    stress = [-pressure, -pressure, -pressure, 0, 0, 0]
    return talus.Scene({"mpm": {
        "dim": 3, "physics": "stress_point", "materials": "sand", "material_sand": {"type": "mohr_coulomb", "nu": 0.25, **SAND},
        "point": {"material": "sand", "stress": stress, "path": "triaxial_drained", "end": -0.06, "steps": 40}}})


def check_gradient(test):
    """Derivatives of a run: both methods, scaling, a misfit, refusals."""
    coarse = {"grid_cells": "16,8", "time_step": 0.1}
    names = ["soil.E", "soil.yield_stress", "weight.factor"]
    adjoint, tangent = (talus.gradient(COLLAPSE, names, "track_toe_ux", method=method, **coarse) for method in ("adjoint", "tangent"))
    test.near("gradient.tangent", float(abs(tangent.values / adjoint.values - 1.0).max()), 0.0, absolute=1e-8)
    parts = adjoint.values.to_numpy() * (1e6, 24494.897, 1.0)
    test.near("gradient.scaling", parts.sum(), 0.0, absolute=1e-6 * abs(parts).max())
    test.near("gradient.value", adjoint.objective, adjoint.results.history["track_toe_ux"].iloc[-1], relative=1e-9)
    misfit = talus.gradient(COLLAPSE, names, {"toe": {"column": "track_toe_ux", "target": 5.0, "deviation": 0.1}}, **coarse)
    test.near("gradient.misfit", misfit.objective, 0.5 * ((adjoint.objective - 5.0) / 0.1) ** 2, relative=1e-9)
    test.near("gradient.chain", misfit.values["soil.E"], adjoint.values["soil.E"] * (adjoint.objective - 5.0) / 0.01, relative=1e-6)
    test.check("gradient.refused", "no number Q" in refusal(lambda: talus.gradient(COLLAPSE, ["soil.Q"], "track_toe_ux")), 1, 1)


def check_sweep(test):
    """Sets as lists and as dicts; refused ones have a row without numbers, results stay where they are asked for."""
    table = talus.sweep(triaxial(1e5), {"material_sand_E": [20e6, 30e6, -1], "material_sand_dilation": [5, 40]}, folder="study")
    test.check("sweep.status", list(table["status"]) == [0, 2, 0, 2, 2, 2], 1, 1)
    test.check("sweep.numbers", list(table["q"].isna()) == [False, True, False, True, True, True], 1, 1)
    test.check("sweep.message", "must lie in [0, 32] degrees" in table["message"][1], 1, 1)
    test.check("sweep.kept", talus.Results("study/0002/talus").history["q"].iloc[-1] == table["q"][2], 1, 1)
    test.check("sweep.dicts", len(talus.sweep(triaxial(1e5), [{"point_steps": 5}, {"point_steps": 9}])), 2, 2)


def check_measurements(test, scene, table, names):
    """Tables of measurements in files as spreadsheets write them; columns that are missing are told with those that are there."""
    plain, path = _residual(scene, table, names), test.folder() / "measured.csv"
    rows = [[f"{value:.17g}" for value in row] for row in table.to_numpy()]
    for label, mark, separator, comma, title in (("plain", "", ",", False, str.lower), ("spreadsheet", "\ufeff", ";", True, str.upper),
                                                 ("tabs", "", "\t", True, str.title), ("quotes", "", ",", True, '"{}"'.format)):
        body = [[f'"{word}"' if title('a') == '"a"' else word for word in row] for row in rows]
        lines = ["# triaxial", separator.join(map(title, table.columns)), *(separator.join(row) for row in body)]
        text = "\r\n".join(lines)
        path.write_text(mark + (text.replace(".", ",") if comma else text) + "\r\n", encoding="utf-8")
        test.check(f"measured.{label}", np.abs(_residual(scene, path, names) - plain).max(), None, 1e-12)
    for label, header, wanted in (("history", "strain_yy,force", "the history has no column force; there are step, time, "),
                                  ("number", "strain_yy,q\n0,x", "row 1, column q: 'x' is not a number")):
        path.write_text(header + "\n0,1\n", encoding="utf-8")
        said = refusal(lambda: talus.calibrate(scene, path, names[:1]), ValueError)
        test.check(f"measured.{label}", wanted in said, 1, 1)
    said = refusal(lambda: talus.calibrate(scene, table, names[:1], abscissa="depth"), ValueError)
    test.check("measured.abscissa", "the table has no column depth; there are strain_yy, q, eps_v" in said, 1, 1)


def _residual(scene, measured, names):
    """Residual at the start values."""
    from talus.calibration import _Experiment
    return _Experiment(scene, measured, None).residual({name: scene[name] for name in names}, True)


def check_calibration(test):
    """Noisy measurements give the values back that they were made from."""
    noise, pairs, names = np.random.default_rng(0), [], [f"material_sand_{name}" for name in SAND]
    start = dict(zip(names, np.array(list(SAND.values())) * [1.4, 0.6, 0.6, 0.6]))
    for pressure in (25e3, 200e3):
        measured = talus.run(triaxial(pressure)).history[["strain_yy", "q", "eps_v"]].copy()
        measured[["q", "eps_v"]] *= 1.0 + 0.02 * noise.standard_normal((len(measured), 2))
        pairs.append((triaxial(pressure).changed(**start), measured))
    found = talus.calibrate(None, pairs, names, {names[2]: (5, 60), names[3]: (0, 30)})
    for name, value in SAND.items():
        test.near(f"calibration.{name}", found.parameters[f"material_sand_{name}"], value, relative=0.02)
    errors = np.abs(found.parameters - np.array(list(SAND.values()))) / found.deviations
    test.check("calibration.errors", float(errors.max()), None, 4)
    test.check("calibration.residual", found.residual, 0.005, 0.02)
    test.check("calibration.converged", found.converged and found.scenes[1]["material_sand_E"] == found.parameters[names[0]], 1, 1)
    check_measurements(test, triaxial(25e3), pairs[0][1].iloc[:6], names)
    said = refusal(lambda: talus.calibrate(triaxial(1e5), pairs[0][1], ["material_sand_tension"]))
    test.check("calibration.no_start", said.startswith("material_sand_tension"), 1, 1)


def check_notebooks(test):
    """Notebooks run, and keep no output. The study has 100 runs, of which five are refused."""
    import nbformat
    from nbclient import NotebookClient
    os.environ.pop("MPLBACKEND")  # pictures go into the notebook
    os.environ["PYDEVD_DISABLE_FILE_VALIDATION"] = "1"
    books = sorted((ROOT / "docs").glob("*.ipynb"))
    test.check("notebooks", len(books), 3)
    for path in books:
        book = nbformat.read(path, 4)
        test.check(f"{path.stem}.cleared", sum(len(cell.get("outputs", ())) for cell in book.cells), 0, 0)
        NotebookClient(book, timeout=120, kernel_name="python3", resources={"metadata": {"path": os.getcwd()}}).execute()
        texts = [str(output["data"].get("text/plain")) for cell in book.cells for output in cell.get("outputs", ()) if "data" in output]
        test.check(f"{path.stem}.outputs", len(texts), 2)
        if path.stem == "study":
            test.check("study.status", re.findall(r"^(\d) +(\d+)", texts[0], re.MULTILINE) == [("0", "95"), ("2", "5")], 1, 1)
        if path.stem == "slope":
            test.near("slope.factor_of_safety", float(texts[1]), 1.38, absolute=0.03)


def check_types(test):
    """The installed package is typed; with --full mypy, where it is installed."""
    test.check("types.marked", (Path(talus.__file__).parent / "py.typed").exists(), 1, 1)
    if FULL and importlib.util.find_spec("mypy"):
        done = call([sys.executable, "-m", "mypy", "--cache-dir", test.folder()], PACKAGE)
        test.check("types.mypy", done.returncode, 0, 0)
        print(done.stdout if done.returncode else "", end="")


def main():
    """The checks, in the environment."""
    with Test() as test:
        os.environ.update(ENVIRONMENT, TALUS=str(test.program), TALUS_MPIEXEC="mpiexec --oversubscribe")
        for check in (check_package, check_scene, check_run, check_gradient, check_sweep, check_calibration, check_notebooks,
                      check_types):
            check(test)


if __name__ == "__main__":
    if sys.prefix != sys.base_prefix:
        import talus
        main()
    else:
        with tempfile.TemporaryDirectory(prefix="talus place ") as place:
            call_again = [install(Path(place) / "environment"), Path(__file__).resolve(), *map(os.path.abspath, sys.argv[1:]),
                          *(["--full"] if FULL else [])]
            sys.exit(subprocess.run(call_again, cwd=place, env={**os.environ, **ENVIRONMENT}, check=False).returncode)
