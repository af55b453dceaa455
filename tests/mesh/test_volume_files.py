"""One reader for all volumes: place, units, sides and kinds of voxels, as ITK, 3D Slicer, FSL and PLUS write them.

Reference: the place of a box of voxels that each test puts at known coordinates, and SimpleITK where it is installed.
"""

import struct
import warnings
import zlib
from pathlib import Path

import numpy as np
import pytest

from palpate.base.errors import MeshError, PalpateError, PalpateWarning, SurfaceError
from palpate.world.mesh import Mesh, volume_files
from palpate.world.surfaces import DistanceGrid, volume_grid

nrrd = pytest.importorskip("nrrd", reason="extra files")
nibabel = pytest.importorskip("nibabel", reason="extra files")
pytest.importorskip("skimage", reason="extra files")

LABELS = np.zeros((14, 12, 10), np.uint8)
LABELS[4:8, 3:9, 2:7] = 1
CENTRE = np.array([5.5, 5.5, 4.0])  # of the box [voxels]
SPACING = np.array([1.0, 1.5, 2.0])
ORIGIN = np.array([-30.0, 12.0, 40.0])  # LPS [mm]
PLACE = ORIGIN + SPACING * CENTRE
SIGNS = {
    "left-posterior-superior": (1, 1, 1),
    "right-anterior-superior": (-1, -1, 1),
    "LAS": (1, -1, 1),
    "RAS": (-1, -1, 1),
}


def nodes():
    return np.moveaxis(np.indices(LABELS.shape), 0, -1) * SPACING


DISTANCE = (np.linalg.norm(nodes() - SPACING * CENTRE, axis=-1) - 4.0).astype(np.float32)


def header(space="left-posterior-superior", turn=None, **more):
    sign = np.array(SIGNS.get(space, (1, 1, 1)), float)
    steps = np.diag(SPACING) @ (np.eye(3) if turn is None else turn) * sign
    return {"space": space, "space directions": steps, "space origin": ORIGIN * sign, **more}


def centre_of(path, **selection):
    return 1e3 * Mesh.load(path, **selection).bounds.mean(axis=0)


@pytest.mark.parametrize("space", SIGNS)
def test_labels_and_distances_of_one_header_lie_at_one_place(tmp_path, space):
    nrrd.write(str(tmp_path / "a.nrrd"), LABELS, header(space))
    nrrd.write(str(tmp_path / "b.nrrd"), DISTANCE, header(space))
    np.testing.assert_allclose(centre_of(tmp_path / "a.nrrd"), PLACE, atol=0.1)
    grid = DistanceGrid.load(tmp_path / "b.nrrd", unit="mm")
    assert grid.nearest(1e-3 * PLACE[None])[0][0] == pytest.approx(-4e-3, abs=0.6e-3)
    for step in np.eye(3):
        assert grid.nearest(1e-3 * (PLACE + 5.0 * step)[None])[0][0] == pytest.approx(1e-3, abs=0.4e-3)
        assert grid.nearest(1e-3 * (PLACE + 5.0 * step)[None])[2][0] @ step > 0.95


@pytest.mark.parametrize("order", [(0, 1, 2), (2, 0, 1), (1, 0, 2)])
@pytest.mark.parametrize("flip", [(1, 1, 1), (-1, 1, -1)])
def test_distances_whose_axes_are_in_any_order_are_read(tmp_path, order, flip):
    """The same ball, stored with permuted and reversed axes: X says where each index goes."""
    values, steps, origin = DISTANCE, np.diag(SPACING), ORIGIN.copy()
    for k, sign in enumerate(flip):
        if sign < 0:
            values = np.flip(values, k)
            origin = origin + steps[k] * (values.shape[k] - 1)
            steps[k] *= -1
    values, steps = values.transpose(order), steps[list(order)]
    head = {"space": "left-posterior-superior", "space directions": steps, "space origin": origin}
    nrrd.write(str(tmp_path / "a.nrrd"), np.ascontiguousarray(values), head)
    grid = DistanceGrid.load(tmp_path / "a.nrrd", unit="mm")
    np.testing.assert_allclose(grid.values, 1e-3 * DISTANCE, atol=1e-7)
    np.testing.assert_allclose(grid.origin, 1e-3 * ORIGIN)
    np.testing.assert_allclose(grid.spacing, 1e-3 * SPACING)


