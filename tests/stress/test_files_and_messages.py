#!/usr/bin/env python3
"""Files that a scene reads, and what the program says of a slip: tables as spreadsheets write them are read or refused with one
line, places and lists that cannot be meant are refused or told of, files stand beside the scene."""
import concurrent.futures
import sys
from pathlib import Path

import h5py
import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import Run, Test, difference  # noqa: E402
from refused import GOOD, Refusals, changed, faults, write_scene  # noqa: E402

MOVES = {"mpm_time_integrator": "newmark", "mpm_time_end": "1"}
NO_PUSH = {"mpm_loads": "weight", "mpm_load_push_type": None, "mpm_load_push_at": None, "mpm_load_push_nearest": None,
           "mpm_load_push_value": None}
FROM_FILE = {"mpm_body_block_lower": None, "mpm_body_block_upper": None, "mpm_body_block_points_per_cell": None,
             "mpm_body_block_region": "file", "mpm_body_block_file": "points.csv", **NO_PUSH}
WALL = {"mpm_boundaries": "wall", "mpm_boundary_wall_type": "plane", "mpm_boundary_wall_point": "0,2.5",
        "mpm_boundary_wall_normal": "0,-1", "mpm_boundary_wall_motion_table": "table.csv"}
OGDEN = {"mpm_material_soil_type": "ogden", "mpm_material_soil_E": None, "mpm_material_soil_nu": "0.4",
         "mpm_material_soil_terms": "table.csv"}
LABORATORY = {**{name: None for name in GOOD}, "mpm_dim": "2", "mpm_physics": "stress_point", "mpm_materials": "soil",
              "mpm_material_soil_type": "hencky", "mpm_material_soil_E": "1e6", "mpm_material_soil_nu": "0.3",
              "mpm_point_material": "soil", "mpm_point_path": "table", "mpm_point_table": "table.csv", "mpm_point_steps": "4",
              "mpm_output_prefix": "bad"}
BC_TABLE = {"mpm_bc_base_value": "0,1", "mpm_bc_base_table": "table.csv", "mpm_time_end": "1"}

# The four points of a square of 1 m, with the first table of each kind below: plain text, and what reads it.
POINTS = [["x", "y", "volume", "half_length_x", "half_length_y"],
          *[[x, y, 0.25, 0.25, 0.25] for y in (0.25, 0.75, 1.25, 1.75) for x in (0.25, 0.75, 1.25, 1.75)]]
PLAIN = {
    "points": (FROM_FILE, POINTS),
    "bc": (BC_TABLE, [["time", "value"], [0, 0], [0.5, -0.0125], [1, -0.025]]),
    "motion": (WALL, [["time", "ux", "uy"], [0, 0, 0], [1, 0, -0.55]]),
    "laboratory": (LABORATORY, [["time", "strain_xx", "stress_yy", "strain_zz"], [0.5, 0.01, -1000, 0], [1, 0.015, -2500, 0]]),
}
TERMS = [[-2.5, -1e5], [1.5, 2.5e5]]  # of Ogden's law: a parameter's table has no names


def table(rows, separator=",", comma=False, quotes=(), capitals=False, end="\n", last="", mark=""):
    """A table as a spreadsheet writes it; `quotes` around "names", "numbers" or both."""
    lines = []
    for k, row in enumerate(rows):
        words = [str(word) for word in row]
        if isinstance(row[0], str):
            words = [word.upper() if capitals else word for word in words]
        elif comma:
            words = [word.replace(".", ",") for word in words]
        if ("numbers" if k else "names") in quotes:
            words = [f'"{word}"' for word in words]
        lines.append(separator.join(words) + last)
    return mark + end.join(lines) + end


WRITTEN = {
    "byte-order mark": {"mark": "\ufeff"},
    "quotes": {"quotes": ("names", "numbers")},
    "capitals": {"capitals": True},
    "semicolons": {"separator": ";"},
    "semicolons and decimal commas": {"separator": ";", "comma": True},
    "tabs": {"separator": "\t"},
    "tabs and decimal commas": {"separator": "\t", "comma": True},
    "blanks": {"separator": "  "},
    "decimal commas in quotes": {"comma": True, "quotes": ("names", "numbers")},
    "carriage returns": {"end": "\r\n"},
    "carriage returns alone": {"end": "\r"},
    "commas and tabs": {"separator": ",\t"},
    "a separator at each line's end": {"separator": ";", "last": ";"},
    "rows of empty cells": {"separator": ";", "end": "\n;;\n\n"},
    "all of a spreadsheet": {"separator": ";", "comma": True, "quotes": ("names",), "capitals": True, "end": "\r\n", "mark": "\ufeff"},
}

