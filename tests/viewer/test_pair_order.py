"""The pairs of a replay have the order, and therefore the colours, of the running session."""

import pytest

from palpate.report.pairs import pair_records


@pytest.mark.parametrize("names", [["right", "left"], ["left", "right"], ["c", "a", "b"]])
def test_records_come_in_the_order_of_the_scene(tmp_path, names):
    lines = "\n".join(f"  {name}: {{}}" for name in names)
    (tmp_path / "scene.yaml").write_text(f"objects: [{{sphere: {{radius: 0.03}}}}]\npairs:\n{lines}\n")
    for name in names:
        (tmp_path / name).mkdir()
        (tmp_path / name / "record.mcap").touch()
    assert list(pair_records(tmp_path)) == names


def test_without_a_scene_they_come_in_alphabetical_order(tmp_path):
    for name in ("right", "left"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "record.mcap").touch()
    assert list(pair_records(tmp_path)) == ["left", "right"]
