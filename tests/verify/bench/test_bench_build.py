"""Parts of `palpate bench build` that read logs, flags and sources, without a compilation."""

import json
import subprocess
import sys

import json_contract
import pytest

from palpate.base.errors import PalpateError
from palpate_lab import places
from palpate_lab.verify.bench import build


def test_stopwatch_writes_cpu_time_and_returns_the_exit_code(tmp_path):
    watch, log = tmp_path / "stopwatch.py", tmp_path / "log"
    watch.write_text(build._STOPWATCH)
    spin = "import time\nwhile time.process_time() < 0.3: pass"
    for code, status in ((spin, 0), ("raise SystemExit(3)", 3)):
        done = subprocess.run([sys.executable, str(watch), str(log), sys.executable, "-c", code, "-o", "a/file.o"])
        assert done.returncode == status
    (busy, made), (idle, _) = build._rows(log)
    assert made == "a/file.o"
    assert 0.3 <= float(busy) < 3.0
    assert float(idle) < float(busy)


@pytest.mark.parametrize(
    ("made", "name"),
    [
        ("CMakeFiles/palpate_core.dir/core/palpate/arm/ik.cpp.o", "core/palpate/arm/ik.cpp"),
        (
            "CMakeFiles/palpate_core.dir/Unity/unity_core__palpate__guidance__law_cxx.cxx.o",
            "core/palpate/guidance/law/",
        ),
        (
            "CMakeFiles/palpate_core.dir/Unity/unity_core__palpate__types+mapping_cxx.cxx.o",
            "core/palpate/types+mapping/",
        ),
    ],
)
def test_compilation_is_named_after_its_source_or_folder(made, name):
    assert build._named(made) == name


def test_flags_keep_the_libraries_without_input_and_output(tmp_path):
    flags = "-DX -isystem /p/include -O3 -MD"
    command = f"/usr/bin/ccache /usr/bin/g++ {flags} -o a.o -c /p/bindings/arm.cpp"
    (tmp_path / "c.json").write_text(json.dumps([{"file": "/p/bindings/arm.cpp", "command": command}]))
    assert build._flags(tmp_path / "c.json") == ["/usr/bin/g++", "-DX", "-isystem", "/p/include", "-O3"]


def test_control_is_compiled_in_one_way_whatever_the_flags_of_the_bindings(monkeypatch, tmp_path):
    seen = []
    monkeypatch.setattr(build, "_cpu_of", lambda flags, headers, folder: seen.append((flags, headers)) or 2.5)
    flags = ["g++", "-DX", "-I/p/core", "-isystem", "/p/include", "-isystem", "/p/eigen", "-O1", "-Wall"]
    assert build._control(flags, tmp_path) == 2.5
    plain = ["g++", "-std=c++20", "-O3", "-fPIC", "-isystem", "/p/include", "-isystem", "/p/eigen"]
    assert seen == [(plain, build.CONTROL)]


def test_every_header_of_another_library_is_counted():
    counts = build._headers()
    assert counts["Eigen/Geometry"] >= 1
    assert not any(name.startswith("palpate/") for name in counts)


def test_wheel_has_nothing_to_compile(monkeypatch, tmp_path):
    monkeypatch.setattr(places, "__file__", str(tmp_path / "site-packages" / "palpate_lab" / "places.py"))
    with pytest.raises(PalpateError, match="there is no source to compile"):
        build.root()


def test_keys_and_order_of_the_figures():
    cheap, dear = build.Unit(name="a.cpp", seconds=1.0), build.Unit(name="b.cpp", seconds=9.0)
    figures = build._figures(10.0, 6.0, 8.0, [cheap, dear], [build.Header(name="Eigen/Dense", seconds=2.0, files=40)])
    assert set(figures) == json_contract.keys("bench build")
    assert figures["files"] == [dear, cheap]
    assert "1.1" in [cell for column in build.tables(figures, 1)[0].columns for cell in column.cells]
