#!/bin/sh
# A line of bone as .ply with edges and a confidence of each point. VTK 9.7.2, the reader of ParaView and Slicer.
#
# Guess: elements and properties that PLY declares arrive as lines and arrays of points.
# Seen: the points arrive alone. Edges make no cell, so that nothing is shown, and the property confidence is dropped,
# without a warning. The same line as .vtp keeps both.
# Matters: a surface of an ultrasound frame is a line; exported as .ply it looks like an empty file.
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m venv env
env/bin/pip install --quiet --disable-pip-version-check vtk==9.7.2
env/bin/python - <<'END'
from vtkmodules.vtkCommonCore import vtkFloatArray, vtkPoints
from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData
from vtkmodules.vtkIOPLY import vtkPLYReader
from vtkmodules.vtkIOXML import vtkXMLPolyDataReader, vtkXMLPolyDataWriter

points = [(0, 0, 10, 0.5), (1, 0, 11, 0.9), (2, 0, 12, 0.25)]
head = ['ply', 'format ascii 1.0', 'element vertex 3']
head += [f'property float {name}' for name in ('x', 'y', 'z', 'confidence')]
head += ['element edge 2', 'property int vertex1', 'property int vertex2', 'end_header']
rows = [' '.join(map(str, point)) for point in points] + ['0 1', '1 2']
open('line.ply', 'w').write('\n'.join(head + rows) + '\n')

line, places, confidence, cells = vtkPolyData(), vtkPoints(), vtkFloatArray(), vtkCellArray()
confidence.SetName('confidence')
cells.InsertNextCell(len(points))
for k, point in enumerate(points):
    cells.InsertCellPoint(places.InsertNextPoint(point[:3]))
    confidence.InsertNextValue(point[3])
line.SetPoints(places), line.SetLines(cells), line.GetPointData().AddArray(confidence)
writer = vtkXMLPolyDataWriter()
writer.SetFileName('line.vtp'), writer.SetInputData(line), writer.Write()

found = {}
for name, reader in (('line.ply', vtkPLYReader()), ('line.vtp', vtkXMLPolyDataReader())):
    reader.SetFileName(name), reader.Update()
    read = reader.GetOutput()
    found[name] = (read.GetNumberOfPoints(), read.GetNumberOfCells(), read.GetPointData().GetNumberOfArrays())
    print(name, 'points, cells, arrays of points:', *found[name])
assert found == {'line.ply': (3, 0, 0), 'line.vtp': (3, 1, 1)}
END
