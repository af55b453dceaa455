"""Files of strangers: small, and unfolding to more than the machine has, or no files at all."""

import bz2
import gzip
import io
import json
import os
import struct
import zipfile
import zlib
from functools import cache
from pathlib import Path

import numpy as np

HUGE = 4_000_000_000


def _aliases(top):
    lines = ["a0: &a0 [1, 2, 3, 4, 5, 6, 7, 8]"]
    lines += [f"a{k}: &a{k} [{', '.join([f'*a{k - 1}'] * 8)}]" for k in range(1, 12)]
    return "\n".join([*lines, f"{top}: *a11", ""]).encode()


def _merges():
    lines = ["a0: &a0 {k: 1, l: 2}"]
    lines += [f"a{k}: &a{k} {{<<: [{', '.join([f'*a{k - 1}'] * 9)}]}}" for k in range(1, 12)]
    return "\n".join([*lines, "objects: *a11", ""]).encode()


def yaml_files(top="objects"):
    """Name and bytes of YAML files."""
    yield "aliases", _aliases(top)
    yield "merged keys", _merges()
    yield "a long text of many aliases", b"a: &a '" + b"x" * 300_000 + b"'\nobjects: [" + b"*a, " * 4000 + b"*a]\n"
    yield "brackets", b"objects: " + b"[" * 200_000
    yield "braces", b"objects: " + b"{a: " * 100_000
    yield "dashes", b"- " * 100_000 + b"1\n"
    yield "questions", b"? " * 50_000 + b"1\n"
    yield "many values", b"objects: [" + b"1, " * 2_000_000 + b"1]\n"
    yield "itself", b"objects: &o [*o, *o, *o]\n"


def any_files():
    """Name and bytes of files that no format has."""
    yield "empty", b""
    yield "noise", np.random.default_rng(3).bytes(200_000)
    yield "zeros", bytes(300_000)
    yield "a line of letters", b"x" * 3_000_000
    yield "digits", b"9" * 3_000_000


def npy(shape, dtype="<f8", data=b"", fortran=False):
    """Bytes of an .npy file with this header and these data."""
    head = f"{{'descr': '{dtype}', 'fortran_order': {fortran}, 'shape': {shape!r}, }}".encode().ljust(117) + b"\n"
    return b"\x93NUMPY\x01\x00" + struct.pack("<H", len(head)) + head + data


def npz(packing=zipfile.ZIP_STORED, **arrays):
    """Bytes of an .npz file with these members."""
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", packing) as archive:
        for name, data in arrays.items():
            archive.writestr(f"{name}.npy", data)
    return out.getvalue()


def npy_files():
    yield "rows without end", npy((HUGE, 3))
    yield "axes that overflow", npy((2**40, 2**40))
    yield "a negative axis", npy((-1, 3), data=bytes(48))
    yield "objects", npy((2,), "|O", b"\x80\x04]." * 9)
    yield "no bytes in a value", npy((HUGE, HUGE), "|V0")
    yield "a description of 60 kB", b"\x93NUMPY\x01\x00" + struct.pack("<H", 60_000) + b"(" * 60_000
    yield "version 3", b"\x93NUMPY\x03\x00" + struct.pack("<I", 2**31) + b"{}"


@cache
def _packed_zeros(name):
    """An .npz file of 450 kB, one member of which unfolds to 448 MB."""
    return npz(zipfile.ZIP_DEFLATED, **{name: npy((56_000_000,), data=bytes(448_000_000))})


def npz_files(*names):
    for what, data in npy_files():
        yield what, npz(**dict.fromkeys(names, data))
    yield "zeros packed a thousand times", _packed_zeros(names[0])
    lie = bytearray(npz(zipfile.ZIP_DEFLATED, **{names[0]: npy((1000,), data=bytes(8000))}))
    at = lie.rfind(b"PK\x01\x02")
    lie[at + 24 : at + 28] = struct.pack("<I", 2**32 - 2)
    yield "a directory that lies", bytes(lie)


