"""Segmentations and CT volumes give closed surfaces; reference: the volume and centre of known balls."""

import numpy as np
import pytest

from palpate.base.errors import MeshError
from palpate.world.mesh import Mesh, volumes

nrrd = pytest.importorskip("nrrd", reason="extra files")
nibabel = pytest.importorskip("nibabel", reason="extra files")
pytest.importorskip("skimage", reason="extra files")

SPACING = np.array([1.0, 1.5, 2.0])  # [mm]
ORIGIN = np.array([10.0, -20.0, 30.0])  # LPS [mm]
SIZE = (40, 32, 28)


def ball(centre, radius):
    """Nodes inside a ball (bool), with its centre [mm] from the first node."""
    p = np.stack(np.meshgrid(*(np.arange(n) * s for n, s in zip(SIZE, SPACING, strict=True)), indexing="ij"), -1)
    return np.linalg.norm(p - centre, axis=-1) < radius


LIVER, TUMOUR = ball((18.0, 22.0, 26.0), 12.0), ball((32.0, 34.0, 40.0), 5.0)


def assert_is_ball(mesh, centre, radius, within=0.06):
    assert mesh.report.watertight
    assert mesh.report.inverted == 0
    assert mesh.report.volume_m3 == pytest.approx(4 / 3 * np.pi * (1e-3 * radius) ** 3, rel=within)
    middle = mesh.bounds.mean(axis=0)
    np.testing.assert_allclose(1e3 * middle, ORIGIN + centre, atol=1.1)


def write_nrrd(path, values, space="left-posterior-superior", **header):
    directions = np.diag(SPACING)
    origin = ORIGIN
    if space.startswith("right"):
        directions, origin = directions * [-1, -1, 1], origin * [-1, -1, 1]
    if values.ndim == 4:
        directions = np.vstack([np.full(3, np.nan), directions])
        header["kinds"] = ["list", "domain", "domain", "domain"]
    nrrd.write(str(path), values, {"space": space, "space directions": directions, "space origin": origin, **header})
    return path


@pytest.mark.parametrize("space", ["left-posterior-superior", "right-anterior-superior"])
def test_segmentation_of_3d_slicer_is_a_surface_in_the_patient_frame(tmp_path, space):
    path = write_nrrd(tmp_path / "liver.seg.nrrd", LIVER.astype(np.uint8), space, encoding="gzip")
    assert_is_ball(Mesh.load(path), [18.0, 22.0, 26.0], 12.0)


def test_label_selects_a_segment_by_value_or_name(tmp_path):
    names = {"Segment0_LabelValue": "1", "Segment0_Layer": "0", "Segment0_Name": "liver"}
    names |= {"Segment1_LabelValue": "2", "Segment1_Layer": "0", "Segment1_Name": "tumour"}
    path = write_nrrd(tmp_path / "both.seg.nrrd", LIVER.astype(np.uint8) + 2 * TUMOUR.astype(np.uint8), **names)
    assert_is_ball(Mesh.load(path, label=1), [18.0, 22.0, 26.0], 12.0)
    assert_is_ball(Mesh.load(path, label="tumour"), [32.0, 34.0, 40.0], 5.0, within=0.15)
    with pytest.raises(MeshError, match=r"has 2 labels\n  why: labels: 1 \(liver\), 2 \(tumour\)\n  mend: add label"):
        Mesh.load(path)
    with pytest.raises(MeshError, match=r"label 7 is not in the segmentation"):
        Mesh.load(path, label=7)
    with pytest.raises(MeshError, match=r"there is no segment 'spleen'\n  mend: segments: liver, tumour"):
        Mesh.load(path, label="spleen")


def test_overlapping_segments_lie_in_layers(tmp_path):
    names = {"Segment0_LabelValue": "1", "Segment0_Layer": "0", "Segment0_Name": "liver"}
    names |= {"Segment1_LabelValue": "1", "Segment1_Layer": "1", "Segment1_Name": "tumour"}
    path = write_nrrd(tmp_path / "layers.seg.nrrd", np.stack([LIVER, TUMOUR]).astype(np.uint8), **names)
    assert_is_ball(Mesh.load(path, label="tumour"), [32.0, 34.0, 40.0], 5.0, within=0.15)
    with pytest.raises(MeshError, match=r"label 1 is in several layers[\s\S]*label: NAME"):
        Mesh.load(path, label=1)


@pytest.mark.parametrize("kind", [np.uint8, np.float32])
def test_nifti_label_map_is_converted_to_the_patient_frame(tmp_path, kind):
    X_RAS = np.diag([-SPACING[0], -SPACING[1], SPACING[2], 1.0])
    X_RAS[:3, 3] = ORIGIN * [-1, -1, 1]
    image = nibabel.Nifti1Image((LIVER * 3).astype(kind), X_RAS)
    image.header.set_xyzt_units("mm")
    nibabel.save(image, tmp_path / "liver.nii.gz")
    assert_is_ball(Mesh.load(tmp_path / "liver.nii.gz"), [18.0, 22.0, 26.0], 12.0)


def test_threshold_of_a_ct_lies_between_the_voxels(tmp_path):
    """A radial ramp of Hounsfield units: the surface of 200 HU is a ball of 8 mm to a tenth of a voxel."""
    p = np.stack(np.meshgrid(*(np.arange(n) * s for n, s in zip(SIZE, SPACING, strict=True)), indexing="ij"), -1)
    distance = np.linalg.norm(p - [20.0, 24.0, 28.0], axis=-1)
    path = write_nrrd(tmp_path / "ct.nrrd", (1000 - 100 * distance).astype(np.int16))
    assert_is_ball(Mesh.load(path, threshold=200.0), [20.0, 24.0, 28.0], 8.0, within=0.03)
    with pytest.raises(MeshError, match=r"no voxel has threshold 5000\n  why: its values are"):
        Mesh.load(path, threshold=5000.0)
    with pytest.raises(MeshError, match=r"too many for labels\n[\s\S]*add threshold: VALUE"):
        Mesh.load(path)


def test_segment_at_the_border_is_closed(tmp_path):
    path = write_nrrd(tmp_path / "full.nrrd", np.ones(SIZE, np.uint8))
    assert Mesh.load(path).report.watertight


@pytest.mark.parametrize("name", ["a.nrrd", "a.nii", "a.nii.gz"])
def test_damaged_volume_is_refused(tmp_path, name):
    (tmp_path / name).write_bytes(b"NRRD0004\ntype: unsigned char\n")
    with pytest.raises(MeshError, match=r"the volume cannot be read\n  why: .+\n  mend: export it again"):
        Mesh.load(tmp_path / name)


def test_label_of_a_mesh_is_refused(tmp_path):
    (tmp_path / "a.stl").write_bytes(b"solid a\nendsolid a\n")
    with pytest.raises(MeshError, match=r"this is a mesh\n  mend: remove label"):
        Mesh.load(tmp_path / "a.stl", label=1)


def test_endings():
    assert [volumes.is_volume(p) for p in map(volumes.Path, ("a.nii.gz", "b.seg.nrrd", "c.gz", "d.stl"))] == [
        1,
        1,
        0,
        0,
    ]
