"""Reading and writing of mesh files: STL with numpy, volumes and VTK in their modules, other formats with trimesh."""

from __future__ import annotations

import difflib
import importlib.util
import re
import warnings
from pathlib import Path

import numpy as np
import numpy.typing as npt

from palpate.base import limits
from palpate.base.arrays.checks import is_number
from palpate.base.errors import MeshError, MissingExtraError, OutputError, PalpateWarning
from palpate.world.mesh import headers, off_file, ply_elements, volumes, vtk_file

_HEADER, _FACET = 84, np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
_VERTEX = re.compile(rb"\bvertex\s+(\S+)\s+(\S+)\s+(\S+)")
_OTHER_FORMATS = (".obj", ".ply", ".off", ".glb", ".gltf", ".3mf", ".dae")
_PACKAGES = {".3mf": ("networkx", "lxml"), ".dae": ("collada",)}  # with which trimesh reads these formats
_UNIT_NAMES = {"millimeter": "mm", "centimeter": "cm", "meter": "m", "inch": "in", "inche": "in"}

#: Endings of all files that `read` reads.
FORMATS = (".stl", *_OTHER_FORMATS, *vtk_file.ENDINGS, *volumes.ENDINGS)

_CONVERTERS = (
    ((".dcm", ".ima"), "a series of DICOM files becomes one volume by: dcm2niix -z y FOLDER, or by 3D Slicer"),
    ((".mgz", ".mgh"), "mri_convert IN.mgz OUT.nii.gz (FreeSurfer) converts it"),
    ((".img", ".hdr", ".mnc"), "save it as NIfTI (.nii.gz), e.g. by 3D Slicer or SimpleITK.WriteImage"),
    ((".vti", ".vts", ".vtr"), "save a volume as .nrrd or .mha, e.g. by 3D Slicer or ParaView"),
    ((".step", ".stp", ".igs", ".iges", ".brep"), "export its surface as STL, e.g. by FreeCAD or gmsh"),
    ((".blend", ".fbx", ".3ds", ".wrl", ".x3d", ".usd", ".usdz"), "export it as STL, PLY or OBJ, e.g. by Blender"),
    ((".pcd", ".xyz", ".e57", ".las"), "points are no mesh: cloud: FILE in a scene (.pcd, .ply, .xyz, .npz)"),
    ((".vtu", ".msh", ".mesh", ".meshb"), "tetrahedra are read as tissue: volume: FILE; a surface: save it as STL"),
)
"""Mends for formats that are not read, by ending."""

Soup = tuple[npt.NDArray[np.floating], npt.NDArray[np.integer]]


def read(path: Path) -> Soup:
    """Vertices (n, 3) in the file's unit and triangles (m, 3) of a mesh file.

    Raises:
        MeshError: the file is missing, empty, truncated or not a mesh; the message names the remedy.
    """
    vertices, triangles, _ = read_with_unit(path)
    return vertices, triangles


def read_with_unit(
    path: Path, selection: volumes.Selection | None = None
) -> tuple[npt.NDArray[np.floating], npt.NDArray[np.integer], str]:
    """As `read`, with the unit that the file or its format states: ``m`` for glTF; empty if it states none.

    Args:
        path: the file.
        selection: label or threshold of a volume.

    Raises:
        MeshError: as for `read`. MissingExtraError: the package that reads the format is not installed.
    """
    data = _bytes(path)
    if data.startswith(b"version https://git-lfs"):
        raise MeshError(
            "this is a Git LFS pointer, not the mesh", where=str(path), mend="fetch the file itself: git lfs pull"
        )
    if volumes.is_volume(path):
        return *volumes.surface(path, selection or volumes.Selection()), "mm"
    if selection is not None and selection != volumes.Selection():
        mend = f"remove label and threshold, or name a volume ({', '.join(volumes.ENDINGS)})"
        raise MeshError("label and threshold select a part of a volume, and this is a mesh", where=str(path), mend=mend)
    if path.suffix.lower() in (".stl", ".stla", ".stlb"):
        return *_stl(path, data), ""
    if path.suffix.lower() in vtk_file.ENDINGS:
        return *_with_triangles(path, *vtk_file.read(path, data)), ""
    return _by_trimesh(path, data)


