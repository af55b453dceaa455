"""The film has a frame for each 1/30 s, a picture of each chapter, and the curve of the force; chapters name scenes."""

import importlib.util
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from palpate.scene import shipped

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture
def tool():
    pytest.importorskip("matplotlib", reason="matplotlib (extra report) is not installed")
    pytest.importorskip("av", reason="av (extra learning) is not installed")
    spec = importlib.util.spec_from_file_location("film_tool", ROOT / "tools" / "film.py")
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


def test_chapters_are_shipped_scenes_and_last_two_minutes(tool):
    assert {chapter.scene for chapter in tool.CHAPTERS} <= set(shipped.names())
    assert sum(chapter.seconds for chapter in tool.CHAPTERS) == 120.0


def test_a_frame_shows_the_force_up_to_now(tool):
    t = np.arange(0.0, 2.0, 0.001)
    force = np.where(t > 1.0, 1.0, 0.0)
    picture = np.zeros((round(tool.SHARE * 200), 320, 3), np.uint8)
    chapter = tool.Chapter("wall", "words")

    def orange(now):
        frame = np.asarray(tool.compose(chapter, picture, t, force, now, 0.0, 2.0, (200, 320)), float)
        return np.argwhere((abs(frame - [255, 170, 60]).max(axis=2) < 40) & (np.arange(200) > 0.83 * 200)[:, None])

    early, late = orange(0.5), orange(1.9)
    assert early[:, 1].max() < 0.3 * 320 < 0.9 * 320 < late[:, 1].max()
    assert np.ptp(early[:, 0]) < 5 < 20 < np.ptp(late[:, 0]), "the force steps up"


@pytest.mark.long
def test_a_film_of_a_second(tool, tmp_path, capsys):
    import av

    chapters = tuple(
        replace(chapter, seconds=2.5) for chapter in tool.CHAPTERS if chapter.scene in ("wall", "two_hands")
    )
    file = tool.main(tmp_path, 1.0, (180, 320), chapters)
    with av.open(str(file)) as film:
        frames = [frame.to_ndarray(format="rgb24") for frame in film.decode(video=0)]
    assert len(frames) == tool.FPS
    assert frames[0].shape == (180, 320, 3)
    assert np.std(frames[-1][: round(0.7 * 180)]) > 5.0, "the picture is not empty"
    page = (tmp_path / "index.html").read_text()
    for chapter in chapters:
        assert chapter.command in page
        assert (tmp_path / f"{chapter.scene}.png").stat().st_size > 5_000
