#!/usr/bin/env python3
"""Messages of the command line, one after the other, on scenes and tables that the test writes: a refusal is one line with status
2 and leaves no file; a warning is one line, and the run goes on.

Quick.
"""
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import Test, call  # noqa: E402

SCENE = """mpm:
  dim: 2
  grid: {lower: "0,0", upper: "2,2", cells: "2,2"}
  materials: soil
  material_soil: {type: hencky, E: 1e6, nu: 0.3, density: 1000}
  bodies: one,two
  body_one: {region: box, lower: "0,0", upper: "1,1", material: soil}
  body_two: {region: box, lower: "1,0", upper: "2,1", material: soil}
  bcs: base
  bc_base: {region: box, lower: "0,0", upper: "2,0", components: "x,y"}
  loads: weight
  load_weight: {type: gravity, value: "0,-1"}
  time: {end: 1, step: 0.5}
  output: {prefix: run, every: 0}
"""
POINT = """mpm:
  dim: 2
  physics: stress_point
  materials: soil
  material_soil: {type: hencky, E: 1e6, nu: 0.3}
  point: {material: soil, path: table, table: path.csv, steps: 4}
  output: {prefix: run}
"""
PATH = "time,strain_xx,stress_yy\n1,0.01,-1000\n"
SPREADSHEET = "\ufeff# made by a spreadsheet\r\n\"TIME\";\"Strain_XX\";\"stress_yy\";\r\n1,0;0,01;-1000,0;\r\n"

# label, further or other files, words behind `talus`, what the line says: its end with $
REFUSED = [
    ("no_scene", {"t.yaml": "title: slope\n"}, ["t.yaml"], "t.yaml has no block mpm: a scene's options stand below `mpm:`$"),
    ("no_yaml", {"t.yaml": "mpm: [1\n"}, ["t.yaml"], "t.yaml: line 2 is no YAML: "),
    ("no_file", {}, ["t.yaml"], "t.yaml: the file cannot be read"),
    ("not_in_list", {"s.yaml": SCENE.replace("bodies: one,two", "bodies: one")}, ["s.yaml"],
     "-mpm_body_two_lower: unknown option; its block is not in -mpm_bodies one$"),
    ("list_forgotten", {"s.yaml": SCENE.replace("  loads: weight\n", "")}, ["s.yaml"],
     "-mpm_load_weight_type: unknown option; the list -mpm_loads is missing, which names such blocks$"),
    ("slip", {}, ["s.yaml", "-mpm_grid_cels", "2,2"], "-mpm_grid_cels: unknown option; did you mean -mpm_grid_cells?$"),
    ("slip_in_block", {"s.yaml": SCENE.replace("{type: hencky, E", "{type: hencky, colour: red, E")}, ["s.yaml"],
     "-mpm_material_soil_colour: unknown option$"),
    ("slip_of_three", {}, ["s.yaml", "-mpm_load_weight_vlau_", "2"], "-mpm_load_weight_vlau_: unknown option$"),
    ("word", {}, ["s.yaml", "-mpm_physics", "pore"], "-mpm_physics pore: must be one of damage, depth_averaged, poro, solid, stress_point$"),
    ("of_petsc", {}, ["s.yaml", "-ksp_rtoll", "1e-8"], "-ksp_rtoll: unknown option; did you mean -ksp_rtol?$"),
    ("of_petsc_in_file", {"s.yaml": SCENE + "mg_levels_pc_typ: jacobi\n"}, ["s.yaml"],
     "-mg_levels_pc_typ: unknown option; did you mean -mg_levels_pc_type?$"),
    ("of_nobody", {}, ["s.yaml", "-colour", "red"], "-colour: unknown option$"),
    ("without_mpm", {}, ["s.yaml", "-time_step", "0.1"], "-time_step: unknown option; did you mean -mpm_time_step?$"),
    ("field", {}, ["s.yaml", "-mpm_output_derived", "mises"], "-mpm_output_derived mises: there is no such field, must be of green_lagrange_strain, "),
    ("no_column", {"path.csv": PATH.replace("time", "t")}, ["point.yaml"], "path.csv: has no column time; there are t, strain_xx, stress_yy$"),
    ("no_component", {"path.csv": "time;strain_xx\n1;0,01\n"}, ["point.yaml"],
     "has no column strain_yy and none stress_yy; there are time, strain_xx$"),
    ("no_number", {"path.csv": "time;strain_xx;stress_yy\n1;0,01,2;0\n"}, ["point.yaml"], "line 2, column strain_xx: '0,01,2' is not a number$"),
]
# label, further files, words, the warning or None, a file that is there afterwards
ACCEPTED = [
    ("list_later", {"later.yaml": "mpm: {bodies: one}\n"}, ["s.yaml", "later.yaml"],
     "-mpm_body_two_lower and 3 more: left out, since a later list does not name the block (-mpm_bodies one)", "run_history.csv"),
    ("of_another_solver", {}, ["s.yaml", "-mpm_solver", "direct", "-ksp_gmres_restart", "9"],
     "-ksp_gmres_restart 9: nobody used this option: this run has no solver that takes it", "run_history.csv"),
    ("late", {}, ["s.yaml", "-log_view", ":log.txt", "-malloc_view", ":malloc.txt", "-snes_view", ":view.txt"], None, "log.txt"),
    ("folder", {}, ["s.yaml", "-mpm_output_prefix", "new/er/run"], None, "new/er/run_history.csv"),
    ("spreadsheet", {"path.csv": SPREADSHEET}, ["point.yaml"], None, "run_history.csv"),
]


def ended(test, files, words):
    """A call in a folder with these files."""
    place = test.folder()
    for name, text in {"s.yaml": SCENE, "point.yaml": POINT, "path.csv": PATH, **files}.items():
        (place / name).write_text(text, encoding="utf-8", newline="")
    before = set(place.iterdir())
    done = call([test.program, *words], place)
    return done, place, set(place.iterdir()) - before


def main():
    with Test() as test:
        for label, files, words, wanted in REFUSED:
            done, _, left = ended(test, files, words)
            line = done.stderr.rstrip("\n")
            right = line.endswith(wanted[:-1]) if wanted.endswith("$") else wanted in line
            test.check(f"refused.{label}", int(done.returncode == 2 and right and line.startswith("talus: error: ") and not left
                                               and "\n" not in line and not done.stdout), 1, 1)
            print("" if right else f"    {line}\n", end="")
        for label, files, words, wanted, made in ACCEPTED:
            done, place, _ = ended(test, files, words)
            lines = done.stderr.splitlines()
            right = lines == ([f"talus: warning: {wanted}"] if wanted else [])
            test.check(f"accepted.{label}", int(done.returncode == 0 and right and (place / made).exists()), 1, 1)
            print("" if right else f"    {done.stderr}", end="")
        plain, other = (ended(test, files, ["point.yaml"])[1] / "run_history.csv" for files in ({}, {"path.csv": SPREADSHEET}))
        test.check("same_numbers", plain.read_text() == other.read_text(), 1, 1)


main()