def nrrd(sizes, data=b"", kind="float", encoding="raw", *more):
    """Bytes of an NRRD file."""
    lines = ["NRRD0005", f"type: {kind}", f"dimension: {len(sizes)}", "sizes: " + " ".join(map(str, sizes)),
             "spacings: " + " ".join("1" for _ in sizes), f"encoding: {encoding}", "endian: little", *more]  # fmt: skip
    return "\n".join(lines).encode() + b"\n\n" + data


def _zeros(size, pack=zlib.compressobj):
    packer = pack(9, zlib.DEFLATED, zlib.MAX_WBITS | 16)
    block = bytes(1 << 20)
    return b"".join(packer.compress(block) for _ in range(size >> 20)) + packer.flush()


@cache
def bomb():
    """450 kB that unfold to 450 MB, by gzip."""
    return _zeros(450 << 20)


@cache
def _bzip2_bomb():
    return bz2.compress(bytes(300 << 20))


def nrrd_files(kind):
    yield "sizes without data", nrrd((2000, 2000, 2000), b"", kind)
    yield "sizes that overflow", nrrd((2**31, 2**31, 2**31), b"", kind)
    yield "negative sizes", nrrd((-1, 4, 4), bytes(64), kind)
    yield "gzip, more than announced", nrrd((4, 4, 4), bomb(), kind, "gzip")
    yield "gzip, as announced", nrrd((110, 1024, 1024), bomb(), kind, "gzip")
    yield "bzip2", nrrd((4, 4, 4), _bzip2_bomb() * 4, kind, "bzip2")
    yield "lines to skip", nrrd((4, 4, 4), bytes(256), kind, "raw", f"line skip: {HUGE * 100}")
    yield "a device as data", nrrd((512, 512, 512), b"", kind, "raw", "data file: /dev/zero")
    yield "a packed device", nrrd((4, 4, 4), b"", kind, "gzip", "data file: /dev/zero")
    yield "text", nrrd((4000, 4000, 4000), b"1 2 3", kind, "ascii")


def mha(sizes, data=b"", *more, file="LOCAL"):
    """Bytes of a MetaImage file."""
    lines = ["ObjectType = Image", f"NDims = {len(sizes)}", "DimSize = " + " ".join(map(str, sizes)), *more]
    return "\n".join([*lines, "ElementType = MET_UCHAR", f"ElementDataFile = {file}"]).encode() + b"\n" + data


def mha_files():
    yield "sizes without data", mha((2000, 2000, 2000))
    yield "sizes that overflow", mha((2**31, 2**31, 2**31))
    yield "negative sizes", mha((-1, 4, 4), bytes(64))
    yield "channels without data", mha((4, 4, 4), bytes(64), "ElementNumberOfChannels = 100000000")
    yield "packed, more than announced", mha((4, 4, 4), bomb(), "CompressedData = True")
    yield "packed, as announced", mha((450, 1024, 1024), bomb(), "CompressedData = True")
    yield "a device as data", mha((512, 512, 512), file="/dev/zero")
    yield "a header without end", b"A = 1\n" * 10_000_000


def nifti(dims, data=b"", slope=0.0, code=16, bits=32):
    head = bytearray(348)
    struct.pack_into("<i", head, 0, 348)
    struct.pack_into("<8h", head, 40, len(dims), *dims, *([1] * (7 - len(dims))))
    struct.pack_into("<hh", head, 70, code, bits)
    struct.pack_into("<8f", head, 76, *([1.0] * 8))
    struct.pack_into("<fff", head, 108, 352.0, slope, 0.0)
    head[344:348] = b"n+1\0"
    return bytes(head) + bytes(4) + data


def nifti_files(packed):
    pack = (lambda data: gzip.compress(data)) if packed else (lambda data: data)
    yield "dimensions without data", pack(nifti((32000, 32000, 32000)))
    yield "seven dimensions", pack(nifti((30000,) * 7))
    yield "negative dimensions", pack(nifti((-5, 4, 4), bytes(400)))
    if packed:
        yield "zeros as announced", gzip.compress(nifti((1024, 1024, 220))) + bomb() * 2
        yield "zeros and a scale", gzip.compress(nifti((1024, 1024, 1400), slope=2.0, code=2, bits=8)) + bomb()
        yield "a packed head without end", bomb()


