"""`palpate device bench` in a terminal: it asks for each step, takes the answers, and writes model and page."""

import json
import re

import pytest
import yaml

from palpate.base.errors import DeviceError
from palpate.cli import main
from palpate.devices import published
from palpate.devices.published import TABLE, Stated, published_of
from palpate.devices.simulated import SimulatedDevice, Truth


class Terminal:
    """A person at a terminal, who gives these answers in turn."""

    def __init__(self, *answers):
        self.answers = list(answers)

    def isatty(self):
        return True

    def readline(self):
        return self.answers.pop(0) + "\n"


@pytest.fixture
def terminal(monkeypatch, tmp_path, capsys):
    def sit(*answers):
        person = Terminal(*answers)
        monkeypatch.setattr("sys.stdin", person)
        monkeypatch.setattr("sys.stderr.isatty", lambda: True, raising=False)
        return person

    monkeypatch.chdir(tmp_path)
    return sit


def test_the_guide_asks_for_each_step_and_writes_model_and_page(terminal, tmp_path, capsys):
    person = terminal("", "y", "heavy", "-0.1", "nan", "0.1", "1e6", "omega", "omega.3")
    assert main(["device", "bench", "simulated", "--json", "bench.json"]) == 0
    out, said = capsys.readouterr()
    assert person.answers == []
    steps = re.findall(r"step (\d) of 6, ([\w ]+):", said)
    assert steps == [(str(i + 1), name) for i, name in
                     enumerate(("driver", "rest", "move", "weight", "spring", "published figures"))]  # fmt: skip
    assert all(f"'{given}' is no number above 0" in said for given in ("heavy", "-0.1", "nan"))
    assert "not compared: a spring of 1e+06 N/m needs up to" in " ".join(out.split())
    assert "'omega' is not in the table" in said
    found = json.loads((tmp_path / "bench.json").read_text())
    assert [(one["by"], one["given"]) for one in found["force"]] == [("weight", 0.1)]
    rows = {row["name"]: row for row in found["published"]}
    assert rows["resolution"]["stated"] == pytest.approx(10.0)
    assert rows["largest force"]["measured"] == rows["largest force"]["stated"] == 12.0
    assert "friction" not in rows, "this vendor publishes none"
    assert yaml.safe_load((tmp_path / "device.yaml").read_text())["kind"] == "device"
    page = (tmp_path / "device.html").read_text()
    assert {"As published?", "Driver", "Force"} <= set(re.findall(r"<h2>([^<]+)</h2>", page))
    assert "steps as commonly quoted, the sheet was not seen" in page


def test_a_device_without_a_force_gets_its_page_and_is_told_why_there_is_no_model(terminal, tmp_path, capsys):
    (tmp_path / "mouse.py").write_text(
        "import numpy as np\nclass Mouse:\n    rate, force_max = 200.0, 0.0\n    def open(self): pass\n"
        "    def close(self): pass\n    def write(self, w): assert not w.any()\n    def read(self): return np.eye(4)\n"
    )
    person = terminal("", "falcon")
    assert main(["device", "bench", "mouse.py:Mouse", "--json", "bench.json"]) == 0
    out, said = capsys.readouterr()
    assert person.answers == []
    assert not re.search(r"step \d of 6, (move|weight|spring)", said)
    assert "the device has no force: nothing to compare" in " ".join(out.split())
    assert "model: none: it was not pushed" in " ".join(out.split())
    assert (tmp_path / "device.html").is_file()
    assert not (tmp_path / "device.yaml").exists()
    found = json.loads((tmp_path / "bench.json").read_text())
    assert found["model"] is None
    assert not [row for row in found["published"] if row["name"] == "largest force"], "it commands none"
    assert main(["device", "bench", "mouse.py:Mouse", "--yes", "--out", "m.yaml", "--page", "m.html"]) == 2
    assert (tmp_path / "m.html").is_file(), "the page is written before the model is refused"


def test_a_no_ends_it_before_a_push(terminal, monkeypatch, tmp_path, capsys):
    written = []
    monkeypatch.setattr(SimulatedDevice, "write", lambda self, wrench: written.append(wrench.copy()))
    terminal("", "n")
    assert main(["device", "bench", "simulated"]) == 2
    assert "you did not say yes" in capsys.readouterr().err
    assert not any(wrench.any() for wrench in written)
    assert not list(tmp_path.iterdir())


def test_a_driver_that_fails_the_test_is_not_pushed(tmp_path, monkeypatch, capsys):
    (tmp_path / "wrong.py").write_text(
        "import numpy as np\nclass Wrong:\n    rate, force_max = 200.0, 3.0\n    def open(self): pass\n"
        "    def close(self): pass\n    def write(self, w): assert not w.any()\n"
        "    def read(self): return np.diag([1.0, 1.0, -1.0, 1.0])\n"
    )
    assert main(["device", "bench", f"{tmp_path}/wrong.py:Wrong", "--yes"]) == 2
    out, said = capsys.readouterr()
    assert "fails the test of a driver: right-handed" in said
    assert "reverse the sign of one axis" in out


def test_an_unknown_device_is_refused_before_a_push(capsys):
    assert main(["device", "bench", "simulated", "--yes", "--like", "omni"]) == 2
    assert "give one of touch, touch-x, omega.3" in capsys.readouterr().err


def test_every_row_has_a_source_and_figures_of_a_haptic_device():
    assert len({row.device for row in TABLE}) == len(TABLE) >= 7
    for row in TABLE:
        assert row.source
        for value, low, high in ((row.force_max, 1, 40), (row.resolution, 1e-6, 1e-4), (row.mass, 0.01, 1),
                                 (row.friction, 0.01, 1)):  # fmt: skip
            assert value is None or low <= value <= high, row.device
    assert published_of("Touch").friction == 0.26
    with pytest.raises(DeviceError, match="no figures"):
        published_of("mouse")


def test_figures_worse_than_published_are_told():
    from palpate.devices.bench import measure

    driver = SimulatedDevice(truth=Truth(mass=0.2, friction=0.4, resolution=6e-5))
    found = measure(driver, "it")
    rows = {row.name: row for row in published.compare(published_of("touch"), driver, found)}
    assert {name: row.agrees for name, row in rows.items()} == {
        "resolution": True, "mass": False, "friction": False, "largest force": False}  # fmt: skip
    assert "not as published (SensAble" in rows["friction"].in_words()
    assert "as published" in Stated("mass", "kg", 0.045, 0.05, "x").in_words()