def write(path: Path, vertices: npt.NDArray[np.float64], triangles: npt.NDArray[np.integer]) -> None:
    """Write a mesh without changing its unit: binary STL, or another format of trimesh by the suffix.

    Raises:
        OutputError: the file cannot be written.
    """
    try:
        if path.suffix.lower() == ".stl":
            facets = np.zeros(len(triangles), _FACET)
            facets["corners"] = vertices[triangles]
            with path.open("wb") as out:
                out.write(b"palpate".ljust(80) + np.uint32(len(triangles)).tobytes())
                facets.tofile(out)
        else:
            import trimesh

            trimesh.Trimesh(vertices, triangles, process=False).export(str(path))
    except (OSError, ValueError, KeyError, NotImplementedError) as error:
        raise OutputError(
            "the mesh cannot be written", where=str(path), why=str(error), mend="choose another path, e.g. mended.stl"
        ) from None


def _bytes(path: Path) -> bytes:
    try:
        data = limits.read_bytes(path)
    except FileNotFoundError:
        try:
            near = difflib.get_close_matches(path.name, [p.name for p in path.parent.iterdir()], n=1)
        except OSError:
            near = []
        mend = f"did you mean {path.parent / near[0]}?" if near else "check the path; it is relative to the scene file"
        raise MeshError("mesh file not found", where=str(path), mend=mend) from None
    except (OSError, ValueError) as error:
        raise MeshError(
            "mesh file cannot be read", where=str(path), why=str(error), mend="name a readable file"
        ) from None
    if not data:
        raise MeshError("mesh file is empty (0 bytes)", where=str(path), mend="export or copy it again")
    return data


def _stl(path: Path, data: bytes) -> Soup:
    promised = int.from_bytes(data[80:84], "little") if len(data) >= _HEADER else -1
    whole = promised >= 0 and len(data) == _HEADER + _FACET.itemsize * promised
    says_solid = data[:5].lower() == b"solid"
    if not whole and (says_solid or path.suffix.lower() == ".stla") and _is_ascii(data):
        if path.suffix.lower() == ".stlb":
            warnings.warn(
                PalpateWarning("an ASCII STL under a binary name: read as ASCII", where=str(path)), stacklevel=4
            )
        return _ascii_stl(path, data)
    if whole and promised and (says_solid or path.suffix.lower() == ".stla"):
        why = "its header begins with 'solid', its size is that of a binary file"
        warnings.warn(
            PalpateWarning("a binary STL that calls itself ASCII: read as binary", where=str(path), why=why),
            stacklevel=4,
        )
    return _binary_stl(path, data, promised)


def _is_ascii(data: bytes) -> bool:
    """True also for the text of an empty solid, which has no facet."""
    return b"facet" in data[:4096].lower() or b"endsolid" in data[-4096:].lower()


def _binary_stl(path: Path, data: bytes, promised: int) -> Soup:
    if len(data) < _HEADER:
        raise MeshError(
            f"not an STL file: {len(data)} bytes",
            where=str(path),
            why="a binary STL has a header of 84 bytes, an ASCII STL begins with 'solid'",
            mend="export it again",
        )
    present = (len(data) - _HEADER) // _FACET.itemsize
    if promised > present:
        raise MeshError(
            f"truncated binary STL: the header promises {promised:,} triangles, the file holds {present:,}",
            where=str(path),
            why="the copy or the export was cut short, or this is not an STL file",
            mend="copy or export it again",
        )
    if promised == 0:
        raise MeshError(
            "the STL holds zero triangles", where=str(path), mend="export it again with its surface selected"
        )
    rest = len(data) - _HEADER - _FACET.itemsize * promised
    if rest:
        what = f"{rest:,} bytes after the {promised:,} triangles that the header promises: ignored"
        warnings.warn(PalpateWarning(what, where=str(path)), stacklevel=5)
    facets = np.frombuffer(data, _FACET, count=promised, offset=_HEADER)
    vertices = facets["corners"].reshape(-1, 3)
    return vertices, np.arange(3 * promised, dtype=np.int32).reshape(-1, 3)