def stl_files():
    yield "triangles without data", b"x".ljust(80) + struct.pack("<I", 2**32 - 1) + bytes(500)
    yield "text of one facet", b"solid a\nfacet normal 0 0 1\n" + b"vertex 0 0 0\n" * 3 + b"endfacet\n" * 100_000


def ply_files():
    for form in ("ascii", "binary_little_endian"):
        axes = "".join(f"property float {axis}\n" for axis in "xyz")
        head = f"ply\nformat {form} 1.0\nelement vertex {{n}}\n{axes}{{more}}end_header\n"
        yield f"vertices without data, {form}", head.format(n=HUGE, more="").encode() + bytes(60)
        faces = f"element face {HUGE}\nproperty list uchar int vertex_indices\n"
        body = b"0 0 0\n1 0 0\n0 1 0\n" if form == "ascii" else np.eye(3, dtype="<f4").tobytes()
        yield f"faces without data, {form}", head.format(n=3, more=faces).encode() + body + b"\x03" + bytes(12)
        wide = "element face 1\nproperty list uint int vertex_indices\n"
        tail = b"4000000000 0 1 2\n" if form == "ascii" else struct.pack("<I", HUGE) + bytes(12)
        yield f"a face without end, {form}", head.format(n=3, more=wide).encode() + body + tail
    yield "no properties", f"ply\nformat binary_little_endian 1.0\nelement vertex {HUGE}\nend_header\n".encode()
    yield "digits", b"ply\nformat ascii 1.0\nelement vertex " + b"9" * 5000 + b"\nproperty float x\nend_header\n"


def pcd_files():
    head = "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT {c} 1 1\nWIDTH {n}\nHEIGHT 1\nPOINTS {n}\nDATA {kind}\n"
    for kind in ("ascii", "binary", "binary_compressed"):
        yield f"points without data, {kind}", head.format(c=1, n=HUGE, kind=kind).encode() + bytes(64)
        yield f"a wide field, {kind}", head.format(c=2**30, n=4, kind=kind).encode() + bytes(64)
    run = b"\x00a" + (b"\xe0" + b"\xff" + b"\x00") * 500_000
    packed = struct.pack("<II", len(run), 2**32 - 1) + run
    yield "a packed run", head.format(c=1, n=3, kind="binary_compressed").encode() + packed
    packed = struct.pack("<II", len(run), 36) + run
    yield "a packed run, longer than announced", head.format(c=1, n=3, kind="binary_compressed").encode() + packed


def obj_files():
    yield "a corner far away", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3000000000\n"
    yield "a device as material", b"mtllib /dev/zero\nusemtl a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3000000\n"
    yield "a texture that is a device", b"mtllib ../../../../dev/zero\nv 0 0 0\nf 1 1 900000000000\n"


def off_files():
    yield "vertices without data", f"OFF\n{HUGE} 1 0\n0 0 0\n".encode()
    yield "faces without data", f"OFF\n3 {HUGE} 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n".encode()
    yield "a face without end", f"OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n{HUGE} 0 1 2\n".encode()


def _gltf(**changes):
    tree = {
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"},
                      {"bufferView": 1, "componentType": 5125, "count": 3, "type": "SCALAR"}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}, {"buffer": 0, "byteOffset": 36, "byteLength": 12}],
        "buffers": [{"byteLength": 48}],
    }  # fmt: skip
    return tree | changes


def _glb(tree, data=bytes(48), length=None):
    text = json.dumps(tree).encode() if isinstance(tree, dict) else tree
    text += b" " * (-len(text) % 4)
    body = struct.pack("<II", length or len(text), 0x4E4F534A) + text + struct.pack("<II", len(data), 0x004E4942) + data
    return b"glTF" + struct.pack("<II", 2, 12 + len(body)) + body


