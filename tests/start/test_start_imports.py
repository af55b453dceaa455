"""Heavy modules are imported only when needed. The tests compare lists of modules, not times."""

import json
import os
import subprocess
import sys

import pytest

HEAVY = {"clarabel", "distributed", "matplotlib", "nanobind", "rosbags", "scipy", "small_gicp", "trimesh", "viser"}
HEAVY.add("typeguard")  # as long to import as numpy
MODELS = {"pydantic", "yaml"}
TERMINAL = {"rich", "tyro"}
ARRAYS = {"numpy"}
PARTS = {"palpate._dvrk", "palpate._guidance", "palpate._tissue", "palpate._verify"}

NOT_IN_A_RUN = (
    "palpate.arm.identify", "palpate.base.sweep", "palpate.ros", "palpate.session.batch", "palpate.simulators",
    "palpate.viewer", "palpate_lab.",
)  # fmt: skip

SCENE = """\
objects: [{name: ball, sphere: {radius: 0.04}, stiffness: 300}]
record: {report: false}
"""
#: Runs a command line until its end or its first ticks, and prints the imported modules.
WATCH = """
import json, sys
%s
whole = globals().get("whole", False)
def leave(*_):
    raise SystemExit
from palpate.cli import main
if "run" in sys.argv and not whole:
    from palpate.session import Session
    Session._take = Session._take_behind = leave
try:
    main(sys.argv[1:])
except SystemExit:
    pass
print("\\n" + json.dumps(sorted(sys.modules)))
"""
WHOLE = "whole = True"  # the run goes on to its end


def imported(folder, *args, first=""):
    command = [sys.executable, "-c", WATCH % first, *args]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=120, env=dict(os.environ))
    assert done.returncode == 0, done.stderr
    return set(json.loads(done.stdout.splitlines()[-1]))


def tops(modules):
    return {name.partition(".")[0] for name in modules}


@pytest.fixture
def scene(tmp_path):
    (tmp_path / "ball.yaml").write_text(SCENE)
    return "ball.yaml"


@pytest.mark.parametrize("args", [("--help",), (), ("--version",)])
def test_help_and_version_import_neither_numpy_nor_the_core_nor_the_parser(tmp_path, args):
    modules = imported(tmp_path, *args)
    assert not tops(modules) & (HEAVY | MODELS | TERMINAL | ARRAYS)
    assert "palpate._core" not in modules


def test_run_reaches_its_first_ticks_without_unneeded_imports(tmp_path, scene):
    modules = imported(tmp_path, "run", scene, "--headless", "--out", "runs")
    assert "palpate.session" in modules
    assert not tops(modules) & HEAVY
    assert not {name for name in modules if name.startswith(NOT_IN_A_RUN)}
    assert not {"palpate.report.html", "palpate.report.figures"} & modules
    assert "palpate._core" in modules
    assert not modules & PARTS, "the first demo does not compile them"


def test_run_ends_with_few_modules(tmp_path, scene):
    """Each of our own modules takes about a millisecond; numpy.ma and registration were imported in vain."""
    modules = imported(tmp_path, "run", scene, "--headless", "--out", "runs", "--duration", "0.05", first=WHOLE)
    assert "palpate.session.summary" in modules
    assert (tmp_path / "runs").is_dir()
    assert not {"numpy.ma", "palpate.world.registration"} & modules
    assert sum(name.startswith("palpate") for name in modules) <= 165
    assert len(modules) <= 660


def test_a_session_of_one_scene_imports_only_what_the_scene_needs(tmp_path, scene):
    """No meshes, clouds, soft or rigid bodies, trackers, sensors, endoscope, fixtures or pairs, nor readers."""
    run = "import sys, json; from palpate.session import Session; Session(sys.argv[1], out='runs').run(0.05)"
    command = [sys.executable, "-c", run + "; print(json.dumps(sorted(sys.modules)))", scene]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=120, check=True)
    ours = {name for name in json.loads(done.stdout.splitlines()[-1]) if name.startswith("palpate")}
    assert "palpate.record.writer" in ours
    assert len(ours) <= 120, sorted(ours)


def test_a_process_of_its_own_seldom_collects_garbage():
    """Passes over all modules took a quarter of a short run; a program that calls main keeps its own rule."""
    code = "import gc, sys; own = gc.get_threshold()[0]; sys.argv[1:] = ['--version']; from palpate.cli import main"
    code += "; main(%s); print(own, gc.get_threshold()[0])"
    for argument in ("", "['--version']"):
        done = subprocess.run([sys.executable, "-c", code % argument], capture_output=True, text=True, check=True)
        own, now = map(int, done.stdout.splitlines()[-1].split())
        assert now == (own if argument else 50_000)  # own: 700, 2000 from Python 3.13 on


def test_check_imports_no_more_than_a_run(tmp_path, scene):
    modules = imported(tmp_path, "check", scene)
    assert not tops(modules) & HEAVY
    assert "palpate._core" in modules
    assert not modules & PARTS, "the scene needs none"
    assert not {name for name in modules if name.startswith("palpate.devices.") and ".certificate" not in name}, (
        "the scene has no driver"
    )
    assert "numpy.ma" not in modules, "np.unique imports it"


@pytest.mark.parametrize("args", [("--help",), ("run", "ball.yaml", "--headless", "--out", "runs")])
def test_heavy_import_is_found(tmp_path, scene, args):
    assert "scipy" in tops(imported(tmp_path, *args, first="import scipy.interpolate"))


def test_registration_imports_its_libraries_when_it_is_used(tmp_path):
    modules = imported(
        tmp_path, "register", first="import palpate.world.registration, palpate.world.registration.cloud_files"
    )
    assert not tops(modules) & HEAVY


def test_scene_with_a_path_imports_scipy_at_set_up(tmp_path):
    text = SCENE + "guidance: [{geometry: {path: {waypoints: [[0, 0, 0.06], [0.02, 0, 0.06]]}}, role: guide}]\n"
    (tmp_path / "path.yaml").write_text(text)
    assert "scipy" in tops(imported(tmp_path, "check", "path.yaml"))
