#!/usr/bin/env python3
"""Voids three ways: empty, filled with air, under a background stiffness; and materials by voxels.

Layers in series carry one stress, in closed form by the neo-Hookean law, while their faces lie on cells' faces. A background of a block's own elasticity
doubles its force. The example void_cell against its reference; a background against air of its own stiffness.

Quick.
"""
import shutil
import sys
from pathlib import Path

import h5py
import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import EXAMPLES, Test  # noqa: E402

# the stack is symmetric, so that the mean displacement of its points is that of its middle
LAYERS = """mpm:
  dim: 2
  shape: linear
  grid: {{lower: "0,0", upper: "{h!r},1", cells: "1,{cells}", follow: stack, axes: "y", mode: stretch, at: 0.5}}
  materials: grain,binder,air
  material_air: {{type: neo_hookean, E: 5, nu: 0, density: 1, air: true}}
  material_binder: {{type: neo_hookean, E: 300, nu: 0.25, density: 1}}
  material_grain: {{type: neo_hookean, E: 4000, nu: 0.25, density: 1}}
  bodies: stack
  body_stack: {{region: voxels, file: layers.{kind}, lower: "0,0", upper: "{h!r},1", labels: "0:air,1:binder,2-900:grain"}}
  bcs: sides,base,top
  bc_sides: {{region: box, lower: "0,0", upper: "{h!r},1", components: "x"}}
  bc_base: {{region: box, lower: "0,0", upper: "{h!r},0", components: "y"}}
  bc_top: {{region: box, lower: "0,1", upper: "{h!r},1", components: "y", value: "-0.1", ramp: "0:0,1:1"}}
  loads: weight
  load_weight: {{type: gravity, value: "0,0", ramp: "0:1"}}
  time: {{end: 1, step: 0.1}}
  output: {{every: 10}}
  quiet: true
"""
BLOCK = """mpm:
  dim: {dim}
  shape: {shape}
  grid: {{lower: "{low}", upper: "{one}", cells: "{cells}"}}
  materials: block
  material_block: {{type: linear_elastic, E: 100, nu: 0.3, density: 1}}
  bodies: block
  body_block: {{region: box, lower: "{low}", upper: "1{half}", material: block}}
  bcs: fixed,drawn,sides
  bc_fixed: {{region: box, lower: "{low}", upper: "0{ones}", components: "x"}}
  bc_drawn: {{region: box, lower: "1{zeros}", upper: "{one}", components: "x", value: "1e-4", ramp: "0:0,1:1"}}
  bc_sides: {{region: box, lower: "{low}", upper: "{one}", components: "{across}"}}
  backgrounds: soft
  background_soft: {{region: box, lower: "{low}", upper: "{one}", E: 50, nu: 0.3}}
  time: {{end: 1, step: 0.25}}
  output: {{every: 0}}
  checkpoint: {{every: 2}}
  quiet: true
"""

BENT = """mpm:
  dim: {dim}
  shape: element
  order: {order}
  grid: {{lower: "{zero}", upper: "{one}", cells: "{two}"}}
  materials: block
  material_block: {{type: linear_elastic, E: 100, nu: 0.3, density: 1}}
  bodies: block
  body_block: {{region: file, file: points.csv, material: block}}
  bcs: fixed,bent
  bc_fixed: {{region: box, lower: "{zero}", upper: "0{top}", components: "{axes}"}}
  bc_bent: {{region: box, lower: "1{y}", upper: "{one}", components: "y", value: "1e-6", ramp: "0:0,1:1"}}
  stabilization: {{fbar: false}}
  time: {{end: 1, step: 1}}
  output: {{every: 0}}
  quiet: true
"""

