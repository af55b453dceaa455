"""Files of items: deterministic, complete or made anew, resumed after kill -9, and absent parts that say so."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import json_contract
import pytest
from matplotlib.image import imread

from palpate.cli import main
from palpate.cli.terminal import chromium
from palpate_lab.reproduce import run
from palpate_lab.reproduce.items import running

QUICK = ["eq3", "eq14", "fig10", "fig11"]


def read(folder):
    return {str(file.relative_to(folder)): file.read_bytes() for file in sorted(folder.rglob("*")) if file.is_file()}


def reproduce(tmp_path, *items, out="paper"):
    file = tmp_path / "paper.json"
    assert main(["reproduce", *items, "--out", str(tmp_path / out), "--json", str(file), "--workers", "1"]) == 0
    return json.loads(file.read_text())


def test_the_same_seed_gives_the_same_files(tmp_path, capsys):
    found = [reproduce(tmp_path, *QUICK, out=name) for name in ("one", "two")]
    assert found[0]["items"] == found[1]["items"]
    one, two = read(tmp_path / "one"), read(tmp_path / "two")
    assert one == two
    kinds = [Path(name).suffix for name in one]
    assert {suffix: kinds.count(suffix) for suffix in (".png", ".svg", ".csv", ".html")} == {
        ".png": 4, ".svg": 4, ".csv": 4, ".html": 1,
    }  # fmt: skip


def test_keys_are_those_of_the_contract(tmp_path, capsys):
    found = reproduce(tmp_path, "eq3")
    assert set(found) == json_contract.keys("reproduce")
    assert set(found["items"]["eq3"]) == json_contract.keys_of("reproduce", "A row of `items`:")
    assert found["items"]["eq3"]["verdict"] == "agrees"
    assert all(found["items"]["eq3"].values())


def test_complete_items_are_kept(tmp_path, capsys):
    reproduce(tmp_path, *QUICK[:2])
    kept = read(tmp_path / "paper" / "eq3")
    times = (tmp_path / "paper" / "eq3" / "result.json").stat().st_mtime_ns
    capsys.readouterr()
    reproduce(tmp_path, *QUICK[:3])
    lines = capsys.readouterr().out
    assert lines.count("agrees   kept") == 2
    assert read(tmp_path / "paper" / "eq3") == kept
    assert (tmp_path / "paper" / "eq3" / "result.json").stat().st_mtime_ns == times


@pytest.mark.parametrize("damage", ["no result", "cut result", "no picture", "other seed"])
def test_an_incomplete_item_is_made_anew(tmp_path, damage):
    made = run.make("eq14", tmp_path, 1)
    result = tmp_path / "eq14" / run.RESULT
    before = read(tmp_path)
    if damage == "no result":
        result.unlink()
    elif damage == "cut result":
        result.write_text(result.read_text()[:100])
    elif damage == "no picture":
        (tmp_path / "eq14" / "eq14.svg").unlink()
    again = run.make("eq14", tmp_path, 2 if damage == "other seed" else 1)
    assert not made.kept
    assert not again.kept
    assert (read(tmp_path) == before) == (damage != "other seed")


def test_a_killed_run_goes_on(tmp_path):
    out = tmp_path / "paper"
    words = [sys.executable, "-m", "palpate", "reproduce", "eq3", "fig5", "eq14", "--out", str(out)]
    process = subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    end = time.monotonic() + 300.0
    while not (out / "eq3" / run.RESULT).exists() and process.poll() is None and time.monotonic() < end:
        time.sleep(0.02)
    assert process.poll() is None
    os.kill(process.pid, signal.SIGKILL)  # in the middle of fig5
    process.wait()
    first = (out / "eq3" / run.RESULT).stat().st_mtime_ns
    assert not (out / "index.html").exists()
    words[words.index("fig5")] = "fig10"
    done = subprocess.run(words, capture_output=True, text=True, check=True)
    assert (out / "eq3" / run.RESULT).stat().st_mtime_ns == first
    assert done.stdout.count("agrees   kept") == 1
    assert {one.name for one in out.iterdir() if not one.name.startswith(".")} == {"eq3", "eq14", "fig10", "index.html"}


def test_without_a_browser_the_picture_is_painted_and_made_anew_later(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(chromium, "find", lambda: None)
    monkeypatch.setattr(running, "_POSES", 2)
    found = reproduce(tmp_path, "fig4", "eq14")
    assert found["items"]["fig4"]["verdict"] == "agrees"
    assert "painted by software" in found["items"]["fig4"]["why"]
    assert found["items"]["eq14"]["verdict"] == "agrees"
    page = (tmp_path / "paper" / "index.html").read_text()
    assert "apt-get install chromium" in page
    pixels = imread(tmp_path / "paper" / "fig4" / "fig4.png")[..., :3]
    assert 0.03 < (pixels.min(axis=2) < 0.97).mean() < 0.9  # arms and organ on white
    assert run._read(tmp_path / "paper" / "fig4", run.source_key(1)) is None
    assert run._read(tmp_path / "paper" / "eq14", run.source_key(1)) is not None


def test_without_the_viewer_the_picture_is_painted(tmp_path, monkeypatch, capsys):
    for name in [*sys.modules]:
        if name.startswith("palpate.viewer"):
            monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "viser", None)
    found = reproduce(tmp_path, "fig4")
    assert found["items"]["fig4"]["verdict"] == "agrees"
    assert "palpate[viewer]" in found["items"]["fig4"]["why"]


@pytest.mark.parametrize(
    ("item", "package", "extra"),
    [("fig5", "coal", "planning"), ("fig5", "nrrd", "files"), ("fig2", "small_gicp", "registration")],
)
def test_an_absent_package_is_said_and_tried_again(item, package, extra, tmp_path, monkeypatch, capsys):
    with monkeypatch.context() as absent:
        absent.setitem(sys.modules, package, None)
        found = reproduce(tmp_path, item)["items"][item]
    assert found["verdict"] == "not made"
    assert f"palpate[{extra}]" in found["why"]
    assert run._read(tmp_path / "paper" / item, run.source_key(1)) is None


def test_a_folder_that_is_not_writable_is_named(tmp_path, capsys):
    file = tmp_path / "file"
    file.write_text("")
    assert main(["reproduce", "eq14", "--out", str(file / "paper")]) == 2
    assert str(file / "paper") in capsys.readouterr().err


def test_an_unknown_item_is_refused_before_the_work(tmp_path, capsys):
    assert main(["reproduce", "fig14", "--out", str(tmp_path / "paper")]) == 2
    assert "did you mean fig4 or fig1 or fig13?" in capsys.readouterr().err
    assert not (tmp_path / "paper").exists()
