#!/usr/bin/env python3
"""Opens result files in VTK as ParaView and pyvista do, and in meshio, and compares every number with what h5py reads.

    python3 -m venv vtk && vtk/bin/pip install vtk pyvista meshio h5py
    vtk/bin/python scripts/check_vtk.py out/look.xdmf out/look_grid.xdmf out/look_000010.xdmf out/look.vtkhdf ...

Every state of every index is read with vtkXdmfReader, by itself and through pyvista, and with meshio; its cells must be its
points' rows (or, of a grid, what the file says), threshold() must leave what numpy leaves, and warp_by_vector() move the
points by their displacement. A .vtkhdf file is read with vtkHDFReader and through pyvista (vtk 9.4), an index of one state
with meshio and vtkXdmfReader. Prints a line a file; exit status 1 where something differs. To be run by hand: the test suite does without VTK, see tests/verification/test_output_files.py.
In ParaView's own Python (pvpython) its Xdmf3 reader is asked too, and pyvista is not.
"""
import argparse
import sys
from pathlib import Path

import h5py
import numpy as np
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonExecutionModel import vtkStreamingDemandDrivenPipeline
from vtkmodules.vtkIOXdmf2 import vtkXdmfReader

READERS = [vtkXdmfReader]
try:
    from vtkmodules.vtkIOXdmf3 import vtkXdmf3Reader
    READERS.append(vtkXdmf3Reader)
except ImportError:  # only ParaView has it
    pass
try:
    from vtkmodules.vtkIOHDF import vtkHDFReader
except ImportError:  # before VTK 9.1
    vtkHDFReader = None
try:
    import meshio
except ImportError:
    meshio = None
try:
    import pyvista
except ImportError:  # in ParaView's own Python
    pyvista = None

FULL = [0, 3, 5, 3, 1, 4, 5, 4, 2]  # of xx, yy, zz, xy, yz, xz, row by row


class Difference(Exception):
    """What VTK shows is not what the file holds; the text says where."""


def same(seen, values):
    """Has VTK this field? Symmetric tensors have nine components there, vectors in the plane may have a zero more."""
    values = values[:, FULL] if values.shape[1:] == (6,) else values
    seen, values = seen.reshape(len(seen), -1), values.reshape(len(values), -1)
    extra = seen.shape[1] - values.shape[1]
    return extra in (0, 3 - values.shape[1]) and np.array_equal(np.pad(values, ((0, 0), (0, extra))), seen)


def stored(path):
    """{time: [fields of the points] and [fields of the nodes, cells], as far as they are there} of the index's file."""
    name = path.with_suffix(".h5")
    alone = not name.exists()
    states = {}
    with h5py.File(path.with_name(path.stem.removesuffix("_grid") + ".h5") if alone else name) as file:
        for group in file.get("grid", {}).values():
            nodes, cells = ({name: data[()] for name, data in group[part].items()} for part in ("nodes", "cells"))
            states.setdefault(group["nodes"].attrs["time"], []).append((nodes, cells["nodes"]))
        for group in () if alone else file["points"].values():
            fields = {name: data[()] for name, data in group.items()}
            rows = np.arange(len(fields["id"]))[:, None]
            states.setdefault(group.attrs["time"], []).append((fields, rows))
    return {time: meshes for time, meshes in states.items() if len(meshes[-1][1])}  # the index leaves empty ones out


def vtk_blocks(output):
    """The meshes of one time, those of the grid before those of the points."""
    if not output.IsA("vtkCompositeDataSet"):
        return [output]
    return [block for k in range(output.GetNumberOfBlocks()) for block in vtk_blocks(output.GetBlock(k))]


def compare_mesh(mesh, fields, cells):
    """One mesh of VTK against the file's fields and cells."""
    if not same(vtk_to_numpy(mesh.GetPoints().GetData()), fields["position"]):
        raise Difference("positions differ")
    if mesh.GetNumberOfCells() != len(cells):
        raise Difference(f"{mesh.GetNumberOfCells()} cells, not {len(cells)}")
    if len(cells) and not np.array_equal(vtk_to_numpy(mesh.GetCells().GetConnectivityArray()), cells.ravel()):
        raise Difference("the cells have other corners")
    data = mesh.GetPointData()
    names = {data.GetArrayName(k) for k in range(data.GetNumberOfArrays())}
    if names != set(fields) - {"id"}:
        raise Difference(f"fields {sorted(names)}, not {sorted(fields)}")
    for name in names:
        if not same(vtk_to_numpy(data.GetArray(name)), fields[name]):
            raise Difference(f"{name} differs")