X_Y = "x,y,volume\n"
# name, text (or bytes) of points.csv, further options, what the line must contain
POINTS_REFUSED = [
    ("unknown column", "x,y,volume,colour\n1,1,1,7\n", {}, "-mpm_body_block_file points.csv: column colour is unknown: the nearest"),
    ("slip in a column", "x,y,volume,strss_xx\n1,1,1,7\n", {}, "strss_xx is unknown: the nearest that is known is stress_xx"),
    ("velocity without axes", "x,y,volume,velocty_x\n1,1,1,7\n", MOVES, "the nearest that is known is velocity_x"),
    ("half of a velocity", "x,y,volume,velocity_x\n1,1,1,7\n", MOVES, "velocity needs the columns velocity_x to velocity_y, 1 of the 2"),
    ("velocity without inertia", "x,y,volume,velocity_x,velocity_y\n1,1,1,7,0\n", {}, "has velocities, and no stage has inertia"),
    ("no volume", "x,y,mass\n1,1,1\n", {}, "there is no volume; there are x, y, mass"),
    ("third axis of a plane", "x,y,z,volume\n1,1,0,1\n", {}, "column z is unknown"),
    ("pressure of dry ground", "x,y,volume,pressure\n1,1,1,0\n", {}, "column pressure is unknown"),
    ("doubled column", "x,y,volume,x\n1,1,1,2\n", {}, "line 1 has column x twice, as number 1 and 4"),
    ("doubled column but for case", "x,y,volume,Volume\n1,1,1,2\n", {}, "has column Volume twice, as number 3 and 4"),
    ("doubled column that is unknown", "x,y,volume,a,a\n1,1,1,2,2\n", {}, "has column a twice"),
    ("column without a name", "x,y,,volume\n1,1,1,2\n", {}, "line 1: column 3 has no name"),
    ("no names", "0.5,0.5,1\n1,1,1\n", {}, "line 1 has numbers, must have the names of the columns"),
    ("names in a remark", "# x,y,volume\n0.5,0.5,1\n", {}, "line 2 has numbers, must have the names"),
    ("decimal commas and points", "x;y;volume\n0,5;1;1\n1;1.5;1\n", {}, "line 2 has a decimal comma, line 3 a decimal point"),
    ("thousands", "x;y;volume\n1.000,5;1;1\n", {}, "line 2, column x: '1.000,5' is not a number"),
    ("thousands of thousands", "x;y;volume\n1,000,5;1;1\n", {}, "line 2, column x: '1,000,5' is not a number"),
    ("decimal commas between commas", "x,y,volume\n0,5,1,1\n", {}, "line 2 has 4 numbers, its columns are 3"),
    ("semicolons below commas", "x,y,volume\n0.5;1;1\n", {}, "line 2 has 1 numbers, its columns are 3"),
    ("empty cell", "x;y;volume\n1;;1\n", {}, "line 2, column y: '' is not a number"),
    ("open quote", 'x,y,volume\n1,"1,1\n', {}, "line 2: quotes that do not close"),
    ("text behind a quote", 'x,y,volume\n1,"1"2,1\n', {}, "line 2: quotes that do not close, or text behind them"),
    ("text in UTF-16", "x,y,volume\n1,1,1\n".encode("utf-16"), {}, "is text in UTF-16, must be in UTF-8"),
    ("name in Latin-1", "x,y,volume,h\u00f6he\n1,1,1,1\n".encode("latin-1"), {}, "column h?he is unknown"),
    ("name in UTF-8", "x,y,volume,h\u00f6he\n1,1,1,1\n", {}, "column h\u00f6he is unknown"),
    ("byte of value 0", b"x,y,volume\n1,1,1\n\x001,2,1\n", {}, "holds a byte of value 0"),
    ("mass 0", "x,y,volume,mass\n1,1,1,0\n", {}, "has a mass of 0, and its material a density"),
    ("mass negative", "x,y,volume,mass\n1,1,1,-1\n", {}, "has a negative mass"),
    ("domain wider than its volume", "x,y,volume,half_length_x,half_length_y\n1,1,1,1,1\n", {}, "is larger than its volume"),
    ("deformed domain wider than its volume", "x,y,volume,half_length_x,half_length_y,F_xx,F_xy,F_yx,F_yy\n1,1,1,0.5,0.5,1.5,0,0,1\n",
     {}, "is larger than its volume"),
]
# name, options, text of table.csv, what the line must contain
TABLES_REFUSED = [
    ("condition's table with another column", BC_TABLE, "time,value,phase\n0,0,0\n", "must have the columns time and value; there are time, value, phase"),
    ("condition's table of other columns", BC_TABLE, "Zeit;Wert\n0;0\n", "must have the columns time and value; there are Zeit, Wert"),
    ("motion without times", WALL, "t,ux\n0,0\n", "has no column time; there are t, ux"),
    ("test without times", LABORATORY, "strain_xx\n1\n", "has no column time; there is strain_xx"),
    ("test without a component", LABORATORY, "time,strain_xx,strain_zz\n1,0,0\n",
     "has no column strain_yy and none stress_yy; there are time, strain_xx, strain_zz"),
    ("condition's table with a column twice", BC_TABLE, "time,value,Time\n0,0,0\n", "has column Time twice"),
    ("motion with another column", WALL, "time,ux,vy\n0,0,0\n", "column vy is unknown: must be time, ux, uy or rz"),
    ("motion with a column twice", WALL, "time,ux,ux\n0,0,0\n", "has column ux twice"),
    ("test with another column", LABORATORY, "time,strain_xx,strain_yy,strain_zz,p\n1,0,0,0,0\n", "column p is unknown"),
    ("test with a column twice", LABORATORY, "time,strain_xx,strain_yy,strain_zz,STRAIN_XX\n1,0,0,0,0\n", "has column STRAIN_XX twice"),
    ("test that ends elsewhere", {**LABORATORY, "mpm_point_end": "2"}, table(PLAIN["laboratory"][1]),
     "-mpm_point_end 2: path table ends where its file does, at 1 s"),
    ("parameters with a decimal comma", OGDEN, "-2,5,1e5\n", "a row has two numbers, x and y; this one has 3"),
    ("parameters with names", OGDEN, "alpha,mu\n2,1e5\n", "line 1: 'alpha' is not a number"),
    ("parameters in UTF-16", OGDEN, "2,1e5\n".encode("utf-16"), "is text in UTF-16"),
]

