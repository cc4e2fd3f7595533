#!/usr/bin/env python3
"""Import of drawings, meshes, terrain and boreholes: files that this test writes become bodies whose areas and volumes are those drawn,
in scenes that `talus check` passes; wrong files end with one line, and so does a library that is missing.
"""
import sys
from pathlib import Path

import numpy as np
import yaml

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import ENVIRONMENT, Test, call  # noqa: E402

PACKAGE = Path(__file__).resolve().parent.parent.parent / "python" / "src"
sys.path.insert(0, str(PACKAGE))
FRAME = """mpm:
  dim: {dim}
  grid: {{lower: "{lower}", upper: "{upper}", cells: "{cells}"}}
  time: {{end: 1, step: 1}}
  bcs: base
  bc_base: {{region: box, lower: "{lower}", upper: "{upper}", components: "{components}"}}
{materials}"""


def convert(test, path, *words):
    """python -m talus import; the blocks that it wrote."""
    done = call([sys.executable, "-m", "talus", "import", path.name, *words], path.parent)
    test.check(f"{path.name}.status", done.returncode, 0, 0)
    scene = path.with_suffix(".yaml")
    if done.returncode:
        sys.exit(done.stderr)
    test.check(f"{path.name}.picture", path.with_suffix(".png").stat().st_size, 5000)
    return scene, yaml.safe_load(scene.read_text(encoding="utf-8"))["mpm"]


def check_scene(test, scene, blocks, lower, upper, cells, sizes):
    """Volumes of the bodies by `talus check`."""
    dim = len(lower)
    materials = "".join(f"  material_{name}: {{type: hencky, E: 1e7, nu: 0.3, density: 1800}}\n" for name in blocks["materials"].split(","))
    frame = scene.parent / "frame.yaml"
    frame.write_text(FRAME.format(dim=dim, lower=",".join(map(str, lower)), upper=",".join(map(str, upper)),
                                  cells=",".join(map(str, cells)), components=",".join("xyz"[:dim]), materials=materials), encoding="utf-8")
    done = call([test.program, "check", scene.name, frame.name], scene.parent)
    test.check(f"{scene.stem}.check", done.returncode, 0, 0)
    if done.returncode:
        print(done.stderr)
    found = {line.split()[1]: float(line.split("points, ")[1].split()[0]) for line in done.stdout.splitlines() if line.startswith("body ")}
    test.check(f"{scene.stem}.bodies", int(sorted(found) == sorted(sizes)), 1, 1)
    for name, size in sizes.items():
        test.near(f"{scene.stem}.{name}", found.get(name, 0.0), size, relative=4e-4)


def check_dxf(test, folder):
    import ezdxf
    drawing = ezdxf.new()
    space = drawing.modelspace()
    space.add_circle((4, 2), 1, dxfattribs={"layer": "pipe"})
    space.add_lwpolyline([(0, 0), (10, 0), (10, 2), (7, 4), (0, 4), (0, 0)], dxfattribs={"layer": "Sand 1"})
    space.add_lwpolyline([(0, 4), (0, 6), (3, 6), (5, 4)], close=True, dxfattribs={"layer": "Sand 1"})
    space.add_line((0, 0), (1, 1))
    drawing.saveas(folder / "section.dxf")
    scene, blocks = convert(test, folder / "section.dxf", "--tolerance", "0.0001")
    names = blocks["bodies"].split(",")
    test.check("dxf.materials", int(blocks["materials"] == "pipe,Sand_1"), 1, 1)
    test.check("dxf.bodies", int(names == ["pipe", "Sand_1", "Sand_1_2", "Sand_1_3"]), 1, 1)
    check_scene(test, scene, blocks, (0, 0), (10, 7), (20, 14),
                {"pipe": np.pi, "Sand_1": 16 - np.pi / 2, "Sand_1_2": 21 - np.pi / 2, "Sand_1_3": 8})


def check_mesh(test, folder):
    import meshio
    x, y = np.meshgrid(np.linspace(0, 4, 5), np.linspace(0, 2, 3))
    quads = np.array([(k, k + 1, k + 6, k + 5) for k in (0, 1, 2, 3, 5, 6, 7, 8)])
    tags = [np.array([1, 1, 1, 1, 2, 2, 2, 2])]
    meshio.write_points_cells(folder / "flat.msh", np.stack([x.ravel(), y.ravel(), 0 * x.ravel()], 1), [("quad", quads)],
                              cell_data={"gmsh:physical": tags, "gmsh:geometrical": tags}, field_data={"clay": np.array([1, 2]), "fill": np.array([2, 2])},
                              file_format="gmsh22", binary=False)
    scene, blocks = convert(test, folder / "flat.msh")
    check_scene(test, scene, blocks, (0, 0), (4, 3), (8, 6), {"clay": 4, "fill": 4})
    corners = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1), (0.5, 0.5, 2)], float)
    meshio.write_points_cells(folder / "solid.vtk", corners, [("hexahedron", [range(8)]), ("pyramid", [[4, 5, 6, 7, 8]])])
    scene, blocks = convert(test, folder / "solid.vtk")
    check_scene(test, scene, blocks, (0, 0, 0), (2, 2, 3), (2, 2, 3), {"body": 1 + 1 / 3})


