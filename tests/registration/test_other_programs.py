"""Fiducials of 3D Slicer and tables of poses of OptiTrack, NDI and TUM, as these programs write them.

Reference: the points and poses that each text is made from, of which the frames, units and orders are those of the
programs' own documentation.
"""

import json
import warnings

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from palpate.base.errors import PalpateWarning, RegistrationError
from palpate.cli import main
from palpate.world.registration import files

LPS = 1e-3 * np.array([[12.5, -80.25, 33.0], [-55.0, -64.75, 10.5], [40.0, 20.5, 71.25], [-20.5, 35.0, -44.75]])
FLIP = {"LPS": [1, 1, 1], "RAS": [-1, -1, 1], "1": [1, 1, 1], "0": [-1, -1, 1]}


def fcsv(system, points=LPS, version="4.11"):
    head = f"# Markups fiducial file version = {version}\n"
    head += "" if system is None else f"# CoordinateSystem = {system}\n"
    head += "# columns = id,x,y,z,ow,ox,oy,oz,vis,sel,lock,label,desc,associatedNodeID\n"
    rows = 1e3 * points * FLIP.get(system, [1, 1, 1])
    return head + "".join(f"n{k},{p[0]},{p[1]},{p[2]},0,0,0,1,1,1,0,F-{k},,\n" for k, p in enumerate(rows))


def mrk(system, kind="Fiducial", unit="mm", scale=1e3):
    points = [
        {"id": str(k), "label": f"F-{k}", "position": list(p), "positionStatus": "defined"}
        for k, p in enumerate(scale * LPS * FLIP[system])
    ]
    points.append({"id": "9", "label": "F-9", "position": [0, 0, 0], "positionStatus": "undefined"})
    markup = {"type": kind, "coordinateSystem": system, "coordinateUnits": unit, "controlPoints": points}
    return json.dumps({"@schema": "markups-schema-v1.0.3.json#", "markups": [markup]})


@pytest.mark.parametrize("system", FLIP)
def test_fcsv_is_read_in_the_frame_that_it_states(tmp_path, system):
    (tmp_path / "a.fcsv").write_text(fcsv(system))
    found = files.read_points(tmp_path / "a.fcsv", "m")
    assert found.p == pytest.approx(LPS)
    assert found.names == ("F-0", "F-1", "F-2", "F-3")


@pytest.mark.parametrize("system", ["LPS", "RAS"])
@pytest.mark.parametrize(("unit", "scale"), [("mm", 1e3), ("m", 1.0), (["UCUM", "mm", "millimeter"], 1e3)])
def test_markups_are_read_without_points_that_were_never_placed(tmp_path, system, unit, scale):
    (tmp_path / "a.mrk.json").write_text(mrk(system, unit=unit, scale=scale))
    assert files.read_points(tmp_path / "a.mrk.json").p == pytest.approx(LPS)


@pytest.mark.parametrize(
    ("name", "text", "words"),
    [
        ("a.fcsv", fcsv(None), "coordinate system 'is not named' is not read"),
        ("a.fcsv", fcsv("2"), r"coordinate system '2' is not read\n  why: LPS and RAS are"),
        ("a.fcsv", fcsv("LPS", LPS[:0]), "no placed point"),
        ("a.mrk.json", mrk("LPS", "ROI"), "type ROI are no list"),
        ("a.mrk.json", mrk("LPS", unit="furlong"), "unit 'furlong' is not known"),
        ("a.mrk.json", mrk("LPS").replace('"LPS"', '"IJK"'), "coordinate system 'IJK' is not read"),
        ("a.mrk.json", '{"markups": 3}', "no list of markups"),
        ("a.mrk.json", json.dumps({"markups": 2 * json.loads(mrk("LPS"))["markups"]}), "2 lists of markups"),
    ],
)
def test_what_is_not_known_is_refused_by_name(tmp_path, name, text, words):
    (tmp_path / name).write_text(text)
    with pytest.raises(RegistrationError, match=words):
        files.read_points(tmp_path / name)


@pytest.mark.parametrize("unit", ["m", "mm"])
@pytest.mark.parametrize("numbers", [1.0, 1e3])
def test_the_file_that_states_its_unit_decides(tmp_path, unit, numbers, capsys):
    """The other one's --unit is compared with the measured distances, and what does not fit is told."""
    R, p = Rotation.from_euler("xyz", [30, 50, -70], degrees=True).as_matrix(), [0.1, -0.2, 1.0]
    (tmp_path / "a.fcsv").write_text(fcsv("RAS"))
    rows = numbers * (LPS @ R.T + p)
    (tmp_path / "b.csv").write_text("x,y,z\n" + "".join(",".join(map(repr, r)) + "\n" for r in rows.tolist()))
    out = tmp_path / "X.json"
    command = ["register", "points", f"{tmp_path}/a.fcsv", f"{tmp_path}/b.csv", "--unit", unit]
    assert main([*command, "--json", str(out)]) == 0
    values = json.loads(out.read_text())
    assert pytest.approx(R, abs=1e-6) == np.array(values["X"])[:3, :3]
    assert pytest.approx(p, abs=1e-6) == np.array(values["X"])[:3, 3]
    told = any("its distances are those of a.fcsv" in text for text in values["warnings"])
    assert told == ((unit == "m") != (numbers == 1.0))
    capsys.readouterr()


