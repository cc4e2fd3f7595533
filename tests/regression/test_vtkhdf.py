#!/usr/bin/env python3
"""PREFIX.vtkhdf: its arrays are those of PREFIX.h5 at every state, in 2D and 3D, with bodies that come and go, on one rank and
several, of runs that end, go on or give up; and all that the format asks for is there. Where vtk 9.4 or later is installed
its reader must find the states, too. The XDMF indices of all states and of single ones open in meshio."""
import os
import sys
from pathlib import Path

import h5py
import meshio
import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import ROOT, Run, Test, example  # noqa: E402

try:
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkCommonCore import vtkVersion
    from vtkmodules.vtkCommonExecutionModel import vtkStreamingDemandDrivenPipeline
    from vtkmodules.vtkIOHDF import vtkHDFReader
    READS = (vtkVersion.GetVTKMajorVersion(), vtkVersion.GetVTKMinorVersion()) >= (9, 4)
except ImportError:
    READS = False

CELLS = ("Vertices", "Lines", "Polygons", "Strips")


def padded(array):
    """Vectors in the plane with their third component."""
    return np.pad(array, ((0, 0), (0, 1))) if array.ndim == 2 and array.shape[1] == 2 else array


def read_states(file):
    """The states of a results file by ascending step: time, and arrays by name."""
    groups = sorted(file["points"].values(), key=lambda group: group.attrs["step"])
    return [(group.attrs["time"], {name: padded(array[:]) for name, array in group.items()}) for group in groups]


def check_format(test, label, root, states):
    """Attributes and datasets of the format with their types and sizes."""
    counts = [len(fields["id"]) for _, fields in states]
    kind = root.attrs.get_id("Type")
    test.check(f"{label}.type", int(root.attrs["Type"] == b"PolyData" and kind.dtype == "S8"
                                    and kind.get_type().get_cset() == h5py.h5t.CSET_ASCII), 1)
    test.check(f"{label}.version", int(list(root.attrs["Version"]) == [2, 0]), 1)
    steps, wrong = root["Steps"], []
    test.check(f"{label}.steps", int(steps.attrs["NSteps"]), len(states), len(states))
    first = np.cumsum([0, *counts[:-1]])
    four = np.zeros((len(states), 4))
    wanted = {"NumberOfPoints": counts, "Steps/PartOffsets": range(len(states)), "Steps/NumberOfParts": np.ones(len(states)),
              "Steps/PointOffsets": first, "Steps/CellOffsets": four, "Steps/ConnectivityIdOffsets": four,
              "Vertices/Offsets": range(max(counts) + 1), "Vertices/Connectivity": range(max(counts)),
              **{f"{cells}/{name}": counts if cells == "Vertices" else np.zeros(len(states))
                 for cells in CELLS for name in ("NumberOfCells", "NumberOfConnectivityIds")},
              **{f"{cells}/Offsets": [0] for cells in CELLS[1:]}, **{f"{cells}/Connectivity": [] for cells in CELLS[1:]},
              **{f"Steps/PointDataOffsets/{name}": first for name in root["PointData"]}}
    for path, values in wanted.items():
        if root[path].dtype.kind != "i" or not np.array_equal(root[path][:], values):
            wrong.append(path)
    test.check(f"{label}.wrong_{'_'.join(wrong)}", len(wrong), None, 0)
    test.check(f"{label}.times", int(np.array_equal(steps["Values"][:], [time for time, _ in states])), 1)


def check_arrays(test, label, root, states):
    """Virtual datasets whose rows are the states' own; 0 where a state is without the field."""
    data = {**root["PointData"], "position": root["Points"]}
    names = set().union(*(fields for _, fields in states))
    test.check(f"{label}.fields", len(names ^ set(data)), None, 0)
    test.check(f"{label}.stored", sum(not array.is_virtual for array in data.values()), None, 0)
    sources = {source.file_name for array in data.values() for source in array.virtual_sources()}
    test.check(f"{label}.absolute", sum("/" in source for source in sources), None, 0)
    wrong = 0
    for name, array in data.items():
        first = 0
        for _, fields in states:
            rows = array[first:first + len(fields["id"])]
            first += len(rows)
            wrong += not (rows.dtype == fields[name].dtype and np.array_equal(rows, fields[name]) if name in fields
                          else not rows.any())
        wrong += first != len(array)
    test.check(f"{label}.wrong_arrays", wrong, None, 0)


def check_reader(test, label, path, states):
    """Times, points and arrays as VTK reads them."""
    reader = vtkHDFReader()
    reader.SetFileName(path)
    reader.UpdateInformation()
    times = reader.GetOutputInformation(0).Get(vtkStreamingDemandDrivenPipeline.TIME_STEPS())
    test.check(f"{label}.vtk_times", int(list(times) == [time for time, _ in states]), 1)
    wrong = 0
    for k, (_, fields) in enumerate(states):
        reader.SetStep(k)
        reader.Update()
        mesh = reader.GetOutputDataObject(0)
        data = mesh.GetPointData()
        wrong += mesh.GetNumberOfVerts() != len(fields["id"])
        wrong += not np.array_equal(vtk_to_numpy(mesh.GetPoints().GetData()), fields["position"])
        wrong += sum(not np.array_equal(vtk_to_numpy(data.GetArray(name)), array) for name, array in fields.items()
                     if name != "position")
    test.check(f"{label}.vtk_wrong", wrong, None, 0)