def test_oblique_distances_are_refused_with_the_tool(tmp_path):
    c, s = np.cos(0.2), np.sin(0.2)
    nrrd.write(str(tmp_path / "a.nrrd"), DISTANCE, header(turn=np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])))
    with pytest.raises(SurfaceError, match=r"oblique[\s\S]*mend: resample it.*SimpleITK"):
        DistanceGrid.load(tmp_path / "a.nrrd")


@pytest.mark.parametrize("space", ["scanner-xyz", "3D-left-handed"])
def test_a_space_that_is_no_patient_frame_is_refused_by_name(tmp_path, space):
    for name, values in (("a.nrrd", LABELS), ("b.nrrd", DISTANCE)):
        nrrd.write(str(tmp_path / name), values, header(space))
    with pytest.raises(MeshError, match=rf"{space}.*\n  why: LPS, RAS, LAS\n  mend: .*unu basinfo"):
        Mesh.load(tmp_path / "a.nrrd")
    with pytest.raises(SurfaceError, match=space):
        DistanceGrid.load(tmp_path / "b.nrrd")


@pytest.mark.parametrize(("unit", "scale"), [("m", 1e-3), ("cm", 0.1), ("um", 1e3), ("inch", 1 / 25.4)])
def test_units_of_the_header_hold(tmp_path, unit, scale):
    head = {key: value * scale if key.startswith("space ") else value for key, value in header().items()}
    nrrd.write(str(tmp_path / "a.nrrd"), LABELS, head | {"space units": [unit] * 3})
    nrrd.write(str(tmp_path / "b.nrrd"), (DISTANCE * scale).astype("f4"), head | {"space units": [unit] * 3})
    np.testing.assert_allclose(centre_of(tmp_path / "a.nrrd"), PLACE, atol=0.1)
    grid = DistanceGrid.load(tmp_path / "b.nrrd", unit="mm")
    np.testing.assert_allclose(grid.origin, 1e-3 * ORIGIN, rtol=1e-6)
    np.testing.assert_allclose(grid.values, 1e-3 * DISTANCE, atol=1e-7)


@pytest.mark.parametrize("units", [["furlong"] * 3, ["mm", "mm", "cm"]])
def test_an_unknown_unit_is_not_taken_for_the_default(tmp_path, units):
    nrrd.write(str(tmp_path / "a.nrrd"), LABELS, header(**{"space units": units}))
    with pytest.raises(MeshError, match=r"the space units .* are not known"):
        Mesh.load(tmp_path / "a.nrrd")


@pytest.mark.parametrize("drop", ["space origin", "space"])
def test_what_the_header_leaves_out_is_told(tmp_path, drop):
    head = header()
    head.pop(drop)
    if drop == "space":
        head["space dimension"] = 3
    for name, values in (("a.nrrd", LABELS), ("b.nrrd", DISTANCE)):
        nrrd.write(str(tmp_path / name), values, head)
    with pytest.warns(PalpateWarning, match=rf"no (patient frame \(space\)|{drop})"):
        Mesh.load(tmp_path / "a.nrrd")
    with pytest.warns(PalpateWarning, match=rf"no (patient frame \(space\)|{drop})"):
        DistanceGrid.load(tmp_path / "b.nrrd")


