"""Shipped scenes are found by name in any folder, listed and copied."""

from pathlib import Path

import pytest

from palpate import Scene, cli
from palpate.base.errors import SceneError
from palpate.scene import shipped

SCENES = Path(__file__).parents[2] / "scenes"


@pytest.fixture(autouse=True)
def elsewhere(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


def test_shipped_scene_is_loaded_by_its_name():
    assert Scene.load("palpation").model_dump() == Scene.load(SCENES / "palpation.yaml").model_dump()


def test_file_of_the_folder_takes_precedence(tmp_path):
    (tmp_path / "palpation").write_text("objects: [{shape: organ, name: mine}]")
    assert Scene.load("palpation").objects[0].name == "mine"


def test_unknown_name_lists_the_shipped_scenes():
    with pytest.raises(SceneError, match=r"palpatoin: scene file not found\n  mend: .*palpation.*palpate scenes"):
        Scene.load("palpatoin")


def test_every_scene_is_listed_with_a_summary(capsys):
    assert cli.main(["scenes"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines] == sorted(path.stem for path in SCENES.glob("*.yaml"))
    assert all(len(line.split()) > 3 for line in lines)


def test_copy_is_the_same_scene(tmp_path, capsys):
    assert cli.main(["scenes", "nodule"]) == 0
    assert Scene.load("nodule.yaml").model_dump() == Scene.load(SCENES / "nodule.yaml").model_dump()
    assert cli.main(["scenes", "nodule"]) == 2
    assert "the file exists already" in capsys.readouterr().err
    assert cli.main(["scenes", "nodul"]) == 2
    assert "did you mean nodule?" in capsys.readouterr().err


def test_names_are_those_of_the_folder():
    assert shipped.find(Path("elsewhere/palpation")) == Path("elsewhere/palpation")
    assert shipped.find(Path("palpation")) == shipped.folder() / "palpation.yaml"
