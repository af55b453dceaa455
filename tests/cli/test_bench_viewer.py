"""`palpate bench viewer --every` keeps what it has measured so far, and leaves out by name what cannot be shown."""

import json

import pytest

from palpate.base.errors import PalpateError
from palpate.scene import shipped
from palpate_lab.commands.bench import viewer as command
from palpate_lab.verify.bench import viewer

ROW = {
    "renderer": "none", "quality": "light", "size": [1200, 700], "drawn": [300, 200], "triangles": 1, "draw_calls": 1,
    "fps": 30.0, "fps_p50": 30.0, "fps_worst": 10.0, "updates_per_s": 30.0, "missed_per_s": 0.0,
    "processor_ms_per_frame": {"GPU": 20.0, "renderer": 5.0},
    "control": {"fps": 60.0, "missed_per_s": 0.0, "processor_ms_per_frame": 10.0},
}  # fmt: skip


@pytest.fixture
def scenes(monkeypatch):
    """Makes the bench measure scenes by name: those in capitals cannot be shown."""

    def given(*names, seen=lambda: None):
        def run(scene, *args, **kwargs):
            seen()
            if scene.isupper():
                raise PalpateError("needs a device")
            return {"scene": scene, **ROW}

        monkeypatch.setattr(command, "require_viewer", lambda: None)
        monkeypatch.setattr(shipped, "names", lambda: names)
        monkeypatch.setattr(viewer, "run", run)

    return given


def test_what_was_measured_is_kept_at_once_and_the_rest_is_named(scenes, tmp_path, capsys):
    file, kept = tmp_path / "v.json", []
    scenes(
        "one", "DEVICE", "two", seen=lambda: kept.append(file.exists() and len(json.loads(file.read_text())["rows"]))
    )
    assert command.Command(every=True, json=file)() == 0
    assert kept == [False, 1, 1]
    assert [row["scene"] for row in json.loads(file.read_text())["rows"]] == ["one", "two"]
    words = capsys.readouterr().out
    assert "DEVICE is left out: needs a device" in words
    assert words.count("one: light picture") == 1


def test_scenes_that_can_all_not_be_shown_are_an_error(scenes):
    scenes("DEVICE")
    with pytest.raises(PalpateError, match="none of the scenes"):
        command.Command(every=True)()