def compare_threshold(mesh, fields, cells):
    """pyvista's threshold of a scalar leaves the cells that numpy leaves, with their values."""
    name = next(name for name in ("volume", "mass", "material", "position") if name in fields)
    values = fields[name].reshape(len(fields[name]), -1)[:, 0]
    if name == "position":
        mesh["x"], name = values, "x"
    level = np.median(values)
    left = mesh.threshold(level, scalars=name, all_scalars=True)
    kept = cells[np.all(values[cells] >= level, axis=1)]
    if left.n_cells != len(kept) or not np.array_equal(left[name], values[np.unique(kept)]):
        raise Difference(f"threshold() of {name} leaves {left.n_cells} cells, not {len(kept)}")


def compare_warp(mesh, fields):
    """pyvista moves points by their displacement, or by another vector."""
    name = next((name for name in ("displacement", "displacement_increment") if name in fields), None)
    if name is None:
        return
    mesh["warp"] = np.pad(fields[name], ((0, 0), (0, 3 - fields[name].shape[1])))
    wanted = mesh.points + mesh["warp"]
    if not np.allclose(mesh.warp_by_vector("warp").points, wanted, rtol=1e-6, atol=1e-6 * np.abs(wanted).max()):
        raise Difference(f"warp_by_vector() of {name}")


def check_filters(mesh, fields, cells):
    if pyvista:
        compare_threshold(pyvista.wrap(mesh), fields, cells)
        compare_warp(pyvista.wrap(mesh), fields)


def check_meshio(path, states):
    """The states of an index in meshio: geometry of the first, fields of all; the points are the last collection."""
    with meshio.xdmf.TimeSeriesReader(path) as reader:
        points, cells = reader.read_points_cells()
        meshes = [meshes[-1] for _, meshes in sorted(states.items())]
        if not np.array_equal(points, meshes[0][0]["position"]) or not np.array_equal(cells[0].data, meshes[0][1]):
            raise Difference("meshio: points or cells differ")
        if reader.num_steps != len(states):
            raise Difference(f"meshio: {reader.num_steps} states, not {len(states)}")
        for k, (time, (fields, _)) in enumerate(zip(sorted(states), meshes)):
            seen, data, _ = reader.read_data(k)
            compare_meshio(f"state {k}", data, fields)
            if seen != time:
                raise Difference(f"meshio: time {seen}, not {time}")


def compare_meshio(label, data, fields):
    if set(data) != set(fields) - {"id"}:
        raise Difference(f"meshio: {label} has {sorted(data)}, not {sorted(fields)}")
    for name, values in data.items():
        if not same(values, fields[name]):
            raise Difference(f"meshio: {label}: {name} differs")


def check_alone(path):
    """The index of one state, PREFIX_000010.xdmf or PREFIX_grid_000010.xdmf."""
    head, step = path.stem.rsplit("_", 1)
    grid = head.endswith("_grid") and not path.with_name(head + ".h5").exists()
    with h5py.File(path.with_name(head.removesuffix("_grid") + ".h5" if grid else head + ".h5")) as file:
        group = file["grid"][step]["nodes"] if grid else file["points"][step]
        fields = {name: data[()] for name, data in group.items()}
        cells = file["grid"][step]["cells"]["nodes"][()] if grid else np.arange(len(fields["id"]))[:, None]
    for reader in readers(path):
        reader.Update()
        (mesh,) = vtk_blocks(reader.GetOutputDataObject(0))
        compare_mesh(mesh, fields, cells)
        check_filters(mesh, fields, cells)
    if meshio:
        mesh = meshio.read(path)
        compare_meshio("the state", mesh.point_data, fields)
        if not np.array_equal(mesh.points, fields["position"]) or not np.array_equal(mesh.cells[0].data, cells):
            raise Difference("meshio: points or cells differ")
    return {0.0: [(fields, cells)]}


