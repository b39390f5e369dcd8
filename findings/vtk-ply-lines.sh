#!/bin/sh
# Guess: a line of bone with a confidence for each point survives in a PLY file that VTK reads or writes.
# Seen, vtk 9.7.2: the reader drops edges and every attribute of a point but normals, colours and texture coordinates: 3
# points, no cell, so nothing is drawn. The writer drops lines and arrays as well. Neither warns.
# Why it matters: Slicer and ParaView show nothing of a surface given as points and edges; a legacy .vtk or a .vtp keeps both.
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m venv venv
venv/bin/pip install --quiet --disable-pip-version-check vtk==9.7.2
venv/bin/python - <<'PY'
import vtk

with open("line.ply", "w") as file:
    file.write(
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
        "property float confidence\nelement edge 2\nproperty int vertex1\nproperty int vertex2\nend_header\n"
        "0 0 0 0.25\n1 0 0 0.5\n2 0 0 0.75\n0 1\n1 2\n"
    )
reader = vtk.vtkPLYReader()
reader.SetFileName("line.ply")
reader.Update()
read = reader.GetOutput()
print("read:", read.GetNumberOfPoints(), "points,", read.GetNumberOfCells(), "cells,", read.GetPointData().GetNumberOfArrays(), "arrays")
assert (read.GetNumberOfPoints(), read.GetNumberOfCells(), read.GetPointData().GetNumberOfArrays()) == (3, 0, 0)

points, lines, confidence = vtk.vtkPoints(), vtk.vtkCellArray(), vtk.vtkFloatArray()
confidence.SetName("confidence")
lines.InsertNextCell(3)
for k in range(3):
    points.InsertNextPoint(k, 0, 0)
    lines.InsertCellPoint(k)
    confidence.InsertNextValue(0.25 * (k + 1))
surface = vtk.vtkPolyData()
surface.SetPoints(points)
surface.SetLines(lines)
surface.GetPointData().AddArray(confidence)
writer = vtk.vtkPLYWriter()
writer.SetFileName("written.ply")
writer.SetFileTypeToASCII()
writer.SetInputData(surface)
writer.Write()
head = open("written.ply").read().split("end_header")[0]
print(head)
assert "element face 0" in head and "edge" not in head and "confidence" not in head

writer = vtk.vtkPolyDataWriter()
writer.SetFileName("written.vtk")
writer.SetInputData(surface)
writer.Write()
reader = vtk.vtkPolyDataReader()
reader.SetFileName("written.vtk")
reader.Update()
assert reader.GetOutput().GetNumberOfLines() == 1 and reader.GetOutput().GetPointData().GetArray("confidence")
PY
