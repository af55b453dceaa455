"""The package for `colcon build`: its manifest, its launch files, and its nodes, built against the wheels' ament.

A sourced distribution of ROS 2, launch and RViz are not here: launch files run with stand-ins, which keep arguments.
"""

import os
import re
import runpy
import shutil
import subprocess
import sys
from pathlib import Path
from types import ModuleType, SimpleNamespace

import pytest
from cli_words import parse

import palpate
from palpate.ros import where

ROOT = Path(__file__).resolve().parents[2]
PACKAGE = ROOT / "ros2" / "palpate_ros"
CMAKE = (PACKAGE / "CMakeLists.txt").read_text()
NODES = re.search(r"foreach\(NODE IN ITEMS ([\w ]+)\)", CMAKE)[1].split()


def manifest():
    package = pytest.importorskip("catkin_pkg.package", reason="catkin_pkg (extra ros) is not installed")
    return package.parse_package(str(PACKAGE / "package.xml"))


def test_manifest_names_what_the_nodes_are_compiled_against():
    found = manifest()
    assert found.version == palpate.__version__
    assert found.get_build_type() == "ament_cmake"
    nodes = (ROOT / "palpate" / "ros" / "cpp" / "CMakeLists.txt").read_text()
    messages = set(re.search(r"set\(MESSAGES ([\w\s]+)\)", nodes)[1].split())
    ours = {path.name for path in (ROOT / "palpate" / "ros" / "messages").iterdir() if path.is_dir()}
    assert messages - ours <= {one.name for one in found.build_depends}


@pytest.fixture
def launched(monkeypatch):
    """A function that runs a launch file with stand-ins for launch; returns the command of each node."""
    nodes = []

    def node(package, executable, arguments=(), **_):
        nodes.append((package, executable, list(arguments)))

    def declare(name, default_value, description):
        values[name] = default_value

    values: dict[str, str] = {}
    stand_ins = {
        "launch": {"LaunchDescription": list},
        "launch.actions": {"DeclareLaunchArgument": declare, "Shutdown": object,
                           "IncludeLaunchDescription": lambda source: runpy.run_path(source)[MAKE]()},
        "launch.conditions": {"IfCondition": lambda value: value},
        "launch.launch_description_sources": {"PythonLaunchDescriptionSource": str},
        "launch.substitutions": {"LaunchConfiguration": lambda name: SimpleNamespace(name=name)},
        "launch_ros": {},
        "launch_ros.actions": {"Node": node},
        "ament_index_python": {},
        "ament_index_python.packages": {"get_package_share_directory": lambda name: f"/share/{name}"},
    }  # fmt: skip
    for name, members in stand_ins.items():
        module = ModuleType(name)
        module.__dict__.update(members)
        monkeypatch.setitem(sys.modules, name, module)

    def run(name):
        runpy.run_path(str(PACKAGE / "launch" / name))[MAKE]()
        return [
            (package, executable, [word if isinstance(word, str) else values[word.name] for word in words])
            for package, executable, words in nodes
        ]

    return run


MAKE = "generate_launch_description"


@pytest.mark.parametrize(
    ("file", "nodes"), [("haptics.launch.py", ["haptics"]), ("simulated.launch.py", ["sim", "haptics"])]
)
def test_launch_files_start_nodes_that_exist_with_words_that_they_understand(launched, file, nodes):
    found = launched(file)
    ours = [(executable, words) for package, executable, words in found if package == "palpate_ros"]
    assert [executable for executable, _ in ours] == nodes
    for executable, words in ours:
        assert executable in NODES
        parse(["palpate", "ros", executable, *words])
    assert found[-1][:2] == ("rviz2", "rviz2")
    assert found[-1][2][1].removeprefix("/share/palpate_ros/") == "rviz/palpate.rviz"
    assert "DESTINATION share/${PROJECT_NAME}/rviz" in CMAKE


def test_every_node_is_a_command():
    for node in NODES:
        parse(["palpate", "ros", node, "--help"])


def test_a_node_refuses_arguments_of_ros_that_it_would_ignore(monkeypatch, tmp_path, capsys):
    script = tmp_path / "haptics"
    script.write_text((PACKAGE / "node.py.in").read_text().replace("@NODE@", "haptics"))
    called = []
    monkeypatch.setattr("palpate.cli.main", lambda words: called.append(words) or 0)
    for words in (["wall", "--ros-args"], ["wall"]):
        monkeypatch.setattr(sys, "argv", [str(script), *words])
        with pytest.raises(SystemExit) as end:
            runpy.run_path(str(script), run_name="__main__")
        assert end.value.code == 0
    assert called == [["ros", "haptics", "wall"]] * 2
    monkeypatch.setattr(sys, "argv", [str(script), "wall", "--ros-args", "-r", "a:=b"])
    with pytest.raises(SystemExit, match="takes no remappings"):
        runpy.run_path(str(script), run_name="__main__")


@pytest.mark.long
def test_cmake_makes_the_nodes_as_colcon_does(built, tmp_path):
    """With colcon where it is installed; its steps for a package of ament_cmake otherwise."""
    ros = where.find()
    prefix = str(ros.prefixes[0])
    env = ros.environment() | {"CMAKE_PREFIX_PATH": prefix}
    python = f"-DPython3_EXECUTABLE={sys.executable}"
    place = tmp_path / "install" / "palpate_ros"
    if colcon := shutil.which("colcon"):
        steps = [[colcon, "build", "--base-paths", str(PACKAGE), "--cmake-args", python]]
    else:
        options = [python, f"-DCMAKE_INSTALL_PREFIX={place}"]
        steps = [
            ["cmake", "-S", str(PACKAGE), "-B", "b", *options],
            ["cmake", "--build", "b"],
            ["cmake", "--install", "b"],
        ]
    for step in steps:
        done = subprocess.run(step, cwd=tmp_path, env=env, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stdout[-2000:] + done.stderr[-2000:]
    for node in NODES:
        file = place / "lib" / "palpate_ros" / node
        assert os.access(file, os.X_OK)
    done = subprocess.run(
        [place / "lib" / "palpate_ros" / "haptics", "--help"], capture_output=True, text=True, check=True
    )
    assert "usage: palpate ros haptics" in done.stdout
    share = place / "share" / "palpate_ros"
    assert {path.name for path in (share / "launch").iterdir()} >= {"haptics.launch.py", "simulated.launch.py"}
    assert "Visualization Manager" in (share / "rviz" / "palpate.rviz").read_text()
    assert (place / "share" / "ament_index" / "resource_index" / "packages" / "palpate_ros").exists()


@pytest.mark.long
def test_a_python_without_palpate_is_told(tmp_path):
    prefix = str(where.find().prefixes[0])
    bare = tmp_path / "bare"
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", str(bare)], check=True)
    words = ["cmake", "-S", str(PACKAGE), "-B", str(tmp_path / "b"), f"-DPython3_EXECUTABLE={bare / 'bin' / 'python'}",
             f"-DCMAKE_PREFIX_PATH={prefix}"]  # fmt: skip
    done = subprocess.run(words, env=where.find().environment(), capture_output=True, text=True, check=False)
    assert done.returncode != 0
    assert "Mend:" in done.stderr