REGION = {"mpm_track_top_region": "box", "mpm_track_top_lower": "3,3", "mpm_track_top_upper": "4,4", "mpm_track_top_at": None}
# name, change of the good scene, what the line must contain
SCENES_REFUSED = [
    ("track far away", {"mpm_track_top_at": "100,100"}, "-mpm_track_top_at 100,100: is 98 cells from the material, must be within one"),
    ("track two cells away", {"mpm_track_top_at": "4,2"}, "-mpm_track_top_at 4,2: is 2 cells from the material"),
    ("track of many points far away", {"mpm_track_top_at": "2,4", "mpm_track_top_nearest": "16"}, "-mpm_track_top_at 2,4"),
    ("track far away without domains", {"mpm_shape": "linear", "mpm_track_top_at": "4,4"}, "-mpm_track_top_at 4,4"),
    ("force far away", {"mpm_load_push_at": "50,50"}, "-mpm_load_push_at 50,50: is 48 cells from the material"),
    ("force three cells below", {"mpm_load_push_at": "1,-3"}, "-mpm_load_push_at 1,-3"),
    ("water that is led in far away", {"mpm_physics": "poro", "mpm_material_soil_porosity": "0.4", "mpm_material_soil_permeability": "1e-12",
                                       "mpm_load_push_type": "flux", "mpm_load_push_value": "1", "mpm_load_push_at": "9,9"}, "-mpm_load_push_at 9,9"),
    ("track in an empty region", REGION, "-mpm_track_top_region: there is no point in it"),
    # slips
    ("slip", {"mpm_grid_cels": "4,4"}, "-mpm_grid_cels: unknown option; did you mean -mpm_grid_cells?"),
    ("slip of two letters", {"mpm_body_block_pints_per_cel": "2,2"}, "did you mean -mpm_body_block_points_per_cell?"),
    ("slip of three letters", {"mpm_body_block_pint_per_cel": "2,2"}, "-mpm_body_block_pint_per_cel: unknown option$"),
    ("letters turned round", {"mpm_time_setp": "1"}, "did you mean -mpm_time_step?"),
    ("option that is nothing like another", {"mpm_colour": "red"}, "-mpm_colour: unknown option$"),
    ("option of another block", {"mpm_body_block_ramp": "0:0"}, "-mpm_body_block_ramp: unknown option$"),
    ("option of one letter", {"mpm_material_soil_G": "1e6"}, "-mpm_material_soil_G: unknown option$"),
    ("option of a stage", {"mpm_stages": "one", "mpm_stage_one_reductio": "0:1"}, "did you mean -mpm_stage_one_reduction?"),
    # lists
    ("list that is forgotten", {"mpm_surface_top_body": "block"}, "the list -mpm_surfaces is missing, which names such blocks"),
    ("list of loads that is forgotten", {"mpm_loads": None}, "the list -mpm_loads is missing, which names such blocks"),
    ("list of conditions that is forgotten", {"mpm_bcs": None}, "the list -mpm_bcs is missing"),
    ("list of boundaries that is forgotten", {"mpm_boundary_wall_type": "plane"}, "the list -mpm_boundaries is missing"),
    ("list of tracks that is forgotten", {"mpm_tracks": None}, "the list -mpm_tracks is missing"),
    ("list of stages that is forgotten", {"mpm_stage_one_time_end": "1"}, "the list -mpm_stages is missing"),
    ("list in the singular", {"mpm_loads": None, "mpm_load": "weight,push"}, "-mpm_load: unknown option; did you mean -mpm_loads?"),
    ("block that is not in its list", {"mpm_loads": "weight"}, "-mpm_load_push_at: unknown option; its block is not in -mpm_loads weight"),
    ("slip in a block's name", {"mpm_body_blok_region": "box"}, "-mpm_body_blok_region: unknown option; its block is not in -mpm_bodies block"),
]