# a block in air that is next to nothing
UNSEEN = """mpm:
  dim: 2
  grid: {lower: "0,0", upper: "4,3", cells: "16,12"}
  materials: solid,air
  material_solid: {type: neo_hookean, E: 1000, nu: 0.25, density: 1}
  material_air: {type: neo_hookean, E: 1e-5, nu: 0, density: 1, air: true}
  bodies: void,foot,block
  body_void: {region: all, material: air}
  body_block: {region: box, lower: "0,0", upper: "2,2", material: solid, priority: true}
  body_foot: {region: box, lower: "1,2", upper: "2,2.5", material: solid, priority: true}
  bcs: base,west
  bc_base: {region: box, lower: "0,0", upper: "4,0", components: "y"}
  bc_west: {region: box, lower: "0,0", upper: "0,3", components: "x"}
  loads: layer,body,corner
  load_layer: {type: traction, region: box, lower: "1,1.9", upper: "4,2.9", face: "+y", value: "0,-12"}
  load_body: {type: force, region: box, lower: "0,1", upper: "3,3", value: "0,-7"}
  load_corner: {type: force, at: "2,0.4", nearest: 5, value: "3,0"}
  surfaces: side
  surface_side: {body: block, side: "+x", normal: -2}
  tracks: whole
  track_whole: {region: all}
  time: {end: 1, step: 0.5}
  output: {every: 0}
  quiet: true
"""
# three welded columns of unit width, whose points have materials of their own, under their weight
COLUMNS = """mpm:
  dim: 2
  shape: linear
  grid: {lower: "0,0", upper: "3,4", cells: "3,4"}
  materials: soft,hard,clay
  material_soft: {type: neo_hookean, E: 1e5, nu: 0, density: 1}
  material_hard: {type: linear_elastic, E: 1e6, nu: 0, density: 2}
  material_clay: {type: j2, E: 1e6, nu: 0, density: 3, yield_stress: 3}
  bodies: block
  body_block: {region: file, file: points.csv}
  bcs: west,middle,east,sides
  bc_west: {region: box, lower: "0,0", upper: "0,0", components: "y"}
  bc_middle: {region: box, lower: "1,0", upper: "2,0", components: "y"}
  bc_east: {region: box, lower: "3,0", upper: "3,0", components: "y"}
  bc_sides: {region: box, lower: "0,0", upper: "3,4", components: "x"}
  loads: weight
  load_weight: {type: gravity, value: "0,-1"}
  time: {end: 1, step: 0.5}
  checkpoint: {every: 1}
  quiet: true
"""
MATERIALS = ("soft", "hard", "clay")
DIE = {"mpm_boundaries": "die", "mpm_boundary_die_type": "sphere", "mpm_boundary_die_center": "0.4,2.4", "mpm_boundary_die_radius": 0.4,
       "mpm_boundary_die_motion": "0,-0.02"}

SOFT = {"mpm_backgrounds": "soft", "mpm_background_soft_region": "all", "mpm_background_soft_E": 0.5e6}


def voxels(folder, kind):
    """Files of 1 x 32 voxels: grain, binder and air from both ends to the middle."""
    half = np.repeat([7, 1, 0], [6, 8, 2])
    label = np.concatenate([half, half[::-1]])
    if kind == "csv":
        (folder / "layers.csv").write_text("i,j,label\n" + "".join(f"0,{j},{k}\n" for j, k in enumerate(label)))
    elif kind == "h5":
        with h5py.File(folder / "layers.h5", "w") as file:
            file["labels"] = label.reshape(32, 1).astype("u1")
    else:
        label.astype("<u2").tofile(folder / "layers.raw")
        (folder / "layers.mhd").write_text("ObjectType = Image\nNDims = 2\nDimSize = 1 32\nElementType = MET_USHORT\n"
                                           "ElementByteOrderMSB = False\nElementDataFile = layers.raw\n")


def layers(test, cells, kind, ranks=1, **options):
    folder = test.folder()
    voxels(folder, kind)
    (folder / "layers.yaml").write_text(LAYERS.format(h=1.0 / cells, cells=cells, kind=kind))
    return test.run(folder / "layers.yaml", ranks=ranks, **options)


def stresses(run, cells):
    """At 5 and 10 per cent, in ten steps."""
    force = np.array(run.results.history["reaction_top_y"])
    return force[4] * cells, force[-1] * cells


def block_text(dim, shape):
    return BLOCK.format(dim=dim, shape=shape, low="0" + ",0" * (dim - 1), one="1" + ",1" * (dim - 1), half=",0.5" + ",1" * (dim - 2),
                        zeros=",0" * (dim - 1), ones=",1" * (dim - 1), cells="4" + ",4" * (dim - 1), across="y,z"[:2 * dim - 3])