@pytest.mark.parametrize("kind", [np.int16, np.int32, np.uint16, np.float32, np.float64, np.int64])
def test_labels_of_any_type_are_labels(tmp_path, kind):
    """ITK and ITK-SNAP write short, many tools float: the values decide, not their type."""
    nrrd.write(str(tmp_path / "a.nrrd"), (3 * LABELS).astype(kind), header())
    assert not volume_grid.holds_distances(tmp_path / "a.nrrd")
    np.testing.assert_allclose(centre_of(tmp_path / "a.nrrd"), PLACE, atol=0.1)
    with pytest.raises(SurfaceError, match=r"no signed distances[\s\S]*none is negative[\s\S]*mesh: FILE"):
        DistanceGrid.load(tmp_path / "a.nrrd")


def test_a_ct_is_no_distance_grid(tmp_path):
    """Short values of both signs, as a CT in Hounsfield units: its slope is not that of distances."""
    ct = np.where(LABELS > 0, 400, -900).astype(np.int16)
    nrrd.write(str(tmp_path / "a.nrrd"), ct, header())
    assert not volume_grid.holds_distances(tmp_path / "a.nrrd")
    with pytest.raises(SurfaceError, match=r"no signed distances[\s\S]*times their distance"):
        DistanceGrid.load(tmp_path / "a.nrrd")
    np.testing.assert_allclose(centre_of(tmp_path / "a.nrrd", threshold=100.0), PLACE, atol=0.1)


def test_distances_in_another_unit_than_the_spacing_are_refused(tmp_path):
    nrrd.write(str(tmp_path / "a.nrrd"), 1e-3 * DISTANCE, header(**{"space units": ["mm"] * 3}))
    with pytest.raises(SurfaceError, match=r"neighbours differ by 0.00\d+ times their distance"):
        DistanceGrid.load(tmp_path / "a.nrrd")


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_voxels_that_are_not_numbers_are_background(tmp_path, value):
    """Distances that are not finite are refused instead."""
    whole = LABELS.astype(np.float32)
    holes = np.where(np.abs(nodes() - SPACING * CENTRE).max(axis=-1) > 8.0, np.float32(value), whole)
    ct = np.where(np.isfinite(holes), 1300.0 * whole - 900.0, holes).astype(np.float32)
    for name, values in (("a", holes), ("ct", ct)):
        nibabel.save(nibabel.Nifti1Image(values, np.diag([-1.0, -1.5, 2.0, 1.0])), tmp_path / f"{name}.nii.gz")
    np.testing.assert_allclose(centre_of(tmp_path / "a.nii.gz"), SPACING * CENTRE, atol=0.1)
    np.testing.assert_allclose(centre_of(tmp_path / "a.nii.gz", threshold=0.5), SPACING * CENTRE, atol=0.1)
    np.testing.assert_allclose(centre_of(tmp_path / "ct.nii.gz", threshold=-300.0), SPACING * CENTRE, atol=0.1)
    bad = DISTANCE.copy()
    bad[0, 0, 0] = value
    nrrd.write(str(tmp_path / "b.nrrd"), bad, header())
    with pytest.raises(SurfaceError, match="1 of 1,680 values are not finite"):
        DistanceGrid.load(tmp_path / "b.nrrd")


def test_a_threshold_below_all_values_is_refused(tmp_path):
    nrrd.write(str(tmp_path / "a.nrrd"), LABELS + 5, header())
    with pytest.raises(MeshError, match=r"all voxels have threshold 2\n  why: its values are 5 to 6"):
        Mesh.load(tmp_path / "a.nrrd", threshold=2.0)


