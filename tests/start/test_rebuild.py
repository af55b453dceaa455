"""An editable install compiles the core again when a source has changed; otherwise it only reads time stamps."""

import os
import subprocess
import sys
import textwrap
import time
import tomllib
from importlib import metadata
from pathlib import Path

import pytest

import palpate
from palpate import rebuild
from palpate.base.errors import MissingExtraError

ROOT = Path(__file__).resolve().parents[2]


class Loader:
    """A mock of scikit-build-core's loader of an editable install."""

    def __init__(self, fails=False):
        self.count, self.path, self.fails = 0, "", fails

    def rebuild(self):
        self.count, self.path = self.count + 1, os.environ["PATH"]
        if self.fails:
            raise subprocess.CalledProcessError(1, "cmake")


@pytest.fixture
def source(tmp_path, monkeypatch):
    """A repository with one source, compiled an hour ago."""
    (tmp_path / "core" / "palpate").mkdir(parents=True)
    (tmp_path / "bindings").mkdir()
    (tmp_path / "build").mkdir()
    (tmp_path / "CMakeLists.txt").write_text("")
    source = tmp_path / "core" / "palpate" / "law.cpp"
    source.write_text("old")
    monkeypatch.setattr(rebuild, "_ROOT", tmp_path)
    monkeypatch.setattr(rebuild, "_loops", 0)  # whatever tests before have left running
    stamp = tmp_path / "build" / f"compiled-{sys.implementation.cache_tag}"
    stamp.touch()
    for path in [*tmp_path.rglob("*"), tmp_path]:
        os.utime(path, (1e9, 1e9))
    return source


def test_changed_source_is_compiled_once(source, monkeypatch):
    loader, path = Loader(), os.environ["PATH"]
    monkeypatch.setattr(palpate, "__loader__", loader)
    rebuild.refresh()
    assert loader.count == 0
    source.write_text("new")
    rebuild.refresh()
    rebuild.refresh()
    assert loader.count == 1
    assert loader.path.startswith(os.path.join(sys.prefix, "bin"))
    assert os.environ["PATH"] == path
    added = source.parent / "added.cpp"
    added.touch()
    os.utime(added, (time.time() + 10.0,) * 2)  # time stamps of file systems have a resolution of milliseconds
    rebuild.refresh()
    assert loader.count == 2


def test_compiler_error_is_reported_and_the_build_is_repeated(source, monkeypatch):
    loader = Loader(fails=True)
    monkeypatch.setattr(palpate, "__loader__", loader)
    source.write_text("wrong")
    for count in (1, 2):
        with pytest.raises(ImportError, match="do not compile"):
            rebuild.refresh()
        assert loader.count == count


def test_installed_wheel_is_not_rebuilt(source, monkeypatch):
    monkeypatch.setattr(palpate, "__loader__", object())
    source.write_text("new")
    rebuild.refresh()


@pytest.fixture
def cache(source):
    """The CMakeCache.txt of a first demo, which configures without any part."""
    build = source.parents[2] / "build" / f"cp{sys.version_info.major}{sys.version_info.minor}-test"
    build.mkdir()
    (build / "CMakeCache.txt").write_text(
        "CMAKE_BUILD_TYPE:STRING=Release\nPALPATE_PARTS:STRING=\nPALPATE_UNITY:BOOL=ON\n"
    )
    return build / "CMakeCache.txt"


def test_missing_extension_is_compiled_on_first_import(cache, monkeypatch, capsys):
    loader, configured, compiled = Loader(), [], {}

    def configure(command, **_):
        configured.append(command)
        parts = command[1].removeprefix("-DPALPATE_PARTS=")
        cache.write_text(f"PALPATE_PARTS:STRING={parts}\n")
        compiled.update((f"palpate._{part}", object()) for part in parts.split(";"))

    monkeypatch.setattr(palpate, "__loader__", loader)
    monkeypatch.setattr(rebuild, "find_spec", compiled.get)
    monkeypatch.setattr(rebuild.subprocess, "run", configure)
    monkeypatch.setattr(rebuild, "import_module", compiled.__getitem__)
    assert rebuild.extension("_tissue") is compiled["palpate._tissue"]
    assert configured == [["cmake", "-DPALPATE_PARTS=tissue", str(cache.parent)]]
    (sentence,) = capsys.readouterr().err.splitlines()
    assert "compiling soft bodies and point clouds" in sentence
    rebuild.extension("_tissue")
    assert (loader.count, len(configured)) == (1, 1)
    rebuild.extension("_dvrk")
    assert configured[1][1] == "-DPALPATE_PARTS=tissue;dvrk"
    assert (loader.count, len(configured)) == (2, 2)


def test_a_part_that_does_not_compile_leaves_the_others_as_they_are(cache, monkeypatch):
    cache.write_text("PALPATE_PARTS:STRING=tissue\n")
    configured = []
    monkeypatch.setattr(palpate, "__loader__", Loader(fails=True))
    monkeypatch.setattr(rebuild, "find_spec", lambda name: None)
    monkeypatch.setattr(rebuild.subprocess, "run", lambda command, **_: configured.append(command[1]))
    with pytest.raises(ImportError, match=r"virtual fixtures: the sources do not compile"):
        rebuild.extension("_guidance")
    assert configured == ["-DPALPATE_PARTS=tissue;guidance", "-DPALPATE_PARTS=tissue"]


