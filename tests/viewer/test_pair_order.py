"""The pairs of a replay have the order, and therefore the colours, of the running session."""

import pytest

from palpate.base.errors import RecordError
from palpate.cli import main
from palpate.report.pairs import pair_records


@pytest.mark.parametrize("names", [["right", "left"], ["left", "right"], ["c", "a", "b"]])
def test_records_come_in_the_order_of_the_scene(tmp_path, names):
    lines = "\n".join(f"  {name}: {{}}" for name in names)
    (tmp_path / "scene.yaml").write_text(f"objects: [{{sphere: {{radius: 0.03}}}}]\npairs:\n{lines}\n")
    for name in names:
        (tmp_path / name).mkdir()
        (tmp_path / name / "record.mcap").touch()
    assert list(pair_records(tmp_path)) == names


def test_a_folder_of_several_runs_is_no_run_of_pairs(tmp_path):
    for name in ("right", "left"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "record.mcap").touch()
    with pytest.raises(RecordError, match=r"records \(left, right\), and no scene.yaml with pairs of these names"):
        pair_records(tmp_path)
    for command in ("report", "replay"):
        assert main([command, str(tmp_path)]) == 2