def block(test, dim, shape, ranks=1, **options):
    folder = test.folder()
    (folder / "block.yaml").write_text(block_text(dim, shape))
    run = test.run(folder / "block.yaml", ranks=ranks, **options)
    return folder, run, np.array(run.results.history["reaction_drawn_x"])


def doubled(test, dim, order, ranks):
    """Force of a bent block of elements at Gauss points, under a background of its own law, over that without."""
    folder, force = test.folder(), []
    places, weights = np.polynomial.legendre.leggauss(order + 1)
    line = np.concatenate([(places + 1.0) / 4.0, (places + 3.0) / 4.0])
    x = np.stack(np.meshgrid(*[line] * dim, indexing="ij"), axis=-1).reshape(-1, dim)
    volume = np.prod(np.stack(np.meshgrid(*[np.tile(weights, 2) / 4.0] * dim, indexing="ij"), axis=-1).reshape(-1, dim), axis=1)
    np.savetxt(folder / "points.csv", np.column_stack([x, volume]), delimiter=",", fmt="%.17g", comments="",
               header=",".join([*"xyz"[:dim], "volume"]))
    zero, one = ("0" + ",0" * (dim - 1)), ("1" + ",1" * (dim - 1))
    for more in ({}, {"mpm_backgrounds": "own"}):
        (folder / "bent.yaml").write_text(BENT.format(dim=dim, order=order, zero=zero, one=one, two="2" + ",2" * (dim - 1),
                                                      axes=",".join("xyz"[:dim]), y=",0" * (dim - 1), top=",1" * (dim - 1)))
        more = {**more, **({f"mpm_background_own_{key}": value for key, value in
                            {"region": "all", "E": 100, "nu": 0.3}.items()} if more else {})}
        force.append(test.run(folder / "bent.yaml", ranks=ranks, **more).results.history["reaction_bent_y"][-1])
    return force[1] / force[0]


def cell(test, *more, ranks=1, **options):
    """Force at 5 and 10 per cent, and the unknowns."""
    folder = test.folder()
    for name in ("case.yaml", "cell.geojson"):
        shutil.copy(EXAMPLES / "void_cell" / name, folder)
    options.update({"options_file": EXAMPLES / "void_cell" / name for name in more})
    run = test.run(folder / "case.yaml", ranks=ranks, mpm_time_step=0.5, mpm_output_every=0, mpm_quiet="true", **options)
    return -np.array(run.results.history["reaction_top_y"]) / 1e6, run.results.summary["active_dofs_max"]


def unseen(test):
    """Loads, surfaces, boundaries, contacts and tracks act as if no air were there."""
    folder = test.folder()
    (folder / "filled.yaml").write_text(UNSEEN)
    alone = UNSEEN.replace("solid,air", "solid").replace("void,", "")
    (folder / "alone.yaml").write_text("".join(line for line in alone.splitlines(True) if "_air:" not in line and "_void:" not in line))
    for name, options in (("die", DIE), ("foot", {"mpm_contacts": "pair", "mpm_contact_pair_bodies": "foot,block", "mpm_contact_pair_friction": 0.3})):
        values = {}
        for scene, ranks in (("filled", 1), ("filled", 3), ("alone", 1)):
            history = test.run(folder / f"{scene}.yaml", ranks=ranks, **options).results.history
            values[scene, ranks] = np.array([history[column][-1] for column in ("reaction_base_y", "reaction_west_x", "track_whole_uy")])
        test.check(f"unseen.{name}", abs(values["filled", 1] / values["alone", 1] - 1.0).max(), None, 0.01)
        test.check(f"unseen.{name}.ranks_3", abs(values["filled", 3] / values["filled", 1] - 1.0).max(), None, 1e-6)