def test_what_is_missing_to_compile_is_named(cache, source, monkeypatch):
    def without_cmake(command, **_):
        raise FileNotFoundError(2, "No such file or directory", command[0])

    monkeypatch.setattr(palpate, "__loader__", Loader())
    monkeypatch.setattr(rebuild, "find_spec", lambda name: None)
    monkeypatch.setattr(rebuild.subprocess, "run", without_cmake)
    with pytest.raises(ImportError, match=r"virtual fixtures: cmake is missing.*make setup"):
        rebuild.extension("_guidance")
    source.write_text("changed")
    (source.parents[2] / "build" / "compiling.lock").unlink()
    (source.parents[2] / "build" / "compiling.lock").mkdir()  # as if it could not be written, for root as well
    with pytest.raises(ImportError, match="build cannot be written"):
        rebuild.refresh()


def test_nothing_is_compiled_beside_a_loop_in_real_time(cache, source, monkeypatch):
    loader = Loader()
    monkeypatch.setattr(palpate, "__loader__", loader)
    monkeypatch.setattr(rebuild, "find_spec", lambda name: None)
    session = palpate.Session(palpate.Scene.load(ROOT / "scenes" / "solids.yaml"))
    session.start()
    try:
        source.write_text("changed")
        rebuild.refresh()
        with pytest.raises(palpate.PalpateError, match="virtual fixtures are not compiled yet") as raised:
            rebuild.extension("_guidance")
        assert "make setup" in str(raised.value)
        assert loader.count == 0
    finally:
        session.stop()
    rebuild.refresh()
    assert loader.count == 1


def test_every_part_can_be_compiled_on_first_import_and_is_in_a_wheel():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())
    default = project["tool"]["scikit-build"]["cmake"]["define"]["PALPATE_PARTS"]["default"].split(";")
    assert default == [name.removeprefix("_") for name in rebuild._PARTS]
    assert f"set(PALPATE_PARTS {' '.join(default)} CACHE" in (ROOT / "CMakeLists.txt").read_text()


def test_missing_extension_of_a_wheel_is_reported(source, monkeypatch):
    monkeypatch.setattr(palpate, "__loader__", object())
    monkeypatch.setattr(rebuild, "find_spec", lambda name: None)
    with pytest.raises(ImportError, match="make setup"):
        rebuild.extension("_verify")


PROCESS = textwrap.dedent("""
    import sys, time
    from pathlib import Path
    import palpate
    from palpate import rebuild

    root, name = Path(sys.argv[1]), sys.argv[2]
    installed = root / "installed"

    def step(word):
        with (root / "log").open("a") as log:
            log.write(f"{word} begins\\n")
            log.flush()
            time.sleep(0.3)
            log.write(f"{word} ends\\n")

    class Loader:
        def rebuild(self):
            step("build")
            installed.touch()

    rebuild._ROOT = root
    rebuild.find_spec = lambda name: object() if installed.exists() else None
    rebuild.import_module = lambda name: name
    rebuild.subprocess.run = lambda command, **_: step("configure")
    palpate.__loader__ = Loader()
    print("ready", flush=True)
    sys.stdin.readline()
    rebuild.extension(name)
""")  # CMake's two steps are mocks that write when they begin and end


@pytest.mark.parametrize(
    ("names", "is_changed", "steps"),
    [(("_verify", "_verify"), False, ["configure", "build"]), (("_core", "_core"), True, ["build"])],
    ids=["missing extension", "changed source"],
)
def test_one_of_two_processes_configures_and_compiles(source, cache, names, is_changed, steps):
    root = source.parents[2]
    if is_changed:
        source.write_text("new")
    processes = [
        subprocess.Popen(
            [sys.executable, "-c", PROCESS, str(root), name], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )
        for name in names
    ]
    for process in processes:
        assert process.stdout.readline() == "ready\n"
    for process in processes:
        process.stdin.write("go\n")
        process.stdin.flush()
    for process in processes:
        process.communicate(timeout=60.0)
        assert process.returncode == 0
    log = (root / "log").read_text().splitlines()
    assert log == [f"{step} {event}" for step in steps for event in ("begins", "ends")]


@pytest.mark.parametrize(("part", "extra"), [("_collision", "collision"), ("_reference", "lab")])
def test_part_without_its_library_names_the_extra(part, extra, monkeypatch):
    monkeypatch.setattr(rebuild, "_installed", lambda distribution: False)
    with pytest.raises(MissingExtraError, match=rf"palpate\[{extra}\]"):
        rebuild.extension(part)


def test_core_loads_no_library_of_a_part():
    """Eigen is compiled in, and urdfdom is all that the core loads of the wheels' prefix."""
    code = "from palpate import _core; print(open('/proc/self/maps').read())"
    maps = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True).stdout
    found = {line.split("/")[-1].split(".so")[0] for line in maps.splitlines() if "cmeel.prefix" in line}
    assert found == {"liburdfdom_model", "libconsole_bridge", "libtinyxml2"}
    requires = [line for line in metadata.requires("palpate") if "extra ==" not in line]
    assert not [line for line in requires if line.startswith(("libpinocchio", "libcoal", "cmeel-boost"))]