# name, the scene's further options, those that come later, what the warning must contain (None: there is none, status 2)
LATER = [
    ("loads", {}, {"mpm_loads": "weight"}, "-mpm_load_push_at and 3 more: left out, since a later list does not name the block (-mpm_loads weight)"),
    ("tracks", {}, {"mpm_tracks": ""}, "-mpm_track_top_at: left out"),
    ("conditions", {"mpm_bcs": "base,side", "mpm_bc_side_region": "all", "mpm_bc_side_components": "x"}, {"mpm_bcs": "base"}, "-mpm_bc_side_components and 1 more"),
    ("materials", {"mpm_materials": "soil,rock", "mpm_material_rock_type": "hencky", "mpm_material_rock_E": "1e9", "mpm_material_rock_nu": "0.2"},
     {"mpm_materials": "soil"}, "-mpm_material_rock_E and 2 more"),
    ("bodies", {"mpm_bodies": "block,top", "mpm_body_top_region": "box", "mpm_body_top_lower": "0,2", "mpm_body_top_upper": "2,3",
                "mpm_body_top_material": "soil"}, {"mpm_bodies": "block"}, "-mpm_body_top_lower and 3 more"),
    ("stages", {"mpm_stages": "one,two", "mpm_stage_two_time_end": "0.5", "mpm_stage_two_reset_displacement": "true"},
     {"mpm_stages": "one,three", "mpm_stage_three_time_end": "0.5"}, "-mpm_stage_two_reset_displacement and 1 more"),
    ("stages that alone name a load", {"mpm_loads": "weight", "mpm_stages": "one,two", "mpm_stage_two_loads": "weight,push"},
     {"mpm_stages": "one"}, "-mpm_load_push_at and 3 more: left out"),
    ("two lists", {}, {"mpm_loads": "weight", "mpm_tracks": ""}, "(-mpm_loads weight); -mpm_track_top_at: left out"),
    ("a block that is later than its list", {}, {"mpm_load_pull_type": "force"}, None),
    ("a block beside its later list", {}, {"mpm_loads": "weight,push", "mpm_load_pull_type": "force"}, None),
    ("a slip beside a later list", {}, {"mpm_loads": "weight", "mpm_load_weight_valu": "0,-2"}, None),
]