def _ascii_stl(path: Path, data: bytes) -> Soup:
    lower = data.lower()
    words = _VERTEX.findall(lower)
    facets, ends = len(re.findall(rb"\bfacet\s+normal\b", lower)), lower.count(b"endfacet")
    if len(words) != 3 * facets or ends != facets:
        raise MeshError(
            f"truncated or malformed ASCII STL: {facets:,} facets begun, {ends:,} ended, {len(words):,} vertices",
            where=str(path),
            why="every facet has three vertices and an endfacet",
            mend="export it again",
        )
    if not facets:
        raise MeshError(
            "the STL holds zero triangles", where=str(path), mend="export it again with its surface selected"
        )
    try:
        vertices = np.array(words, dtype="S").astype(np.float64)
    except ValueError:
        match = next(m for m in _VERTEX.finditer(lower) if not all(is_number(w) for w in m.groups()))
        line = lower.count(b"\n", 0, match.start()) + 1
        text = match.group(0).decode("ascii", "replace")
        raise MeshError(f"not three numbers: {text!r}", where=f"{path}:{line}", mend="export it again") from None
    return vertices, np.arange(len(vertices), dtype=np.int32).reshape(-1, 3)


def _by_trimesh(path: Path, data: bytes) -> tuple[npt.NDArray[np.floating], npt.NDArray[np.integer], str]:
    ending = path.suffix.lower()
    if ending not in _OTHER_FORMATS:
        tool = next((f"{mend}; or " for endings, mend in _CONVERTERS if ending in endings), "")
        mend = f"{tool}use one of {', '.join(FORMATS)}"
        raise MeshError(f"unknown mesh format {path.suffix!r}", where=str(path), mend=mend)
    if any(importlib.util.find_spec(name) is None for name in _PACKAGES.get(ending, ())):
        raise MissingExtraError(f"the reader of {ending} files", "files")
    try:
        if ending == ".off":
            headers.require(path, data)
            return *_with_triangles(path, *off_file.decode(data)), ""
        if ending == ".ply" and ply_elements.has_vertex_lists(data):
            headers.require(path, data)
            return *_with_triangles(path, *ply_elements.mesh(data)), ""
        loaded = headers.load_by_trimesh(path, data)
        vertices = np.asarray(getattr(loaded, "vertices", np.empty((0, 3))), dtype=np.float64)
        triangles = np.asarray(getattr(loaded, "faces", np.empty((0, 3))), dtype=np.int64)
        vertices, unit = _in_named_unit(vertices, str(getattr(loaded, "units", "")))
    except MeshError:
        raise
    except (Exception, RecursionError) as error:  # trimesh raises many types; each means that the file is not readable
        why = f"{type(error).__name__}: {' '.join(str(error).split())[:300]}"
        raise MeshError(
            f"not a readable {path.suffix} file", where=str(path), why=why, mend="export it again"
        ) from None
    return *_with_triangles(path, vertices, triangles), unit


def _in_named_unit(vertices: npt.NDArray[np.float64], named: str) -> tuple[npt.NDArray[np.float64], str]:
    """Vertices and the name of their unit; trimesh names those of COLLADA as ``0.01 * meters``."""
    factor, _, rest = named.partition(" * ")
    if rest == "meters":
        return float(factor) * vertices, "m"
    return vertices, _UNIT_NAMES.get(named.removesuffix("s"), "")


def _with_triangles(path: Path, vertices: npt.NDArray[np.float64], triangles: npt.NDArray[np.int64]) -> Soup:
    """The same, checked: there are triangles, and vertices of three numbers."""
    if len(triangles) == 0 or len(vertices) == 0:
        why = "points without faces are not a surface" if len(vertices) else ""
        raise MeshError("the mesh holds zero triangles", where=str(path), why=why, mend="export it with its faces")
    if vertices.ndim != 2 or vertices.shape[1] != 3:
        what = f"vertices have {vertices.shape[-1]} coordinates; three are needed"
        raise MeshError(what, where=str(path), mend="export it again")
    return vertices, triangles
