"""Reads surfaces from VTK files, legacy .vtk and XML .vtp, with VTK itself."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from palpate.base.errors import MeshError, MissingExtraError
from palpate.world.mesh import headers

ENDINGS = (".vtk", ".vtp")


def read(path: Path, data: bytes) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.int64]]:
    """Vertices (n, 3) in the file's unit and triangles (m, 3) of a file with polygons, or of a volume's outside.

    Args:
        path: the file.
        data: its bytes.

    Raises:
        MeshError: the file is not VTK. MissingExtraError: the extra `vtk` is not installed.
    """
    try:
        headers.require(path, data)
    except ValueError as error:
        what = f"not a readable {path.suffix} file"
        raise MeshError(what, where=str(path), why=str(error), mend="export it again") from None
    try:
        from vtkmodules.util.numpy_support import vtk_to_numpy
        from vtkmodules.vtkCommonCore import vtkObject
        from vtkmodules.vtkFiltersCore import vtkTriangleFilter
        from vtkmodules.vtkFiltersGeometry import vtkGeometryFilter
        from vtkmodules.vtkIOLegacy import vtkGenericDataObjectReader
        from vtkmodules.vtkIOXML import vtkXMLPolyDataReader
    except ImportError:
        raise MissingExtraError(f"the reader of {path.suffix} files", "vtk") from None
    numbers: Any = vtk_to_numpy  # the library has no types
    vtkObject.GlobalWarningDisplayOff()  # its messages go to the terminal; a damaged file has no triangles
    reader: Any = vtkXMLPolyDataReader() if path.suffix.lower() == ".vtp" else vtkGenericDataObjectReader()
    outside, triangles = vtkGeometryFilter(), vtkTriangleFilter()
    reader.SetFileName(str(path))
    reader.Update()
    if reader.GetOutputDataObject(0) is None or not reader.GetOutputDataObject(0).IsA("vtkDataSet"):
        raise MeshError(f"not a readable {path.suffix} file", where=str(path), mend="export it again as a surface")
    outside.SetInputConnection(reader.GetOutputPort())
    triangles.SetInputConnection(outside.GetOutputPort())
    triangles.PassVertsOff()
    triangles.PassLinesOff()
    triangles.Update()
    output = triangles.GetOutput()
    if output.GetPoints() is None:
        return np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int64)
    points = np.asarray(numbers(output.GetPoints().GetData()), dtype=np.float64)
    corners = np.asarray(numbers(output.GetPolys().GetConnectivityArray()), dtype=np.int64)
    return points, corners.reshape(-1, 3)