def check_terrain(test, folder):
    from osgeo import gdal, osr
    data = gdal.GetDriverByName("GTiff").Create(str(folder / "hill.tif"), 40, 20, 1, gdal.GDT_Float64)
    data.SetGeoTransform((100, 1, 0, 50, 0, -1))
    plane = osr.SpatialReference()
    plane.ImportFromEPSG(32632)
    data.SetProjection(plane.ExportToWkt())
    x, y = np.meshgrid(100.5 + np.arange(40), 49.5 - np.arange(20))
    data.GetRasterBand(1).WriteArray(2 + 0.1 * (x - 100) + 0.05 * (y - 30))
    data = None
    scene, blocks = convert(test, folder / "hill.tif", "--start", "105,35", "--end", "135,45")
    length = np.hypot(30, 10)
    check_scene(test, scene, blocks, (0, 0), (round(float(length), 6), 8), (32, 8), {"ground": length * (2.75 + 6.25) / 2})
    outside = call([sys.executable, "-m", "talus", "import", "hill.tif", "--start", "0,0", "--end", "1,1"], folder)
    test.check("terrain.outside", int(outside.returncode == 2 and "the profile leaves the map" in outside.stderr), 1, 1)


def check_boreholes(test, folder):
    rows = ["A;0;10;8,5;fill", "A;0;8,5;3;clay", "A;0;3;0;rock", "B;20;9;6;clay", "B;20;6;1;gravel", "B;20;1;0;rock", "C;40;12;10;fill",
            "C;40;10;4;clay", "C;40;4;0;rock"]
    (folder / "holes.csv").write_text("name;x;top;bottom;material\n" + "\n".join(rows) + "\n", encoding="utf-8")
    scene, blocks = convert(test, folder / "holes.csv")
    test.check("boreholes.order", int(blocks["bodies"] == "fill,clay,gravel,rock"), 1, 1)
    check_scene(test, scene, blocks, (0, 0), (40, 13), (40, 13),
                {"fill": 10 * 1.5 + 10 * 2, "clay": 10 * 8.5 + 10 * 9, "gravel": 10 * 5 + 10 * 5, "rock": 10 * 4 + 10 * 5})


def check_faults(test, folder):
    (folder / "bad.csv").write_text("name,x,top,material\nA,0,1,clay\n", encoding="utf-8")
    (folder / "gap.csv").write_text("name,x,top,bottom,material\nA,0,5,3,clay\nA,0,2,1,sand\n", encoding="utf-8")
    (folder / "swap.csv").write_text("name,x,top,bottom,material\nA,0,5,3,clay\nA,0,3,1,sand\nB,9,5,3,sand\nB,9,3,1,clay\n", encoding="utf-8")
    (folder / "bad.dxf").write_text("no drawing\n", encoding="utf-8")
    (folder / "bad.msh").write_text("no mesh\n", encoding="utf-8")
    (folder / "bad.tif").write_text("no map\n", encoding="utf-8")
    faults = {"none.dxf": "there is no such file", "bad.csv": "has no column bottom", "gap.csv": "line 3: a layer must begin where",
              "swap.csv": "name the layers apart", "bad.dxf": "is no DXF file", "bad.msh": "meshio cannot read it", "bad.tif": "GDAL cannot read it"}
    code = f"from talus.__main__ import main\nfor name in {list(faults)}: print(main(['import', name]))"
    done = call([sys.executable, "-c", code], folder)
    lines = [line for line in done.stderr.splitlines() if line.startswith("talus: error: ")]
    test.check("faults.status", int(done.stdout.split()[-len(faults):] == ["2"] * len(faults) and len(lines) == len(faults)), 1, 1)
    for (name, error), line in zip(faults.items(), lines):
        test.check(f"fault.{name}", int(error in line), 1, 1)
    code = "import sys; sys.modules['ezdxf'] = None; from talus.__main__ import main; sys.exit(main(['import', 'bad.dxf']))"
    done = call([sys.executable, "-c", code], folder)
    test.check("fault.library", int(done.stderr.strip() == "talus: error: import needs ezdxf: install python3-ezdxf (Debian), or ezdxf by pip"), 1, 1)


with Test() as test:
    ENVIRONMENT.update(TALUS=str(test.program), PYTHONPATH=str(PACKAGE))
    for check in (check_dxf, check_mesh, check_terrain, check_boreholes, check_faults):
        check(test, test.folder())
