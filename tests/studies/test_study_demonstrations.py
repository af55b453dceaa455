"""Demonstrations by simulated operators: deterministic, resumable, with the forces that the operator intended."""

import json
import subprocess
import sys
import time

import numpy as np
import pytest
from json_contract import keys
from lerobot_rules import faults

from palpate.base.errors import PalpateError, SceneError
from palpate_lab.studies.demonstrations import work
from palpate_lab.studies.demonstrations.command import Command, _range

pq = pytest.importorskip("pyarrow.parquet", reason="pyarrow (extra learning) is not installed")

SCENE = """\
objects: [{name: floor, plane: {size: 0.3}, stiffness: 400, damping: 2}]
operator: {palpate: {at: [0, 0, 0], force: 1.0, length: 0.02}}
"""


@pytest.fixture
def scene(tmp_path):
    file = tmp_path / "floor.yaml"
    file.write_text(SCENE)
    return file


def made(scene, out, **more):
    command = Command((scene,), out, **{"episodes": 4, "seconds": 1.5, "operators": 3, **more})
    command.executor = "serial"
    return command


def column(folder, name):
    return np.array(pq.read_table(folder / "data/chunk-000/file-000.parquet")[name].to_pylist())


def test_data_set_is_whole_deterministic_and_told(scene, tmp_path, capsys):
    assert made(scene, tmp_path / "a", json="-")() == 0
    facts = json.loads(capsys.readouterr().out)
    assert set(facts) <= keys("study demonstrations")
    assert faults(tmp_path / "a") == []
    assert facts["frames"] == 4 * 45
    made(scene, tmp_path / "b")()
    for name in ("data/chunk-000/file-000.parquet", "meta/stats.json", "meta/README.md"):
        assert (tmp_path / "a" / name).read_bytes() == (tmp_path / "b" / name).read_bytes()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a", "b", "floor.yaml"]
    text = (tmp_path / "a/meta/README.md").read_text()
    assert "models of people, not people" in text


def test_operators_press_as_intended_and_differ(scene, tmp_path):
    made(scene, tmp_path / "a", seconds=4.0, episodes=3)()
    force = np.linalg.norm(column(tmp_path / "a", "observation.meta.force_torque")[:, :3], axis=1).reshape(3, -1)
    held = force[:, 60:].mean(axis=1)
    assert (held > 0.4).all()
    assert (held < 1.6).all()
    assert np.ptp(held) > 0.02
    depth = column(tmp_path / "a", "observation.meta.contact")[:, 0].reshape(3, -1)
    np.testing.assert_allclose(force[:, -1], 400.0 * depth[:, -1], rtol=0.15, atol=0.05)


def test_interrupted_work_is_taken_up(scene, tmp_path, monkeypatch):
    with monkeypatch.context() as patch:
        patch.setattr(work, "taken_up", lambda *_: (_ for _ in ()).throw(KeyboardInterrupt))
        with pytest.raises(KeyboardInterrupt):
            made(scene, tmp_path / "a")()
    assert not (tmp_path / "a").exists()
    with monkeypatch.context() as patch:
        patch.setattr(work, "perform", lambda *_: pytest.fail("an episode is performed again"))
        made(scene, tmp_path / "a")()
    made(scene, tmp_path / "b")()
    name = "data/chunk-000/file-000.parquet"
    assert (tmp_path / "a" / name).read_bytes() == (tmp_path / "b" / name).read_bytes()


@pytest.mark.long
def test_killed_work_is_taken_up_by_another_process(scene, tmp_path):
    """kill -9 in the middle; another process with two workers goes on, to the bytes of an uninterrupted run."""
    words = [
        sys.executable,
        "-m",
        "palpate",
        "study",
        "demonstrations",
        str(scene),
        "--episodes",
        "8",
        "--seconds",
        "2",
    ]
    out, parts = tmp_path / "my set", tmp_path / ".my set.episodes"
    killed = subprocess.Popen([*words, "--out", str(out), "--workers", "1"], stderr=subprocess.PIPE)
    while len(list(parts.glob("episode_*"))) < 3 and killed.poll() is None:
        time.sleep(0.05)
    killed.kill()
    killed.communicate()
    assert 0 < len(list(parts.glob("episode_*"))) < 8
    assert not out.exists()
    subprocess.run([*words, "--out", str(out), "--workers", "2"], check=True, capture_output=True)
    made(scene, tmp_path / "whole", episodes=8, seconds=2.0, operators=20)()
    files = sorted(path.relative_to(out) for path in out.rglob("*") if path.is_file())
    assert files == sorted(
        one.relative_to(tmp_path / "whole") for one in (tmp_path / "whole").rglob("*") if one.is_file()
    )
    for name in files:
        assert (out / name).read_bytes() == (tmp_path / "whole" / name).read_bytes(), name
    assert not parts.exists()


def test_scenes_take_turns_and_values_vary(scene, tmp_path):
    other = tmp_path / "ball.yaml"
    other.write_text(SCENE.replace("name: floor", "name: table"))
    command = made(scene, tmp_path / "a", seconds=0.5, vary=("objects.0.stiffness=200:800",))
    command.scenes = (scene, other)
    command()
    rows = pq.read_table(tmp_path / "a/meta/episodes/chunk-000/file-000.parquet").to_pylist()
    tasks = {row["source"]: row["tasks"][0] for row in rows}
    assert tasks == {f"episode {k}": f"palpate the {'floor' if k % 2 == 0 else 'table'}" for k in range(4)}


def test_episodes_that_touch_too_little_are_failures():
    ticks = np.zeros(100, np.dtype([("F_T_W", "<f8", (3,))]))
    ticks["F_T_W"][:40, 2] = 1.0
    assert not work._judged(ticks, 3, 1.0)["done"]
    ticks["F_T_W"][:60, 2] = 1.0
    assert work._judged(ticks, 3, 1.0)["done"]
    assert not work._judged(ticks, 3, 3.0)["done"]
    assert work._judged(ticks, 3, 1.0)["touching"] == pytest.approx(0.6)


def test_mistakes_are_named(tmp_path):
    with pytest.raises(PalpateError, match="no scene"):
        Command((), tmp_path / "a")()
    with pytest.raises(PalpateError, match="30 s at most"):
        Command(("palpation",), tmp_path / "a", seconds=40.0)()
    with pytest.raises(SceneError, match="several pairs"):
        Command(("two_hands",), tmp_path / "a")()
    for text in ("objects.0.stiffness", "=2:3", "objects.0.stiffness=3:2", "a=b:c", "a=1:inf"):
        with pytest.raises(PalpateError, match="no range"):
            _range(text)
    assert _range("mapping.scale=0.2:0.5") == ("mapping.scale", 0.2, 0.5)