def check_hdf(path):
    """All states of the VTKHDF file, each with its fields or zeros; filters by pyvista."""
    states = stored(path.with_suffix(".xdmf"))
    points = {time: meshes[-1] for time, meshes in states.items()}
    names = set().union(*(fields for fields, _ in points.values()))
    reader = vtkHDFReader()
    reader.SetFileName(str(path))
    reader.UpdateInformation()
    times = reader.GetOutputInformation(0).Get(vtkStreamingDemandDrivenPipeline.TIME_STEPS())
    if sorted(times) != sorted(points):
        raise Difference(f"times {times}, not {sorted(points)}")
    for time, (fields, cells) in points.items():
        reader.UpdateTimeStep(time)
        mesh = reader.GetOutputDataObject(0)
        seen = {name: vtk_to_numpy(mesh.GetPointData().GetArray(name)) for name in names - {"position"}}
        if mesh.GetNumberOfVerts() != len(cells) or not same_plain(vtk_to_numpy(mesh.GetPoints().GetData()), fields["position"]):
            raise Difference(f"points at time {time:g}")
        for name, values in seen.items():
            if not (same_plain(values, fields[name]) if name in fields else not values.any()):
                raise Difference(f"{name} at time {time:g}")
        check_filters(mesh, fields, cells)
    if pyvista:
        check_filters(pyvista.read(path), *points[min(points)])  # the first state, where nobody asks for another
    return {time: [mesh] for time, mesh in points.items()}


def same_plain(seen, values):
    """Symmetric tensors keep their six components there."""
    seen, values = seen.reshape(len(seen), -1), values.reshape(len(values), -1)
    return np.array_equal(np.pad(values, ((0, 0), (0, seen.shape[1] - values.shape[1]))), seen)


def check_reader(reader, states):
    """Every state, read by VTK's own pipeline."""
    reader.UpdateInformation()
    times = reader.GetOutputInformation(0).Get(vtkStreamingDemandDrivenPipeline.TIME_STEPS()) or ()
    if len(states) > 1 and sorted(times) != sorted(states):
        raise Difference(f"times {times}, not {sorted(states)}")
    for time, wanted in states.items():
        reader.UpdateTimeStep(time)
        blocks = vtk_blocks(reader.GetOutputDataObject(0))
        if len(blocks) != len(wanted):
            raise Difference(f"{len(blocks)} meshes at time {time:g}, not {len(wanted)}")
        for mesh, (fields, cells) in zip(blocks, wanted):
            compare_mesh(mesh, fields, cells)
            check_filters(mesh, fields, cells)


def check_pyvista(path, states):
    """The last state as a user of pyvista reads it."""
    reader = pyvista.get_reader(path)
    if len(states) > 1:
        reader.set_active_time_value(max(states))
    meshes = vtk_blocks(reader.read())
    for mesh, (fields, cells) in zip(meshes, states[max(states)], strict=True):
        compare_mesh(mesh, fields, cells)
        check_filters(mesh, fields, cells)


def readers(path):
    for kind in READERS:
        reader = kind()
        if hasattr(reader, "AddFileName"):
            reader.AddFileName(str(path))
        reader.SetFileName(str(path))
        yield reader


def check(path):
    if path.suffix == ".vtkhdf":
        return check_hdf(path)
    if path.stem[-6:].isdigit() and not path.with_suffix(".h5").exists():
        return check_alone(path)
    states = stored(path)
    for reader in readers(path):
        check_reader(reader, states)
    if pyvista:
        check_pyvista(path, states)
    if meshio:
        check_meshio(path, states)
    return states


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("index", nargs="+", type=Path, help="PREFIX.xdmf, PREFIX_grid.xdmf, PREFIX_000010.xdmf, PREFIX.vtkhdf")
    failures = 0
    for path in parser.parse_args().index:
        path = path.resolve()  # Xdmf3 finds the HDF5 file only so
        try:
            states = check(path)
            cells = [len(meshes[-1][1]) for meshes in states.values()]
            print(f"{path}: {len(states)} states, {min(cells)} to {max(cells)} cells")
        except Difference as difference:
            print(f"{path}: {difference}")
            failures += 1
    return int(failures > 0)


if __name__ == "__main__":
    sys.exit(main())
