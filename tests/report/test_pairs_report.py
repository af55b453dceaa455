"""The report of a run of several pairs."""

import shutil
from html.parser import HTMLParser
from pathlib import Path

import pytest

from palpate.report.pairs import pair_records, write_pairs_report
from palpate.scene import Scene
from palpate.session import PairsSession


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    scene = Scene.load("two_hands")
    organ = scene.objects[0].model_copy(update={"triangles": 3000})
    small = scene.model_copy(update={"objects": (organ,)}).with_file_of(scene)
    summary = PairsSession(small, out=tmp_path_factory.mktemp("runs")).run(0.5)
    return summary, Path(summary.record)


class _Text(HTMLParser):
    def __init__(self):
        super().__init__()
        self.links, self.words = [], []

    def handle_starttag(self, tag, attrs):
        self.links += [value for key, value in attrs if tag == "a" and key == "href"]

    def handle_data(self, data):
        self.words.append(data)


def test_the_page_shows_every_pair_and_links_its_report(folder):
    summary, path = folder
    assert list(pair_records(path)) == list(summary.pairs)  # the order of the scene
    page = _Text()
    page.feed(write_pairs_report(path, each=False).read_text(encoding="utf-8"))
    assert page.links == [f"{name}/report.html" for name in summary.pairs]
    words = " ".join(page.words)
    for text in ("peak force", "closest instrument", "right haptic loop", "left haptic loop"):
        assert text in words
    assert f"{1e3 * summary.instruments.closest_m:.1f} mm" in words


def test_the_page_and_the_command_name_the_faults_of_each_pair(folder, tmp_path, monkeypatch, capsys):
    from palpate.cli import main
    from palpate.record.reader import Record

    _, path = folder
    copy = tmp_path / "run"
    shutil.copytree(path, copy)
    stalled = property(lambda record: ["a motor stalled"] if record.path.parent.name == "left" else [])
    monkeypatch.setattr(Record, "faults", stalled)
    assert main(["report", str(copy)]) == 0
    out, err = capsys.readouterr()
    assert (out + err).count("fault: a motor stalled") == 1
    page = _Text()
    page.feed((copy / "report.html").read_text(encoding="utf-8"))
    assert "Fault. left: a motor stalled" in " ".join(" ".join(page.words).split())


def test_a_folder_of_one_record_is_no_run_of_pairs(folder, tmp_path):
    _, path = folder
    assert pair_records(path / "left") == {}
    assert pair_records(tmp_path) == {}
    shutil.copytree(path / "left", tmp_path / "run" / "left")
    shutil.copy(path / "scene.yaml", tmp_path / "run")
    assert list(pair_records(tmp_path / "run")) == ["left"]