def gltf_trees():
    empty = [
        {"componentType": 5126, "count": HUGE, "type": "VEC3"},
        {"componentType": 5125, "count": HUGE, "type": "SCALAR"},
    ]
    yield "accessors without data", _gltf(accessors=empty)
    seen = [{"bufferView": 0, "componentType": 5126, "count": HUGE, "type": "VEC3"}, _gltf()["accessors"][1]]
    yield "accessors with less data", _gltf(accessors=seen)
    nodes = [{"children": [k + 1] * 10} for k in range(11)] + [{"mesh": 0}]
    yield "nodes that unfold", _gltf(nodes=nodes)
    yield "a node below itself", _gltf(nodes=[{"mesh": 0, "children": [0]}])
    yield "a buffer that is a device", _gltf(buffers=[{"byteLength": 48, "uri": "../../../../../../dev/zero"}])


def glb_files():
    for what, tree in gltf_trees():
        yield what, _glb(tree)
    yield "brackets", _glb(b'{"asset": ' + b"[" * 200_000)
    yield "a length without data", _glb(_gltf(), length=2**32 - 4)


def gltf_files():
    for what, tree in gltf_trees():
        yield what, json.dumps(tree).encode()
    yield "brackets", b'{"asset": ' + b"[" * 200_000


def _chunk(raw, size, compression=b"zstd"):
    body = struct.pack("<QQQI", 0, 1, size, 0) + struct.pack("<I", len(compression)) + compression
    return body + struct.pack("<Q", len(raw)) + raw


def _record(op, body, length=None):
    return struct.pack("<BQ", op, len(body) if length is None else length) + body


@cache
def mcap_files():
    return tuple(_mcap_files())


def _mcap_files():
    import lz4.frame
    import zstandard

    magic = b"\x89MCAP0\r\n"
    head = magic + _record(1, struct.pack("<I", 4) + b"ros2" + struct.pack("<I", 0))
    end = _record(0x0F, bytes(4)) + _record(2, bytes(20)) + magic
    bomb = zstandard.ZstdCompressor(level=3).compress(bytes(600 << 20))
    yield "zstd, as announced", head + _record(6, _chunk(bomb, 600 << 20)) + end
    yield "zstd, more than announced", head + _record(6, _chunk(bomb, 1000)) + end
    yield "zstd, a size without data", head + _record(6, _chunk(b"", 2**63)) + end
    part = zstandard.ZstdCompressor(level=3).compress(bytes(40 << 20))
    yield "many chunks", head + _record(6, _chunk(part, 40 << 20)) * 60 + end
    small = lz4.frame.compress(bytes(600 << 20))
    yield "lz4", head + _record(6, _chunk(small, 600 << 20, b"lz4")) + end
    yield "lz4, more than announced", head + _record(6, _chunk(small, 64, b"lz4")) + end
    yield "a record without data", head + _record(5, b"", 2**63) + end
    yield "a name without end", head + _record(3, struct.pack("<HI", 1, 2**32 - 1)) + end


def vtk_files():
    head = "# vtk DataFile Version 3.0\na\nASCII\n"
    three = "POINTS 3 float\n0 0 0 1 0 0 0 1 0\n"
    yield "points without data", f"{head}DATASET POLYDATA\nPOINTS {HUGE} float\n0 0 0\n".encode()
    yield (
        "polygons without data",
        f"{head}DATASET POLYDATA\n{three}POLYGONS {HUGE} {HUGE}\n3 0 1 2\n".encode(),
    )
    yield (
        "a grid without data",
        f"{head}DATASET STRUCTURED_POINTS\nDIMENSIONS 30000 30000 30000\n".encode(),
    )
    yield (
        "cells without data",
        f"{head}DATASET UNSTRUCTURED_GRID\n{three}CELLS {HUGE} {HUGE}\n".encode(),
    )
    binary = head.replace("ASCII", "BINARY")
    yield "binary points without data", f"{binary}DATASET UNSTRUCTURED_GRID\nPOINTS {HUGE} float\n".encode() + bytes(99)


