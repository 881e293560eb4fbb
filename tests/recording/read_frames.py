#!/usr/bin/python3
"""Opens the frames of a recording with h5py and with VTK, as users do, and compares them with their CSV export.

usage: read_frames.py RECORDING CSV_DIRECTORY     exit status 77: h5py, NumPy or VTK is not installed
"""
import csv
import json
import os
import sys

try:
    import h5py
    import numpy
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkCommonDataModel import VTK_POLY_VERTEX
    from vtkmodules.vtkIOHDF import vtkHDFReader
except ImportError as error:
    print(error)
    sys.exit(77)


def check(condition, what):
    if not condition:
        sys.exit(f"{current}: {what}")


def exported(path, real):
    """The columns of a CSV file: {field: array of shape (rows) or (rows, 3)}, {field: unit}."""
    with open(path, newline="") as file:
        rows = list(csv.reader(file))
    columns, units = {}, {}
    for i, title in enumerate(rows[0]):
        name, _, unit = title.partition(" [")
        field = name[:-2] if name[-2:] in ("_x", "_y", "_z") else name
        is_real = field not in ("id", "birth", "death", "group")
        values = numpy.array([row[i] for row in rows[1:]], dtype=real if is_real else numpy.uint64)
        columns.setdefault(field, []).append(values)
        units[field] = unit.rstrip("]")
    return {f: numpy.stack(c, axis=-1) if len(c) > 1 else c[0] for f, c in columns.items()}, units


def compare(values, expected, what):
    check(values.shape == expected.shape, f"{what} has shape {values.shape}, not {expected.shape}")
    check(numpy.array_equal(values, expected.astype(values.dtype)), f"{what} differs from the export")


def check_with_h5py(path, columns, units, frame):
    with h5py.File(path, "r") as file:
        check(set(file) == {"particles", "salvo", "VTKHDF"}, f"it holds {sorted(file)}")
        check(set(file["particles"]) == set(columns), "it holds other columns than the export")
        for field, expected in columns.items():
            dataset = file["particles"][field]
            compare(dataset[()], expected, field)
            check(dataset.attrs["units"].decode() == units[field], f"{field} has another unit")
            check(dataset.attrs["meaning"], f"{field} does not say what it means")
        salvo = file["salvo"].attrs
        check(salvo["time"] == frame["time"], "the series has another time")
        check(len(salvo["state_hash"]) == 32, "the state hash is not 32 digits")
        kind = h5py.h5a.open(file["VTKHDF"].id, b"Type").get_type()
        check(kind.get_cset() == h5py.h5t.CSET_ASCII, "ParaView 5.11 finds no reader unless the type is ASCII")
        check(file["VTKHDF"].get("Points", getlink=True).path == "/particles/position", "a copy of the points")


def check_with_vtk(path, columns):
    check(vtkHDFReader().CanReadFile(path), "VTK cannot read it")
    reader = vtkHDFReader()
    reader.SetFileName(path)
    reader.Update()
    grid = reader.GetOutput()
    count = len(columns["position"])
    check(grid.GetClassName() == "vtkUnstructuredGrid", f"VTK reads a {grid.GetClassName()}")
    check(grid.GetNumberOfPoints() == count, f"VTK reads {grid.GetNumberOfPoints()} points, not {count}")
    if not count:
        return  # VTK makes neither cell nor arrays of no points
    check(grid.GetNumberOfCells() == 1, f"VTK reads {grid.GetNumberOfCells()} cells")
    cell = grid.GetCell(0)
    check(cell.GetCellType() == VTK_POLY_VERTEX, "the cell is not a poly-vertex")
    ids = [cell.GetPointId(i) for i in range(cell.GetNumberOfPoints())]
    check(ids == list(range(count)), "the cell does not join all points in order")
    compare(vtk_to_numpy(grid.GetPoints().GetData()), columns["position"], "VTK's points")
    data = grid.GetPointData()
    names = {data.GetArrayName(i) for i in range(data.GetNumberOfArrays())}
    check(names == set(columns) - {"position"}, f"VTK reads the arrays {sorted(names)}")
    for field in names:
        compare(vtk_to_numpy(data.GetArray(field)), columns[field], f"VTK's {field}")


recording, csv_directory = sys.argv[1:]
with open(os.path.join(recording, "frames.hdf.series")) as file:
    series = json.load(file)["files"]
current = recording
check(series, "the series is empty")
check([f["name"] for f in series] == sorted(n for n in os.listdir(recording) if n.startswith("frame_")),
      "the series does not list the frames")
for frame in series:
    current = os.path.join(recording, frame["name"])
    with h5py.File(current, "r") as file:
        real = {b"float": numpy.float32, b"double": numpy.float64}[file["salvo"].attrs["precision"]]
    columns, units = exported(os.path.join(csv_directory, frame["name"].replace(".hdf", ".csv")), real)
    check_with_h5py(current, columns, units, frame)
    check_with_vtk(current, columns)
print(f"{len(series)} frames agree")