# -- tables of poses ---------------------------------------------------------------------------------------------------

POSES = np.tile(np.eye(4), (5, 1, 1))
POSES[:, :3, :3] = Rotation.from_euler("xyz", [[10 * k, 40 - 7 * k, 5 * k] for k in range(5)], degrees=True).as_matrix()
POSES[:, :3, 3] = [[0.1 * k, 0.2, 1.0 - 0.05 * k] for k in range(5)]
QUATERNIONS = Rotation.from_matrix(POSES[:, :3, :3]).as_quat()  # x y z w


def optitrack(units="Millimeters", scale=1e3, rotation="Quaternion", bodies=("Probe",), lost=2):
    n = len(bodies)
    head = f"Format Version,1.23,Take Name,Take 1,Capture Frame Rate,120.000000,Rotation Type,{rotation}"
    lines = [f"{head},Length Units,{units},Coordinate Space,Global", ""]
    lines.append(",Type" + ",Rigid Body" * 8 * n)
    lines.append(",Name," + ",".join(name for name in bodies for _ in range(8)))
    lines.append(",ID," + ",".join("7C7B2FC0" for _ in range(8 * n)))
    lines.append(",," + ",".join((["Rotation"] * 4 + ["Position"] * 3 + ["Mean Marker Error"]) * n))
    lines.append("Frame,Time (Seconds)," + ",".join(["X", "Y", "Z", "W", "X", "Y", "Z", ""] * n))
    for k, (q, p) in enumerate(zip(QUATERNIONS, POSES[:, :3, 3], strict=True)):
        cells = [f"{x:.9f}" for x in [*q, *(scale * p), 0.0003]]
        lines.append(f"{k},{k / 120:.6f}," + ",".join(cells * n))
        if k == lost:
            lines.append(f"{k},{k / 120:.6f}," + "," * (8 * n - 1))
    return "\n".join(lines) + "\n"


def ndi(tools=1, state="OK"):
    one = ",Port {0},Frame,State,Q0,Qx,Qy,Qz,Tx,Ty,Tz,Error"
    rows = []
    for k, (q, p) in enumerate(zip(QUATERNIONS, POSES[:, :3, 3], strict=True)):
        numbers = [q[3], *q[:3], *(1e3 * p), 0.12]
        rows.append(f"{tools}" + f",1,{k},{state}," + ",".join(f"{x:.9f}" for x in numbers))
        rows.append(f"{tools},1,{k},MISSING,,,,,,,,")
    return "Tools" + "".join(one.format(k + 1) for k in range(tools)) + "\n" + "\n".join(rows) + "\n"


def tum():
    rows = [
        " ".join(f"{x:.9f}" for x in [1305031449.8 + k, *p, *q])
        for k, (q, p) in enumerate(zip(QUATERNIONS, POSES[:, :3, 3], strict=True))
    ]
    return "# ground truth trajectory\n# timestamp tx ty tz qx qy qz qw\n" + "\n".join(rows) + "\n"


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("a.csv", optitrack()), ("a.csv", optitrack("Meters", 1.0)), ("a.csv", optitrack("Centimeters", 100.0)),
        ("a.csv", ndi()), ("groundtruth.txt", tum()),
    ],
)  # fmt: skip
@pytest.mark.parametrize("unit", ["m", "mm"])
def test_tables_of_trackers_are_read_in_their_own_unit_and_order(tmp_path, name, text, unit):
    (tmp_path / name).write_text(text)
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        found = files.read_poses(tmp_path / name, unit)
    assert found == pytest.approx(POSES, abs=1e-6)
    lost = [str(one.message) for one in told if issubclass(one.category, PalpateWarning)]
    assert bool(lost) == ("MISSING" in text or "Format" in text)
    assert all("in which the tool was not seen" in words for words in lost)


@pytest.mark.parametrize(
    ("name", "text", "words"),
    [
        ("a.csv", optitrack(bodies=("Probe", "Patient")), "2 rigid bodies: Probe, Patient"),
        ("a.csv", optitrack(rotation="XYZ"), r"rotations are XYZ[\s\S]*Rotation: Quaternion"),
        ("a.csv", optitrack(units="Parsecs"), "length units 'parsecs' are not known"),
        ("a.csv", ndi(tools=2), "2 tools in one table"),
        ("a.csv", ndi(state="MISSING"), "seen in no frame"),
        ("a.tfm", "#Insight Transform File V1.0\n", r"one transform[\s\S]*SimpleITK.ReadTransform"),
    ],
)
def test_tables_of_several_tools_or_of_angles_are_refused(tmp_path, name, text, words):
    (tmp_path / name).write_text(text)
    with pytest.raises(RegistrationError, match=words):
        files.read_poses(tmp_path / name)