def columns(test, words, ranks=1, kind="csv", **options):
    """Points with a cell `material` of these words, by column."""
    folder = test.folder()
    places = [(0.25 + 0.5 * i, 0.25 + 0.5 * j, words[i // 2]) for j in range(8) for i in range(6)]
    if kind == "csv":
        (folder / "points.csv").write_text("x,y,volume,material\n" + "".join(f"{x},{y},0.25,{word}\n" for x, y, word in places))
    else:
        with h5py.File(folder / "points.h5", "w") as file:
            file["position"] = np.array([place[:2] for place in places])
            file["volume"] = np.full(len(places), 0.25)
            file["material"] = np.array([place[2] for place in places])
        options["mpm_body_block_file"] = folder / "points.h5"
    (folder / "columns.yaml").write_text(COLUMNS)
    return folder / "columns.yaml", test.run(folder / "columns.yaml", ranks=ranks, **options)


def reactions(run):
    return np.array([run.results.history[f"reaction_{name}_y"][-1] for name in ("west", "middle", "east")])


def by_table(test, scene, first):
    """Materials by a table are those by blocks; options of the scene replace cells. A thousand cost what they must."""
    folder = scene.parent
    table = "name,type,E,nu,density,yield_stress\nsoft,neo_hookean,1e5,0,1,\nhard,linear_elastic,1e6,0,2,\nclay,j2,1e6,0,3,3\n"
    lines = [line for line in COLUMNS.splitlines(True) if "material" not in line]
    (folder / "table.yaml").write_text("".join([lines[0], "  materials_file: table.csv\n", *lines[1:]]))
    (folder / "table.csv").write_text(table)
    runs = {ranks: test.run(folder / "table.yaml", ranks=ranks) for ranks in (1, 3)}
    for ranks, run in runs.items():
        test.check(f"table.ranks_{ranks}", float(abs(reactions(run) / reactions(first) - 1.0).max()), None, 1e-9)
    stiffer = [reactions(test.run(path, mpm_material_clay_E=2e6)) for path in (scene, folder / "table.yaml")]
    test.check("table.replaced", float(abs(stiffer[1] / stiffer[0] - 1.0).max()), None, 1e-12)
    test.check("table.replaced.differs", float(abs(stiffer[1] / reactions(first) - 1.0).max()), 1e-6)
    again = test.run(folder / "table.yaml", ranks=3, mpm_restart=next(runs[1].folder.glob("*checkpoint*1.h5")))
    test.check("table.restart", float(abs(reactions(again) / reactions(first) - 1.0).max()), None, 1e-9)
    (folder / "table.csv").write_text(table + "".join(f"m{k},neo_hookean,1e5,0.25,1,\n" for k in range(1000)))
    many = test.run(folder / "table.yaml")
    test.check("table.thousand", float(abs(reactions(many) / reactions(first) - 1.0).max()), None, 1e-9)
    test.check("table.thousand.seconds", many.results.summary["time"]["setup"], None, 3.0)
    for name, old, new, line in (("unknown", "yield_stress\n", "yield_strss\n", "-mpm_material_clay_yield_stress is missing"),
                                 ("other_law", "0,2,\n", "0,2,7\n", "material hard has no yield_stress"),
                                 ("alike", "hard,", "soft,", "two names are alike"), ("type", ",type", ",law", "must have the columns name and type"),
                                 ("range", "1e5,0,", "-1e5,0,", "-mpm_material_soft_E -1e5")):
        (folder / "table.csv").write_text(table.replace(old, new))
        run = test.run(folder / "table.yaml", status=2)
        test.check(f"table.refused.{name}", int(line in run.errors + run.output), 1)


def by_column(test):
    """Materials of points by a column of their file: masses, laws, output, restart; names, numbers and labels alike."""
    scene, first = columns(test, MATERIALS)
    state = first.results.state("last")
    test.check("column.mass", float(abs(np.bincount(state["material"], weights=state["mass"]) - [4.0, 8.0, 12.0]).max()), None, 1e-12)
    strain = state["equivalent_plastic_strain"]
    test.check("column.history", float(sum(strain[state["material"] == 2] > 0.0)), 4, 12)
    test.check("column.history.others", float(sum(strain[state["material"] != 2] != 0.0)), None, 0)
    test.check("column.weight", float(abs(reactions(first).sum() / 24.0 - 1.0)), None, 1e-6)
    by_table(test, scene, first)
    labels = {"mpm_body_block_labels": "7:soft,8:hard,9-20:clay"}
    alike = {"ranks_3": (MATERIALS, 3, "csv", {}), "numbers": ((0, "1.0", 2), 1, "csv", {}), "labels": ((7, 8, 20), 3, "csv", labels),
             "hdf5": ((0, 1, 2), 3, "h5", {}), "hdf5_labels": ((7, 8, 9), 1, "h5", labels)}
    for name, (words, ranks, kind, options) in alike.items():
        test.check(f"column.{name}", float(abs(reactions(columns(test, words, ranks, kind, **options)[1]) / reactions(first) - 1.0).max()), None, 1e-9)
    again = test.run(scene, ranks=3, mpm_restart=next(first.folder.glob("*checkpoint*1.h5")))
    test.check("column.restart", float(abs(reactions(again) / reactions(first) - 1.0).max()), None, 1e-9)
    after = test.run(scene, ranks=3, mpm_body_block_file=first.folder / "talus.h5")
    test.check("column.run", float(abs(reactions(after) / reactions(first) - 1.0).max()), None, 1e-5)
    test.check("column.run.history", float(abs(after.results.state("last")["equivalent_plastic_strain"] - strain).max()), None, 1e-8)
    _, fewer = columns(test, (3, 1, 3), mpm_body_block_labels="3:none,1:hard")
    test.check("column.none", float(len(fewer.results.state("last")["material"])), 16, 16)
    for name, words, options, line in (
            ("name", ("stone", "hard", "clay"), {}, "material stone is none of -mpm_materials"),
            ("number", (3, 1, 2), {}, "material 3 is no place in -mpm_materials"),
            ("fraction", (0.5, 1, 2), {}, "material 0.5 must be a whole number"),
            ("empty", ("", 1, 2), {}, "line 2, column material"),
            ("label", (1, 2, 3), {"mpm_body_block_labels": "1:soft,2:hard"}, "material 3 is in no entry of labels"),
            ("named_label", MATERIALS, labels, "material soft must be a whole number"),
            ("both", MATERIALS, {"mpm_body_block_material": "hard"}, "has the material soft"),
            ("labels_of_one", (1, 1, 1), {"mpm_body_block_material": "hard", **labels}, "-mpm_body_block_labels: not with -mpm_body_block_material"),
            ("choice", (1, 2, 0), {"mpm_body_block_file_material": 1}, "-mpm_body_block_file_material: needs -mpm_body_block_material"),
            ("nothing", (1, 1, 1), {"mpm_body_block_labels": "1:none"}, "no point has a material")):
        _, run = columns(test, words, 3 if name == "number" else 1, status=2, **options)
        test.check(f"column.refused.{name}", int(line in run.errors + run.output), 1)
    _, run = columns(test, (3, 1, 2), 3, "h5", status=2)
    test.check("column.refused.hdf5", int("material 3 is no place in -mpm_materials" in run.errors + run.output), 1)


def refused(test):
    scenes = {"label": (layers, {"mpm_body_stack_labels": "0:air,1:binder"}, "has the label 7"),
              "material": (layers, {"mpm_body_stack_labels": "0:air,1:binder,7:stone"}, "stone is none of -mpm_materials"),
              "size": (layers, {"mpm_body_stack_size": "2,32"}, "-mpm_body_stack_size: 2 voxels on axis x"),
              "entry": (layers, {"mpm_body_stack_labels": "air"}, "must be entries like"),
              "two": (layers, {"mpm_body_stack_labels": "0:air,1:binder,1-900:grain"}, "the label 1 is of binder and of grain"),
              "air_moves": (layers, {"mpm_time_integrator": "newmark"}, "-mpm_material_air_air: not available with inertia")}
    for name, (scene, options, words) in scenes.items():
        run = scene(test, 64, "raw", status=2, **options)
        test.check(f"refused.{name}", int(words in run.errors + run.output), 1)
    for name, options, words in (("nowhere", {"mpm_background_soft_lower": "2,0", "mpm_background_soft_upper": "3,1"}, "has the centre of no cell"),
                                 ("moves", {"mpm_time_integrator": "newmark"}, "-mpm_backgrounds: not available with inertia")):
        folder = test.folder()
        (folder / "block.yaml").write_text(block_text(2, "linear"))
        run = test.run(folder / "block.yaml", status=2, **options)
        test.check(f"refused.{name}", int(words in run.errors + run.output), 1)
    folder = test.folder()
    voxels(folder, "raw")
    with open(folder / "layers.raw", "ab") as file:
        file.write(b"more")
    (folder / "layers.yaml").write_text(LAYERS.format(h=1.0, cells=1, kind="raw"))
    run = test.run(folder / "layers.yaml", status=2)
    test.check("refused.bytes", int("has 68 bytes, and 32 voxels of 2 bytes are 64" in run.errors + run.output), 1)


with Test() as test:
    for value, exact in ((-0.05, -2.409730), (-0.1, -7.870403)):
        once = np.array(layers(test, 64, "csv", mpm_time_step=1, mpm_bc_top_value=value).results.history["reaction_top_y"])
        test.near(f"layers.{-value:g}", once[-1] * 64, exact, relative=1e-6)
    # interfaces cross the cells, in which strain varies with elements of order 3
    for cells, ranks, bounds in ((64, 3, (0.02, 0.05)), (128, 1, (0.01, 0.025))):
        moving = layers(test, cells, "csv", ranks, mpm_shape="gimp_element", mpm_order=3, mpm_body_stack_points_per_cell="4,4")
        for found, exact, bound in zip(stresses(moving, cells), (-2.409730, -7.870403), bounds):
            test.near(f"layers.moving.{cells}.{-exact:.0f}", found, exact, relative=bound)
    alike = [stresses(layers(test, 64, kind, ranks), 64) for kind, ranks in (("csv", 1), ("h5", 3), ("raw", 1))]
    test.check("layers.files", float(np.ptp(np.array(alike), axis=0).max()), None, 1e-9)
    run = layers(test, 64, "csv")
    test.check("air.written", float(len(run.results.state("last")["material"])), 64 * 4 * 7 / 8, 64 * 4 * 7 / 8)

    modulus = 100 * 0.7 / (1.3 * 0.4)
    for dim, shape in ((2, "linear"), (2, "gimp_bspline2"), (3, "linear"), (2, "bspline3"), (2, "gimp_element")):
        folder, whole, force = block(test, dim, shape)
        # half of the grid is filled, and all of it has the background
        exact = 1e-4 * np.array([0.25, 0.5, 0.75, 1.0]) * modulus * (0.5 + 0.5)
        test.check(f"background.{dim}.{shape}", abs(force - exact).max() / exact[-1], None, 1e-3)
        if dim == 2 and shape == "linear":
            _, _, split = block(test, dim, shape, ranks=3)
            test.check("background.ranks_3", abs(split - force).max() / exact[-1], None, 1e-9)
            on = test.run(folder / "block.yaml", ranks=3, mpm_restart=next(whole.folder.glob("*checkpoint*2.h5")))
            test.check("background.restart", abs(np.array(on.results.history["reaction_drawn_x"])[-1] - force[-1]) / exact[-1], None, 1e-9)

    for dim, order, ranks in ((2, 2, 3), (2, 4, 1), (3, 2, 1), (3, 3, 1)):
        test.near(f"background.{dim}.bent.{order}", doubled(test, dim, order, ranks), 2.0, relative=1e-5)

    empty, fewest = cell(test)
    air, more = cell(test, "air.yaml")
    soft, same = cell(test, "air.yaml", mpm_material_air_E=0.5e6)
    background, most = cell(test, ranks=3, **SOFT)
    for name, found, exact in (("empty", empty, (11.1688, 23.2325)), ("air", air, (11.3764, 23.6837))):
        for k in range(2):
            test.near(f"void_cell.{name}.{k}", found[k], exact[k], relative=0.01)
    test.check("void_cell.background", abs(background / soft - 1.0).max(), None, 5e-3)
    test.check("void_cell.unknowns", float(fewest < more and fewest < most), 1.0)
    unseen(test)
    by_column(test)
    refused(test)