def full(array):
    """Symmetric tensors with nine components, as the XDMF index has them."""
    return array[:, [0, 3, 5, 3, 1, 4, 5, 4, 2]] if array.shape[1:] == (6,) else array


def differ(data, fields):
    """Fields of meshio's that are not the file's."""
    return len(set(data) ^ (set(fields) - {"id"})) + sum(not np.array_equal(full(fields[name]), values)
                                                         for name, values in data.items() if name in fields)


def check_meshio(test, label, run):
    """All states of an index, and the index of each; meshio writes what it has read."""
    with h5py.File(run.prefix + ".h5") as file:
        for suffix, groups in (("", file["points"]), ("_grid", {step: group["nodes"] for step, group in file["grid"].items()})):
            states = {step: {name: array[:] for name, array in group.items()} for step, group in groups.items()}
            wrong = unlike = 0
            with meshio.xdmf.TimeSeriesReader(f"{run.prefix}{suffix}.xdmf") as reader:
                points, cells = reader.read_points_cells()
                wrong += not np.array_equal(points, next(iter(states.values()))["position"]) or cells[0].data.max() >= len(points)
                wrong += reader.num_steps != len(states)
                for k, (step, fields) in enumerate(states.items()):
                    time, data, _ = reader.read_data(k)
                    wrong += time != groups[step].attrs["time"] or differ(data, fields) > 0
            for step, fields in states.items():
                mesh = meshio.read(f"{run.prefix}{suffix}_{step}.xdmf")
                corners = file["grid"][step]["cells"]["nodes"] if suffix else np.arange(len(fields["id"]))[:, None]
                unlike += differ(mesh.point_data, fields) > 0 or not np.array_equal(mesh.points, fields["position"])
                unlike += not np.array_equal(mesh.cells[0].data, corners)
            test.check(f"{label}{suffix}.meshio_series", wrong, None, 0)
            test.check(f"{label}{suffix}.meshio_state", unlike, None, 0)
            mesh.write(run.folder / "again.vtk")
            test.check(f"{label}{suffix}.meshio_again", len(meshio.read(run.folder / "again.vtk").points), len(mesh.points), len(mesh.points))


def check(test, label, run, least):
    """The file of a run that has written so many states at least."""
    path = run.prefix + ".vtkhdf"
    with h5py.File(run.prefix + ".h5") as file:
        states = read_states(file)
    test.check(f"{label}.states", len(states), least)
    with h5py.File(path) as file:
        check_format(test, label, file["VTKHDF"], states)
        check_arrays(test, label, file["VTKHDF"], states)
    if READS:
        check_reader(test, label, path, states)
    return os.path.getsize(path) / os.path.getsize(run.prefix + ".h5")


def main():
    with Test() as test:
        dig = ROOT / "tests" / "verification" / "dig.yaml"
        for ranks in (1, 3):
            plane = test.run(example("collapse"), ranks=ranks, mpm_quiet=None)
            test.check(f"plane_on_{ranks}.share", check(test, f"plane_on_{ranks}", plane, 5), None, 0.02)
            stages = test.run(dig, ranks=ranks, mpm_quiet=None, mpm_output_prefix="50%b", mpm_output_grid="true",
                              mpm_output_state_files="true")
            check(test, f"stages_on_{ranks}", stages, 6)
            check_meshio(test, f"stages_on_{ranks}", stages)
        check(test, "space", test.run(example("slump3d"), ranks=2, mpm_time_end=0.1, mpm_output_every=1,
                                      mpm_output_precision="single", mpm_quiet=None), 3)

        half = test.run(dig, mpm_checkpoint_every=1, mpm_checkpoint_keep=9, mpm_quiet=None)
        rest = Run(test.program, dig, 1, {"mpm_restart": half.prefix + "_checkpoint_000002.h5", "mpm_quiet": None}, half.folder)
        test.check("restart.status", rest.status, 0, 0)
        check(test, "restart", rest, 6)
        gone = test.run(example("collapse"), status=3, mpm_time_step=0.1, mpm_time_step_min=0.09, snes_max_it=4,
                        mpm_quiet=None)
        check(test, "gave_up", gone, 1)

        off = Run(test.program, dig, 1, {"mpm_output_every": 0, "mpm_quiet": None}, test.folder())
        test.check("off.files", sum(name.endswith(".vtkhdf") for name in off.files), None, 0)
        test.check("off.state_files", sum(name[-11:-5].isdigit() for name in half.files if name.endswith(".xdmf")), None, 0)
        again = Run(test.program, dig, 1, {"mpm_output_fields": "stress", "mpm_quiet": None}, half.folder)
        check(test, "again", again, 6)


main()
