"""What other distributions add: commands, shapes and contact methods from a folder outside of the repository."""

import ctypes
import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import yaml

import palpate
from palpate import _core
from palpate.base import plugins
from palpate.base.errors import InvalidSceneError, PalpateError
from palpate.cli import main
from palpate.scene import contact
from palpate.scene.guidance import Fixture
from palpate.world import surfaces

OWN = Path(__file__).parents[2] / "examples" / "own_parts"
COMMAND = '''"""`palpate hello`."""
from dataclasses import dataclass

@dataclass
class Command:
    """Say hello."""
    name: str = "you"

    def __call__(self):
        print(f"hello {self.name}")
        return 3
'''
SHAPE = '''from typing import ClassVar
from palpate.scene.guidance import Shape, Sphere

class Pea(Shape):
    """A ball of 4 mm."""
    key: ClassVar[str] = "pea"

    def make(self, context, X_WF):
        return Sphere(radius=0.004).make(context, X_WF)
'''
LIBRARY = """
#include <stdexcept>
#include "palpate/contact/registry.hpp"
using namespace palpate::contact;
std::unique_ptr<Method> early(const Options& options) {
  Options larger = options;
  larger.radius += 1e-3;
  return make_method("proxy", larger);
}
extern "C" bool add(const char* name, bool other_headers) {
  try {
    register_method(name, &early, kLayout + other_headers);
    return true;
  } catch (const std::invalid_argument&) {
    return false;
  }
}
"""


def installed(folder, name, points, **modules):
    """Put a distribution into a folder, as an installer does."""
    info = folder / f"{name}-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text("\n".join(f"[{group}]\n{line}" for group, line in points.items()))
    for module, text in modules.items():
        (folder / f"{module}.py").write_text(text)