def run(test, options, later=None, ranks=1, folder=None, **files):
    """A scene in a folder of its own, with files beside it; `later`: a second scene."""
    folder = folder or test.folder()
    scene = write_scene(folder, changed(options))
    for name, text in files.items():
        (folder / f"{name}.csv").write_bytes(text if isinstance(text, bytes) else text.encode())
    more = {}
    if later is not None:
        (folder / "later.yaml").write_text("".join(f'{name}: "{value}"\n' for name, value in later.items()), encoding="utf-8")
        more = {"options_file": folder / "later.yaml"}
    return Run(test.program, scene, ranks, more, folder)


def history(ended):
    """The last row of a run's history; zeros where it has none."""
    if ended.status or not ended.prefix:
        return np.zeros(1)
    return np.array([values[-1] for values in ended.results.history.values()])


def check_written(test, pool):
    """Tables in all ways of writing them give what plain ones do."""
    runs = {}
    for kind, (options, rows) in PLAIN.items():
        stem = "points" if kind == "points" else "table"
        for name, way in {"plain": {}, **WRITTEN}.items():
            runs[kind, name] = pool.submit(run, test, options, **{stem: table(rows, **way)})
    for name, way in {"plain": {}, **WRITTEN}.items():
        if not way.get("capitals") and "decimal commas in quotes" != name and "empty" not in name:
            runs["parameters", name] = pool.submit(run, test, OGDEN, table=table(TERMS, **way))
    for (kind, name), ended in runs.items():
        plain, other = runs[kind, "plain"].result(), ended.result()
        label = f"{kind}_{name}".replace(" ", "_")
        test.check(label, other.status == 0 and np.array_equal(history(plain), history(other)) and np.any(history(plain)), 1, 1)
        if other.status:
            print("   ", other.errors.strip())


def check_thrown(test, label, ended, velocity):
    """Points start with this velocity, and free flight takes them as far as it says, in each step of 0.1 s."""
    test.check(label, np.max(np.abs(ended.table("velocity", "first") - velocity)), None, 1e-12)
    moved = np.column_stack([ended.results.column(f"track_top_u{axis}") for axis in "xy"])
    test.check(f"{label}.moved", np.max(np.abs(moved - np.outer(ended.results.column("time"), velocity))), None, 1e-12)


def check_velocity(test):
    """Velocities of a table, and of another run's points, are those that the points start with."""
    rows = "".join(f"{x},{y},0.25,1,0\n" for y in (2.25, 2.75) for x in (1.25, 1.75))
    free = {**FROM_FILE, "mpm_bcs": None, "mpm_bc_base_region": None, "mpm_bc_base_lower": None, "mpm_bc_base_upper": None,
            "mpm_bc_base_components": None, "mpm_loads": None, "mpm_load_weight_type": None, "mpm_load_weight_value": None,
            "mpm_track_top_at": "1.5,2.5", "mpm_track_top_nearest": "4", "mpm_time_integrator": "newmark", "mpm_time_end": "0.2", "mpm_time_step": "0.1"}
    for ranks in (1, 2):
        thrown = run(test, free, ranks=ranks, points="x,y,volume,velocity_x,velocity_y\n" + rows)
        check_thrown(test, f"velocity.table_on_{ranks}", thrown, [1, 0])
    from_run = {**free, "mpm_body_block_file": thrown.folder / "bad.h5", "mpm_body_block_step": "0"}
    check_thrown(test, "velocity.run", run(test, from_run), [1, 0])
    check_thrown(test, "velocity.block_counts", run(test, {**from_run, "mpm_body_block_velocity": "0,1"}), [0, 1])
    still = run(test, {**free, "mpm_body_block_file": thrown.folder / "bad.h5", "mpm_time_integrator": None, "mpm_bcs": "all",
                       "mpm_bc_all_region": "all", "mpm_bc_all_components": "x,y"})
    test.check("velocity.of_a_run_without_inertia", still.status == 0 and "are not used, no stage has inertia" in still.output, 1, 1)


