"""Names of figures in words, with their units behind the numbers, and what a value becomes on the page."""

import pytest

from palpate_lab.reproduce.figures_in_words import label, prose, values


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("tip_off_mm", ("tip off", "mm")),
        ("rigidity_N_per_m", ("rigidity", "N/m")),
        ("poses", ("poses", "")),
        ("give_all_three_within_20_percent", ("give all three within 20 percent", "")),
        ("φ_f = atan2(δc_y, δc_x)", ("φ_f = atan2(δc_y, δc_x)", "")),
        ("C of the core does no work", ("C of the core does no work", "")),
    ],
)
def test_units_stand_behind_the_number(name, words):
    assert label(name) == words


def test_values_become_lines_lists_and_tables():
    text = values(
        {"tip_mm": 0.32391, "angle_deg": 5, "held": True, "by": {"a_N": 1.5}, "rows": [{"arm": "MTM", "n_m": 2}]}
    )
    assert "<li>tip: 0.3239 mm</li>" in text
    assert "<li>angle: 5°</li>" in text
    assert "<li>held: yes</li>" in text
    assert "<li>by:<ul><li>a: 1.5 N</li></ul></li>" in text
    assert "<th>n [m]</th>" in text
    assert "<td>MTM</td><td>2</td>" in text


def test_rows_of_a_table_may_lack_a_column():
    assert "<td>1</td><td>3</td></tr><tr><td></td><td>2</td>" in values({"rows": [{"a": 1, "b": 3}, {"b": 2}]})


def test_long_values_are_left_out():
    assert values({"many": [0.0] * 9, "rows": [{"a": 1}] * 13, "wide": [dict.fromkeys("abcdefghi", 1)]}) == ""
    assert values("no <numbers>") == "<p><i>no &lt;numbers&gt;</i></p>"


def test_code_in_a_text():
    assert prose("as `palpate run` & more") == "as <code>palpate run</code> &amp; more"
