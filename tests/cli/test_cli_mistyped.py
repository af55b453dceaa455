"""What a user mistypes on the command line: commands, numbers of options, ports, files of another kind."""

import ast
import re
from pathlib import Path

import pytest

import palpate.cli
from palpate.cli import main
from palpate.cli._folder import entries
from palpate.scene import Scene, shipped

ROOT = Path(__file__).resolve().parents[2]


def refusal(capsys, *args):
    """The message of a command that is refused with exit code 2."""
    assert main(list(args)) == 2
    return capsys.readouterr().err


@pytest.mark.parametrize(
    ("args", "nearest"),
    [(["rnu"], "palpate run"), (["chek", "a.stl"], "palpate check"), (["reprot"], "palpate report"),
     (["Run"], "palpate run"), (["device", "tset"], "palpate device test"), (["cal"], "palpate calibrate"),
     (["soak", "tisue"], "palpate soak tissue"), (["ros", "grpah"], "palpate ros graph")],
)  # fmt: skip
def test_a_mistyped_command_names_the_nearest(capsys, args, nearest):
    words = refusal(capsys, *args)
    assert (
        f"there is no command palpate {' '.join(args[:2] if args[0] in ('device', 'soak', 'ros') else args[:1])}"
        in words
    )
    assert "did you mean" in words
    assert nearest in words


def test_a_command_without_any_near_name_gets_all_names(capsys):
    assert "write one of run, replay, report" in refusal(capsys, "qqqq")


@pytest.mark.parametrize(
    ("args", "words"),
    [
        (["grid", "a.stl", "--spacing", "0"], "--spacing 0: must be above 0 mm"),
        (["grid", "a.stl", "--spacing", "-2"], "--spacing -2: must be above 0 mm"),
        (["certify", "wall", "--stiffness", "-3"], "--stiffness -3: must be above 0 N/m"),
        (["certify", "wall", "--stiffness", "nan"], "--stiffness nan: must be above 0 N/m"),
        (["certify", "wall", "--damping", "-1"], "--damping -1: must be 0 or more N s/m"),
        (["run", "wall", "--duration", "0"], "--duration 0: must be above 0 s"),
        (["run", "wall", "--speed", "inf"], "--speed inf: must be a finite number"),
        (["run", "wall", "--openigtlink", "80000"], "--openigtlink 80000: a port is a number from 1 to 65535"),
        (["run", "wall", "--port", "-5"], "--port -5: a port is a number from 1 to 65535"),
        (["replay", "a.mcap", "--port", "70000"], "--port 70000: a port"),
        (["path", "a.mcap", "--spacing", "-1"], "--spacing -1: must be above 0 mm"),
        (["soak", "device", "--seconds", "-1"], "--seconds -1: must be above 0 s"),
        (["device", "wrist", "a.csv", "--stiffness", "-0.1"], "--stiffness -0.1: must be above 0 N m/rad"),
    ],
)
def test_a_number_that_no_option_means_is_refused_by_name(capsys, args, words):
    assert words in refusal(capsys, *args)


@pytest.mark.parametrize(
    ("name", "data", "what", "mend"),
    [
        ("a.stl", b"solid a\nendsolid a\n", "this is a mesh, not a scene", "palpate check"),
        ("a.STL", bytes(range(256)), "this is a mesh, not a scene", "palpate check"),
        ("ct.nrrd", b"NRRD0004\n", "this is a volume, not a scene", "palpate check"),
        ("scan.pcd", b"VERSION .7\n", "this is a point cloud, not a scene", "cloud:"),
        ("record.mcap", b"\x89MCAP0\r\n", "this is a record or a bag, not a scene", "palpate replay"),
        ("arm.urdf", b"<robot/>", "this is the URDF of an arm, not a scene", "docs/arms.md"),
        ("a.bin", bytes(range(256)) * 4, "not a scene but a binary file", "YAML"),
        ("a.yaml", b"\x1f\x8b\x08\x00\x93", "not a scene but compressed by gzip", "YAML"),
        ("a.yaml", "objects: []".encode("utf-16"), "not a text file in UTF-8, but in UTF-16", "save it as UTF-8"),
        ("a.yaml", "name: f\xfcr".encode("latin-1"), "not a text file in UTF-8", "save it as UTF-8"),
    ],
)
def test_a_file_of_another_kind_is_named(tmp_path, capsys, name, data, what, mend):
    (tmp_path / name).write_bytes(data)
    words = refusal(capsys, "run", str(tmp_path / name), "--headless")
    assert what in words
    assert mend in words


def test_every_scene_that_a_help_text_names_is_shipped_with_its_meshes(monkeypatch):
    monkeypatch.setenv("PALPATE_DATA", "/nonexistent")
    named = set()
    for path in (*(ROOT / "palpate" / "cli").rglob("*.py"), *(ROOT / "lab").rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text())):
            words = ast.get_docstring(node) if isinstance(node, (ast.ClassDef, ast.Module)) else None
            named |= set(
                re.findall(
                    r"^ *palpate (?:run|check|certify|scan|plan) (?:scenes/)?(\w+)(?:\.yaml)?\b(?![.:/])",
                    words or "",
                    re.M,
                )
            )
            named |= set(re.findall(r"scenes/(\w+)\.yaml", words or ""))
    named &= set(shipped.names())
    assert {"palpation", "nodule"} <= named
    for name in named:
        scene = Scene.load(name)
        assert all(obj.file is None or scene.path_of(i).is_file() for i, obj in enumerate(scene.objects)), name


def test_every_command_can_be_listed():
    assert "run" in entries(palpate.cli.MEMBERS)