def check_water(test):
    """Pressure, porosity and mass of saturated ground go on from another run's points."""
    wet = {"mpm_physics": "poro", "mpm_material_soil_porosity": "0.4", "mpm_material_soil_permeability": "1e-12", "mpm_material_soil_E": "1e5",
           "mpm_body_block_upper": "4,2", "mpm_bcs": "base,sides,top", "mpm_bc_sides_region": "all", "mpm_bc_sides_components": "x",
           "mpm_bc_top_region": "box", "mpm_bc_top_lower": "0,2", "mpm_bc_top_upper": "4,4", "mpm_bc_top_components": "p",
           "mpm_load_weight_value": "0,-10", "mpm_load_weight_ramp": "0:1", "mpm_bc_base_components": "y", **NO_PUSH}
    times = {"mpm_time_step": "100", "mpm_output_every": "5", "mpm_grid_refine": "2"}
    whole = run(test, {**wet, **times, "mpm_time_end": "1000"})
    again = run(test, {**wet, **times, **FROM_FILE, "mpm_body_block_file": whole.folder / "bad.h5", "mpm_body_block_step": "5", "mpm_time_end": "500"})
    for name in ("pressure", "porosity", "mass"):
        test.check(f"water.{name}", difference(whole.table(name, 5), again.table(name, "first")), None, 1e-12)
        test.check(f"water.{name}_at_the_end", difference(whole.table(name, 10), again.table(name, "last")), None, 5e-3)  # slopes are found anew
    table = run(test, {**wet, **FROM_FILE, "mpm_time_end": "1e-3", "mpm_time_step": "1e-3"},
                points="x,y,volume,pressure\n" + "".join(f"{x},{y},0.25,{1e4 * (2 - y)}\n" for y in (0.25, 0.75, 1.25, 1.75) for x in np.arange(0.25, 4, 0.5)))
    test.near("water.table", table.table("pressure", "first").max(), 1.75e4, 1e-12)


def check_datasets(test):
    """HDF5 that is no run's: unknown datasets are refused as columns are."""
    for name, expected in (("mas", "dataset mas is unknown: the nearest that is known is mass"), ("mass", None)):
        folder = test.folder()
        with h5py.File(folder / "points.h5", "w") as file:
            file["position"], file["volume"], file[name] = [row[:2] for row in POINTS[1:]], [0.25] * 16, [250.0] * 16
        ended = run(test, {**FROM_FILE, "mpm_body_block_file": "points.h5"}, folder=folder)
        test.check(f"dataset_{name}", ended.status == (2 if expected else 0) and (expected or "") in ended.errors, 1, 1)


def check_tracks(test):
    """Points that have left: nan without any, a mean of the others else, and a note."""
    falls = {"mpm_loads": "weight", **NO_PUSH, "mpm_load_weight_value": "0,-10", "mpm_load_weight_ramp": "0:1", "mpm_bcs": None, "mpm_bc_base_region": None, "mpm_bc_base_lower": None,
             "mpm_bc_base_upper": None, "mpm_bc_base_components": None, "mpm_body_block_lower": "1,1", "mpm_body_block_upper": "2,3",
             "mpm_grid_outflow": "true", "mpm_time_integrator": "explicit", "mpm_time_step": None, "mpm_time_end": "0.65",
             "mpm_tracks": "low,all", "mpm_track_top_at": None, "mpm_track_low_at": "1.5,1", "mpm_track_low_nearest": "2", "mpm_track_all_region": "all"}
    ended = run(test, falls)
    low, whole = ended.results.column("track_low_uy"), ended.results.column("track_all_uy")
    test.check("track.gone", ended.status == 0 and np.isnan(low[-1]) and np.isfinite(low[0]), 1, 1)
    test.check("track.velocity_gone", np.isnan(ended.results.column("track_low_vy")[-1]), 1, 1)
    test.near("track.of_those_left", whole[-1], -0.5 * 10 * 0.65**2, 0.02)
    test.check("track.notes", "track low is nan: its points are gone" in ended.output and "track all: points are gone" in ended.output, 1, 1)
    taken = run(test, {**NO_PUSH, "mpm_bodies": "block,top", "mpm_body_top_region": "box", "mpm_body_top_lower": "0,2", "mpm_body_top_upper": "2,3",
                       "mpm_body_top_material": "soil", "mpm_track_top_at": "1,3", "mpm_stages": "one,two", "mpm_stage_one_time_end": "0.5",
                       "mpm_stage_two_remove": "top", "mpm_stage_two_time_end": "0.5"})
    test.check("track.removed", taken.status == 0 and np.array_equal(np.isnan(taken.results.column("track_top_uy")), [False, True]), 1, 1)
    joins = run(test, {**NO_PUSH, "mpm_bodies": "block,top", "mpm_body_top_region": "box", "mpm_body_top_lower": "0,2", "mpm_body_top_upper": "2,3",
                       "mpm_body_top_material": "soil", "mpm_track_top_at": "1,3", "mpm_stages": "one,two", "mpm_stage_one_time_end": "0.5",
                       "mpm_stage_two_bodies": "top", "mpm_stage_two_time_end": "0.5"})
    uy = joins.results.column("track_top_uy")
    test.check("track.joins", joins.status == 0 and uy[0] == 0 and uy[1] < 0, 1, 1)