def test_colours_series_and_complex_numbers_are_refused_with_the_tool(tmp_path):
    rgb = np.zeros(LABELS.shape, np.dtype([("R", "u1"), ("G", "u1"), ("B", "u1")]))
    nibabel.save(nibabel.Nifti1Image(rgb, np.eye(4)), tmp_path / "rgb.nii.gz")
    nibabel.save(nibabel.Nifti1Image(LABELS.astype(np.complex64), np.eye(4)), tmp_path / "complex.nii")
    nibabel.save(nibabel.Nifti1Image(np.stack([LABELS] * 3, -1), np.eye(4)), tmp_path / "series.nii.gz")
    wide = np.vstack([np.full(3, np.nan), np.diag(SPACING)])
    for name, kind in (("colour", "RGB-color"), ("vector", "vector"), ("sequence", "list")):
        head = header() | {"space directions": wide, "kinds": [kind, "domain", "domain", "domain"]}
        nrrd.write(str(tmp_path / f"{name}.nrrd"), np.stack([LABELS] * 3), head)
    head = header() | {"space directions": wide[[1, 2, 3, 0]], "kinds": ["domain", "domain", "domain", "time"]}
    nrrd.write(str(tmp_path / "time.nrrd"), np.stack([LABELS] * 3, -1), head)
    for name, words in (
        ("rgb.nii.gz", r"colours \(R, G, B\)"), ("complex.nii", "complex numbers"),
        ("series.nii.gz", r"series of 3 values[\s\S]*fslroi"), ("colour.nrrd", r"rgb-color\)[\s\S]*unu slice"),
        ("vector.nrrd", r"3 values \(vector\)"), ("sequence.nrrd", "series of 3"), ("time.nrrd", "series of 3"),
    ):  # fmt: skip
        with pytest.raises(MeshError, match=words):
            Mesh.load(tmp_path / name)


def test_a_nifti_without_place_or_with_two_is_told(tmp_path):
    image = nibabel.Nifti1Image(LABELS, np.diag([-1.0, -1.5, 2.0, 1.0]))
    image.set_sform(None, 0)
    image.set_qform(None, 0)
    nibabel.save(image, tmp_path / "none.nii")
    with pytest.warns(PalpateWarning, match="neither sform nor qform"):
        Mesh.load(tmp_path / "none.nii")
    moved = np.diag([-1.0, -1.5, 2.0, 1.0])
    image.set_sform(moved, 1)
    moved[0, 3] = 7.0
    image.set_qform(moved, 1)
    nibabel.save(image, tmp_path / "two.nii")
    with pytest.warns(PalpateWarning, match="sform and qform place it up to 7 mm apart"):
        Mesh.load(tmp_path / "two.nii")
    image.set_qform(image.get_sform(), 1)
    nibabel.save(image, tmp_path / "one.nii")
    with warnings.catch_warnings():
        warnings.simplefilter("error", PalpateWarning)
        volume_files.tell_doubts(volume_files.read(tmp_path / "one.nii"), tmp_path)


# -- MetaImage: bytes as ITK writes them -------------------------------------------------------------------------------

TURN = np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])  # row i: direction of index i in LPS


def itk_mha(path, values, packed=False, big=False, data="LOCAL", **more):
    kinds = {"u1": "MET_UCHAR", "i2": "MET_SHORT", "f4": "MET_FLOAT", "f8": "MET_DOUBLE", "i8": "MET_LONG"}
    raw = values.astype(values.dtype.newbyteorder(">" if big else "<")).tobytes(order="F")
    body = zlib.compress(raw) if packed else raw
    fields = {
        "ObjectType": "Image", "NDims": 3, "BinaryData": True, "BinaryDataByteOrderMSB": big, "CompressedData": packed,
        **({"CompressedDataSize": len(body)} if packed else {}),
        "TransformMatrix": " ".join(f"{x:g}" for x in TURN.ravel()), "Offset": "-30 12 40", "CenterOfRotation": "0 0 0",
        "AnatomicalOrientation": "RAI", "ElementSpacing": "1 1.5 2",
        "DimSize": " ".join(map(str, values.shape)), "ElementType": kinds[values.dtype.str[1:]], **more,
        "ElementDataFile": data,
    }  # fmt: skip
    head = "".join(f"{key} = {value}\n" for key, value in fields.items() if value is not None)
    path.write_bytes(head.encode() + (body if data == "LOCAL" else b""))
    if data != "LOCAL":
        (path.parent / data).write_bytes(body)
    return path


WHERE = ORIGIN + TURN.T @ (SPACING * CENTRE)