def entities(body):
    """XML whose entities unfold to 10^12 letters."""
    lines = [f'<!ENTITY e{k} "{f"&e{k - 1};" * 10}">' for k in range(1, 12)]
    return f'<?xml version="1.0"?><!DOCTYPE a [<!ENTITY e0 "xxxxxxxxxx">{"".join(lines)}]>{body}'.encode()


def vtu_files():
    yield (
        "points without data",
        (
            '<VTKFile type="UnstructuredGrid" version="0.1" byte_order="LittleEndian"><UnstructuredGrid>'
            f'<Piece NumberOfPoints="{HUGE}" NumberOfCells="{HUGE}"><Points><DataArray type="Float32" '
            'NumberOfComponents="3" format="ascii">0 0 0</DataArray></Points></Piece></UnstructuredGrid></VTKFile>'
        ).encode(),
    )
    yield (
        "entities",
        entities("<VTKFile>&e11;</VTKFile>"),
    )


def msh_files():
    yield "nodes without data", f"$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n{HUGE}\n1 0 0 0\n".encode()
    yield (
        "binary nodes",
        b"$MeshFormat\n2.2 1 8\n" + struct.pack("<i", 1) + f"\n$EndMeshFormat\n$Nodes\n{HUGE}\n".encode() + bytes(99),
    )
    four = b"$MeshFormat\n4.1 1 8\n" + struct.pack("<i", 1) + b"\n$EndMeshFormat\n"
    yield "blocks of nodes", four + b"$Nodes\n" + struct.pack("<4Q", 2**40, 2**40, 1, 2**40) + bytes(99)
    yield "periodic", f"$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n{HUGE}\n".encode()


def medit_files():
    yield "vertices without data", f"MeshVersionFormatted 2\nDimension 3\nVertices\n{HUGE}\n0 0 0 1\n".encode()
    yield (
        "tetrahedra without data",
        f"MeshVersionFormatted 2\nDimension 3\nVertices\n1\n0 0 0 1\nTetrahedra\n{HUGE}\n1 1 1 1 1\n".encode(),
    )


def meshb_files():
    head = struct.pack("<ii", 1, 2) + struct.pack("<iii", 3, 20, 3)
    yield "vertices without data", head + struct.pack("<iii", 4, 100, 2**31 - 1) + bytes(40)


def urdf_files():
    yield (
        "entities",
        entities('<robot name="a">&e11;</robot>'),
    )
    yield "elements", b"<robot name='a'>" + b"<link name='b'>" * 100_000


def csv_files(header=b""):
    yield "columns", header + b"1," * 2_000_000
    yield "quotes", header + b'"' + b"1\n" * 500_000
    yield "long numbers", header + b"1" * 3_000_000 + b",2,3\n"


def pcap_files():
    head = struct.pack("<IHHiIII", 0xA1B2C3D4, 2, 4, 0, 0, 65535, 1)
    times = [*range(40), 2**32 - 1]
    yield (
        "a packet in a hundred years",
        head + b"".join(struct.pack("<IIII", t // 20, t % 20 * 50, 0, 0) for t in times),
    )
    yield "a packet without data", head + struct.pack("<IIII", 0, 0, 2**32 - 1, 2**32 - 1) * 30
    yield "packets at once", head + struct.pack("<IIII", 5, 5, 0, 0) * 200_000


def special(folder: Path, name: str):
    """Paths that are no files, with their descriptions."""
    for what, target in (("a device", "/dev/zero"), ("a device without end", "/dev/urandom")):
        path = folder / what.replace(" ", "_") / name
        path.parent.mkdir()
        path.symlink_to(target)
        yield what, path
    pipe = folder / "pipe" / name
    pipe.parent.mkdir()
    os.mkfifo(pipe)
    yield "a pipe", pipe
    link = folder / "link" / name
    link.parent.mkdir()
    link.symlink_to(pipe)
    yield "a link to a pipe", link
    hole = folder / "hole" / name
    hole.parent.mkdir()
    with hole.open("wb") as file:
        file.truncate(3 << 30)
    yield "a hole of 3 GB", hole
    yield "a folder", (folder / "folder" / name)
    (folder / "folder" / name).mkdir(parents=True)
