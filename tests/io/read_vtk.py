"""Reads the files that write_vtk.cpp has written with VTK's own readers (PyPI's vtk), and compares every number.

    python3 read_vtk.py FOLDER write_vtk      runs the program, which writes into FOLDER and prints what is there
"""
import json
import math
import pathlib
import subprocess
import sys
import urllib.parse

from vtkmodules.vtkCommonCore import vtkFileOutputWindow, vtkOutputWindow
from vtkmodules.vtkIOLegacy import vtkDataSetReader

folder = pathlib.Path(sys.argv[1])
compared = wrong = 0
opened = {}


def check(what, found, wanted):
    """Lists of numbers that must have the same bits (any NaN is as good as another)."""
    global compared, wrong
    compared += len(wanted)
    same = len(found) == len(wanted) and all(
        a == b or (isinstance(a, float) and math.isnan(a) and math.isnan(b)) for a, b in zip(found, wanted))
    if not same:
        wrong += 1
        print(f"{what}: VTK reads {found}, the program wrote {wanted}")


def data(name):
    if name not in opened:
        reader = vtkDataSetReader()
        reader.SetFileName(str(folder / name))
        reader.ReadAllFieldsOn()
        reader.Update()
        if reader.GetOutput() is None:
            sys.exit(f"{name}: VTK can't read it")
        opened[name] = reader, reader.GetOutput()
    return opened[name][1]


def numbers(array):
    return [] if array is None else [x for i in range(array.GetNumberOfTuples()) for x in array.GetTuple(i)]


def look(name, where, key, values):
    what = f"{name}, {where} {key}"
    if where == "series":
        series = json.loads((folder / name).read_text(encoding="utf-8"))  # as ParaView's readers do
        check(f"{name}, version", [float(series["file-series-version"])], [1.0])
        check(what, [item["time"] for item in series["files"]], values)
        for item in series["files"]:
            data(item["name"])
    elif where == "points":
        points = data(name).GetPoints()
        check(what, [] if points is None else numbers(points.GetData()), values)
    elif where in ("point", "cell"):
        key = urllib.parse.unquote(key)
        attributes = data(name).GetPointData() if where == "point" else data(name).GetCellData()
        if not attributes.HasArray(key):
            sys.exit(f"{what}: there is no such array")
        check(what, numbers(attributes.GetArray(key)), values)
    else:
        sys.exit(f"{what}: unknown")


def look_at_image(name, size, values):
    image = data(name)
    check(f"{name}, size", list(image.GetDimensions()), size)
    check(f"{name}, origin and spacing", [*image.GetOrigin(), *image.GetSpacing()], values)


def look_at_mesh(name, cells):
    mesh, found = data(name), []
    for k in range(mesh.GetNumberOfCells()):
        cell = mesh.GetCell(k)
        ids = [str(cell.GetPointId(i)) for i in range(cell.GetNumberOfPoints())]
        found.append(f"{mesh.GetCellType(k)}:{','.join(ids)}")
    check(f"{name}, cells", found, cells)


log = folder.parent / (folder.name + ".log")
log.unlink(missing_ok=True)
window = vtkFileOutputWindow()  # VTK's warnings and errors
window.SetFileName(str(log))
vtkOutputWindow.SetInstance(window)
program = subprocess.run(sys.argv[2:] + [str(folder)], capture_output=True, encoding="utf-8", check=True)
for line in program.stdout.splitlines():
    words = line.split(" ")
    if words[1] == "image":
        look_at_image(words[0], [int(x) for x in words[2:5]], [float.fromhex(x) for x in words[5:]])
    elif words[1] == "mesh":
        look_at_mesh(words[0], words[3:])
    elif words[1] == "cells":
        check(f"{words[0]}, vertices", [data(words[0]).GetNumberOfCells()], [int(words[3])])
    else:
        look(words[0], words[1], words[2], [float.fromhex(x) for x in words[3:]])
written = {str(path.relative_to(folder)) for path in folder.rglob("*.vtk")}
if written != set(opened):
    sys.exit(f"not looked at: {written - set(opened)}")
if log.exists() and log.read_text().strip():
    sys.exit(f"VTK complains:\n{log.read_text()}")
print(f"{len(opened)} files, {compared} numbers, {wrong} arrays differ")
sys.exit(1 if wrong or compared < 500 else 0)
