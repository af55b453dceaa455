"""A scene is data: no command and no call runs code that a scene names, unless it is installed or trusted."""

import os
import subprocess
import sys
import textwrap
from pathlib import Path

import pytest

import palpate
from palpate.base.errors import DeviceError
from palpate.devices import open_driver, trust
from palpate.session import Session

SCENE = "objects: [{name: egg, sphere: {radius: 0.017}, stiffness: 260}]\narms: {leader: {driver: 'DRIVER'}}\n"
CODE = """
    from pathlib import Path
    Path(__file__).with_name("ran.txt").write_text("it ran")
    import numpy as np
    class Stick:
        rate, force_max, workspace = 400.0, 3.0, (0.1, 0.1, 0.1)
        def open(self): pass
        def close(self): pass
        def write(self, wrench): pass
        def read(self): return np.eye(4)
    def start(): return Stick()
"""
NAMES = ["stick.py:Stick", "./sub/stick.py:Stick", "{folder}/stick.py:Stick", "stick:Stick", "sub.stick:Stick"]
# An audit hook is the judge: it sees each file whose code is about to run, and each library that is about to load.
WATCH = """
import sys
folder, seen = sys.argv[1], []
def hook(event, arguments):
    if event == "exec" and str(getattr(arguments[0], "co_filename", "")).startswith(folder): seen.append(arguments[0])
    if event == "import" and arguments[1] and str(arguments[1]).startswith(folder): seen.append(arguments[1])
sys.addaudithook(hook)
import palpate.cli
before, command = list(sys.path), sys.argv[2]
for scene in sys.argv[3:]:
    code = palpate.cli.main([command, scene, *(["--headless", "--duration", "0.1"] if command == "run" else [])])
    print("code", code, "seen", len(seen), "path", sys.path == before)
"""


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "sub").mkdir()
    for place in (tmp_path, tmp_path / "sub"):
        (place / "stick.py").write_text(textwrap.dedent(CODE))
    return tmp_path


def written(folder, driver):
    (folder / "scene.yaml").write_text(SCENE.replace("DRIVER", driver.format(folder=folder)))
    return folder / "scene.yaml"


def ran(folder):
    return any(folder.rglob("ran.txt"))


@pytest.mark.parametrize(("command", "code"), [("check", 0), ("run", 2)])
def test_no_command_runs_what_lies_beside_a_scene(folder, command, code):
    scenes = []
    for k, driver in enumerate(NAMES):
        scenes.append(str(written(folder, driver).rename(folder / f"scene{k}.yaml")))
    done = subprocess.run(
        [sys.executable, "-P", "-c", WATCH, str(folder), command, *scenes], cwd=folder, capture_output=True, text=True,
        timeout=200, check=False, env=os.environ | {"COLUMNS": "300"},
    )  # fmt: skip
    told = done.stdout + done.stderr
    assert done.stdout.count(f"code {code} seen 0 path True") == len(NAMES), told
    assert not ran(folder)
    assert told.count("is code") == told.count("--trust") == len(NAMES)


@pytest.mark.parametrize("driver", NAMES)
def test_trusted_code_runs_and_leaves_the_path_alone(folder, driver):
    before = list(sys.path)
    scene = palpate.Scene.load(written(folder, driver), trust=True)
    sys.modules.pop("stick", None)
    try:
        assert Session(scene).rate == 400.0
    finally:
        for name in ("stick", "sub", "sub.stick"):
            sys.modules.pop(name, None)
    assert ran(folder)
    assert sys.path == before


def test_scenes_are_not_trusted_unless_somebody_says_so(folder):
    path = written(folder, "stick.py:Stick")
    for scene in (palpate.Scene.load(path), palpate.Scene.parse(path.read_text(), str(path))):
        assert not scene.trusted
        with pytest.raises(DeviceError, match=r"is code[\s\S]*trust=True"):
            Session(scene)
        assert not scene.model_copy(update={"seed": 3}).trusted
    trusted = palpate.Scene.load(path, trust=True)
    assert trusted.model_copy(update={"seed": 3}).trusted
    assert not ran(folder)
    with pytest.raises(DeviceError, match="is code"):
        open_driver("stick.py:Stick", folder)


def test_a_shared_object_is_not_loaded(folder):
    (folder / "stick.so").write_bytes(b"\x7fELF" + bytes(60))
    with pytest.raises(DeviceError, match="is code"):
        Session(palpate.Scene.load(written(folder, "./stick.so:port")))
    with pytest.raises(DeviceError, match="cannot be used"):
        Session(palpate.Scene.load(written(folder, "./stick.so:port"), trust=True))


@pytest.fixture
def installed(tmp_path, monkeypatch):
    """A folder of packages with one distribution, as pip leaves it; the module `loose` belongs to none."""
    place = tmp_path / "packages"
    info = place / "stickdevice-1.2.dist-info"
    info.mkdir(parents=True)
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: stickdevice\nVersion: 1.2\n")
    (info / "RECORD").write_text("stickdevice.py,,\nstickoffer.py,,\n")
    (info / "entry_points.txt").write_text("[palpate.drivers]\nstick = stickoffer:start\n")
    for name in ("stickdevice", "stickoffer", "loose"):
        (place / f"{name}.py").write_text(textwrap.dedent(CODE))
    monkeypatch.setattr(trust, "_installed_folders", lambda: [place.resolve()])
    monkeypatch.syspath_prepend(str(place))
    yield place
    for name in ("stickdevice", "stickoffer", "loose"):
        sys.modules.pop(name, None)


def test_an_installed_class_runs_by_its_name(installed, tmp_path):
    assert Session(palpate.Scene.load(written(tmp_path, "stickdevice:Stick"))).rate == 400.0


@pytest.mark.parametrize("name", ["loose:Stick", "stickdevice:start", "stickdevice:No", "os:system", "json.tool:main"])
def test_other_code_of_the_environment_is_no_driver(installed, name):
    """A function of an installed package, e.g. one that runs the tests of the present folder, must not be called."""
    with pytest.raises(DeviceError, match="is code"):
        open_driver(name)
    assert not ran(installed)


def test_a_module_in_front_of_the_installed_one_is_not_taken(installed, tmp_path, monkeypatch):
    front = tmp_path / "front"
    front.mkdir()
    (front / "stickdevice.py").write_text(textwrap.dedent(CODE))
    monkeypatch.syspath_prepend(str(front))
    with pytest.raises(DeviceError, match="is code"):
        open_driver("stickdevice:Stick")
    assert not ran(front)


def test_folders_of_packages_are_those_of_the_environment(monkeypatch, tmp_path):
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    found = trust._installed_folders()
    assert Path(pytest.__file__).resolve().parents[1] in found
    assert not {Path.cwd().resolve(), tmp_path.resolve()} & set(found)
    assert trust.is_installed("palpate.devices.simulated:SimulatedDevice")
    assert not trust.is_installed("pytest:main")
    assert not trust.is_installed("pytest.__main__:Stick")