def check_later(test, pool):
    """Blocks that a later list leaves out: a warning; the run's own options can be run again."""
    ended = [pool.submit(run, test, options, later) for _, options, later, _ in LATER]
    for (name, _, _, warning), future in zip(LATER, ended):
        result, label = future.result(), "later." + name.replace(" ", "_")
        if warning is None:
            test.check(label, len(list(faults(result, "unknown option", 1))) == 1 and result.status == 2, 1, 1)  # the second file
            continue
        lines = result.errors.splitlines()
        test.check(label, result.status == 0 and len(lines) == 1 and lines[0].startswith("talus: warning: ") and warning in lines[0], 1, 1)
        if result.status or warning not in result.errors:
            print("   ", result.errors.strip())
    again = Run(test.program, ended[0].result().folder / "bad_options.yaml", 1, {}, test.folder())
    test.check("later.again", again.status == 0 and again.errors == "", 1, 1)


def check_beside(test):
    """Files stand beside the scene that names them; else, and from the command line, in the working directory."""
    folder = test.folder()
    (folder / "scenes").mkdir()
    texts = {"points.csv": table(POINTS), "table.csv": table(PLAIN["bc"][1]), "move.csv": table(PLAIN["motion"][1]), "terms.csv": table(TERMS)}
    for name, text in texts.items():
        (folder / "scenes" / name).write_text(text, encoding="utf-8")
    scene = write_scene(folder / "scenes", changed({**FROM_FILE, **BC_TABLE, **WALL, **OGDEN, "mpm_boundary_wall_motion_table": "move.csv",
                                                    "mpm_material_soil_terms": "terms.csv"}))
    for ranks in (1, 2):
        ended = Run(test.program, scene.relative_to(folder), ranks, {}, folder)
        test.check(f"beside.scene_on_{ranks}", ended.status, 0, 0)
        print(ended.errors.strip() if ended.status else "")
    test.check("beside.results_where_the_run_is", (folder / "bad_history.csv").exists(), 1, 1)
    again = Run(test.program, "bad_options.yaml", 1, {}, folder)
    test.check("beside.options_again", again.status, 0, 0)
    (folder / "points.csv").write_text("x,y,volume\n1,1,4\n", encoding="utf-8")  # another of that name
    names = {"scene": {}, "command_line": {"mpm_body_block_file": "points.csv"}}
    counts = {name: Run(test.program, scene, 1, more, folder).results.summary["points"] for name, more in names.items()}
    test.check("beside.scene_first", counts["scene"], 16, 16)
    test.check("beside.command_line", counts["command_line"], 1, 1)
    for name in texts:
        (folder / name).write_text(texts[name], encoding="utf-8")
        (folder / "scenes" / name).unlink()
    test.check("beside.working_directory", Run(test.program, scene, 1, {}, folder).status, 0, 0)
    (folder / "scenes" / "test.csv").write_text(table(PLAIN["laboratory"][1]), encoding="utf-8")
    for end in ("1", "1.0000000001"):
        write_scene(folder / "scenes", changed({**LABORATORY, "mpm_point_table": "test.csv", "mpm_point_end": end}))
        test.check(f"beside.test_that_ends_at_{end}", Run(test.program, scene, 1, {}, folder).status, 0, 0)


with Test() as test, concurrent.futures.ThreadPoolExecutor(4) as pool:
    refusals = Refusals(test, {"unknown column", "doubled column", "velocity without inertia", "mass 0", "track far away", "force far away",
                               "condition's table with another column", "list that is forgotten"})
    for case, text, change, contains in POINTS_REFUSED:
        refusals.add(case, contains, {**FROM_FILE, **change}, points=text)
    for case, options, text, contains in TABLES_REFUSED:
        refusals.add(case, contains, options, table=text)
    for case, change, contains in SCENES_REFUSED:
        refusals.add(case, contains, change)
    refusals.finish()
    check_written(test, pool)
    check_velocity(test)
    check_water(test)
    check_datasets(test)
    check_tracks(test)
    check_later(test, pool)
    check_beside(test)