@pytest.mark.parametrize("kind", ["u1", "i2", "f4", "f8", "i8"])
@pytest.mark.parametrize(
    "more", [{}, {"packed": True}, {"big": True}, {"data": "a.raw"}, {"data": "a.zraw", "packed": True}]
)
def test_meta_images_are_read(tmp_path, kind, more):
    path = itk_mha(tmp_path / ("a.mhd" if "data" in more else "a.mha"), LABELS.astype(kind), **more)
    np.testing.assert_allclose(centre_of(path), WHERE, atol=0.1)


def test_meta_images_agree_with_simple_itk(tmp_path):
    sitk = pytest.importorskip("SimpleITK")
    rng = np.random.default_rng(4)
    R = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    image = sitk.GetImageFromArray(LABELS.transpose(2, 1, 0))
    image.SetSpacing(SPACING.tolist())
    image.SetOrigin(ORIGIN.tolist())
    image.SetDirection((R * np.linalg.det(R)).ravel().tolist())
    where = np.array(image.TransformContinuousIndexToPhysicalPoint(CENTRE.tolist()))
    for name in ("a.mha", "a.mhd", "a.nrrd", "a.nii.gz"):
        for packed in (False, True):
            sitk.WriteImage(image, str(tmp_path / name), useCompression=packed)
            np.testing.assert_allclose(volume_files.read(tmp_path / name).values, LABELS)
            X = volume_files.read(tmp_path / name).X_PI
            np.testing.assert_allclose(X @ [*CENTRE, 1.0], [*where, 1.0], atol=1e-3)


def test_what_a_meta_image_leaves_out_or_holds_besides_is_told(tmp_path):
    itk_mha(tmp_path / "a.mha", LABELS, TransformMatrix=None, Offset=None)
    with pytest.warns(PalpateWarning, match="no TransformMatrix and no Offset"):
        Mesh.load(tmp_path / "a.mha")
    itk_mha(tmp_path / "b.mha", LABELS, Seq_Frame0000_ProbeToTrackerTransform="1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1")
    itk_mha(tmp_path / "c.mha", np.stack([LABELS] * 3), DimSize="14 12 10", ElementNumberOfChannels=3)
    itk_mha(tmp_path / "d.mha", np.stack([LABELS] * 2, -1), NDims=4, ElementSpacing="1 1 1 1", Offset="0 0 0 0",
            TransformMatrix=" ".join(map(str, np.eye(4).ravel())))  # fmt: skip
    itk_mha(tmp_path / "e.mha", LABELS, ElementType="MET_OTHER")
    itk_mha(tmp_path / "f.mhd", LABELS, data="a%03d.raw")
    for name, words in (("b", "series of 10[\\s\\S]*PLUS"), ("c", "holds 3 values"), ("d", "series of 2"),
                        ("e", "MET_OTHER are not read"), ("f", "several files")):  # fmt: skip
        with pytest.raises(MeshError, match=words):
            Mesh.load(next(tmp_path.glob(f"{name}.mh?")))
    (tmp_path / "g.mha").write_bytes(itk_mha(tmp_path / "a.mha", LABELS).read_bytes()[:-500])
    with pytest.raises(MeshError, match="1,680 values"):
        Mesh.load(tmp_path / "g.mha")


def test_distances_in_a_meta_image(tmp_path):
    grid = DistanceGrid.load(itk_mha(tmp_path / "a.mha", DISTANCE))
    middle = grid.origin + grid.spacing * np.unravel_index(np.argmin(grid.values), grid.values.shape)
    np.testing.assert_allclose(1e3 * middle, WHERE, atol=1.1)


@pytest.mark.parametrize("name", ["a.dcm", "a.mgz", "a.img", "a.step", "a.vti", "a.blend"])
def test_other_formats_name_the_tool_that_converts(tmp_path, name):
    (tmp_path / name).write_bytes(struct.pack("<I", 1) * 200)
    with pytest.raises(
        PalpateError, match=r"unknown mesh format[\s\S]*mend: .*(dcm2niix|mri_convert|NIfTI|STL|Slicer)"
    ):
        Mesh.load(Path(tmp_path / name))