@pytest.fixture
def site(tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(str(tmp_path))
    return tmp_path


def test_command_of_another_distribution_is_listed_run_and_completed(site, capsys):
    installed(site, "greetings", {"palpate.commands": "hello = of_greetings"}, of_greetings=COMMAND)
    assert main(["hello", "--name", "all"]) == 3
    assert capsys.readouterr().out == "hello all\n"
    assert main([]) == 0
    assert "Say hello." in capsys.readouterr().out
    assert main(["helo"]) == 2
    assert "did you mean palpate hello" in capsys.readouterr().err


def test_help_imports_no_code_of_others_and_survives_what_is_broken(site, capsys):
    package = site / "of_many"
    package.mkdir()
    (package / "__init__.py").write_text("raise RuntimeError('imported')")
    (package / "late.py").write_text(COMMAND)
    (package / "bad.py").write_text("def (:")
    (package / "deaf.py").write_bytes(b"\xff\xfe")
    points = "late = of_many.late\nbad = of_many.bad\ndeaf = of_many.deaf\ngone = of_many.gone\ntwice = of_many.late"
    installed(site, "many", {"palpate.commands": points})
    installed(site, "rival", {"palpate.commands": "twice = of_many.bad"})
    assert main([]) == 0
    assert "Say hello." in capsys.readouterr().out
    assert "of_many" not in sys.modules
    for name, words in {
        "late": "'late' of many cannot be loaded",
        "gone": "'gone' of many cannot be loaded",
        "twice": "'twice' is added by",
    }.items():
        assert main([name]) == 2
        assert words in capsys.readouterr().err


def test_name_of_ours_stays_ours(site, capsys):
    installed(site, "thief", {"palpate.commands": "scenes = of_thief"}, of_thief=COMMAND)
    assert main(["scenes"]) == 0
    assert "hello" not in capsys.readouterr().out


def test_same_name_in_two_distributions_and_code_that_fails_are_told_by_their_owners(site):
    installed(site, "one", {"palpate.shapes": "pea = of_one:Pea"})
    with pytest.raises(PalpateError, match=r"'pea' of one cannot be loaded(.|\n)*No module named 'of_one'"):
        plugins.load("palpate.shapes", "pea")
    installed(site, "two", {"palpate.shapes": "pea = of_two:Pea"})
    with pytest.raises(PalpateError, match=r"'pea' is added by (one and two|two and one)(.|\n)*uninstall one"):
        plugins.load("palpate.shapes", "pea")


def test_shape_of_another_distribution_is_a_fixture(site):
    given = {"role": "forbid", "geometry": {"pea": {}}}
    with pytest.raises(InvalidSceneError, match=r"unknown key 'geometry\.pea'"):
        Fixture.model_validate(given)
    installed(site, "peas", {"palpate.shapes": "pea = of_peas:Pea"}, of_peas=SHAPE)
    fixture = Fixture.model_validate(given)
    assert fixture.model_dump()["geometry"] == {"pea": {}}
    again = Fixture.model_validate(fixture.model_dump())
    X = np.tile(np.eye(4), (1, 1, 1))
    X[0, :3, 3] = [0.0, 0.0, 0.01]
    found = again.make_geometry().query(X, np.zeros(1))
    assert found["distance"][0] == pytest.approx(0.006)
    grown = Fixture.model_validate({"role": "forbid", "geometry": {"offset": {"of": {"pea": {}}, "margin": 0.001}}})
    assert grown.make_geometry().query(X, np.zeros(1))["distance"][0] == pytest.approx(0.005)


@pytest.fixture(scope="module")
def library(tmp_path_factory):
    """A library that is compiled against the installed core, as CMake does by palpateConfig.cmake."""
    folder = tmp_path_factory.mktemp("library")
    package = Path(palpate.cmake_dir()).parent
    (folder / "early.cpp").write_text(LIBRARY)
    eigen = package.parent / "cmeel.prefix" / "include" / "eigen3"
    command = [
        os.environ.get("CXX", "g++"),
        "-std=c++20",
        "-O0",
        "-w",
        "-shared",
        "-fPIC",
        "early.cpp",
        "-o",
        "early.so",
    ]
    command += [f"-I{package / 'include'}", f"-I{eigen}", str(package / "libpalpate.so"), "-Wl,--allow-shlib-undefined"]
    subprocess.run(command, cwd=folder, check=True)
    found = ctypes.CDLL(str(folder / "early.so"))
    found.add.restype = ctypes.c_bool
    return found


def test_contact_method_of_another_library_is_felt_and_a_wrong_library_is_refused(library):
    assert not library.add(b"foreign", True)  # other headers
    assert not library.add(b"proxy", False)  # ours
    assert not library.add(b"", False)
    assert library.add(b"early", False)
    assert library.add(b"early", False)  # the same again
    assert "early" in _core.contact_methods()
    given = {"radius": 0.002, "stiffness": 100.0}
    above = [[0.0, 0.0, 0.0025]]
    ours, felt = (contact.render(surfaces.Plane(), above, method=m, **given).force[0] for m in ("proxy", "early"))
    assert ours == pytest.approx([0.0, 0.0, 0.0])
    assert felt == pytest.approx([0.0, 0.0, 0.05])


def test_example_has_less_than_100_lines():
    files = [p for p in OWN.rglob("*") if p.suffix in (".py", ".cpp", ".txt", ".toml")]
    assert sum(len(p.read_text().splitlines()) for p in files) < 100


@pytest.mark.long
def test_example_compiles_installs_and_runs(tmp_path):
    shutil.copytree(OWN, tmp_path / "own_parts")
    build = "import scikit_build_core.build as b; print(b.build_wheel('../dist'))"
    subprocess.run([sys.executable, "-c", build], cwd=tmp_path / "own_parts", check=True)
    (wheel,) = (tmp_path / "dist").glob("*.whl")
    shutil.unpack_archive(wheel, tmp_path / "site", "zip")
    scene = Path(palpate.__file__).parents[1] / "scenes" / "palpation.yaml"
    values = yaml.safe_load(scene.read_text())
    values["contact"]["method"] = "early"
    rod = {"rod": {"start": [0, 0, 0.05], "end": [0, 0, 0.1], "radius": 0.01}}
    values["guidance"] = [{"role": "forbid", "geometry": rod}]
    (tmp_path / "early.yaml").write_text(yaml.safe_dump(values))
    env = os.environ | {"PYTHONPATH": str(tmp_path / "site")}
    run = [sys.executable, "-m", "palpate", "run", "early.yaml", "--headless", "--duration", "2", "--out", "runs"]
    subprocess.run(run, cwd=tmp_path, env=env, check=True)
    (record,) = (tmp_path / "runs").rglob("record.mcap")
    del values["guidance"]  # whose class would load the library as well
    (tmp_path / "sent.yaml").write_text(yaml.safe_dump(values))
    write = "import pickle, sys; from palpate import Scene; pickle.dump(Scene.load('sent.yaml'), sys.stdout.buffer)"
    read = "import pickle, sys; from palpate.scene import rig; rig.build(pickle.load(sys.stdin.buffer))"
    one = subprocess.run([sys.executable, "-c", write], cwd=tmp_path, env=env, check=True, capture_output=True)
    subprocess.run([sys.executable, "-c", read], cwd=tmp_path, env=env, check=True, input=one.stdout)
    weigh = subprocess.run(
        [sys.executable, "-m", "palpate", "weigh", str(record)], env=env, check=True, capture_output=True, text=True
    )
    assert float(weigh.stdout.split()[0]) > 0.5
