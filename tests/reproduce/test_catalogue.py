"""The items are complete, in the paper's order, and name files and requirements that exist."""

import re
from pathlib import Path

import pytest
import yaml

from palpate.base.errors import PalpateError
from palpate_lab.reproduce.catalogue import NAMES, chosen, items

ROOT = Path(__file__).resolve().parents[2]


def test_every_figure_table_and_equation_is_an_item():
    wanted = {*(f"fig{k}" for k in range(1, 14)), *(f"eq{k}" for k in range(1, 21)), "table1", "alg1"}
    assert wanted <= set(NAMES)
    assert set(items()) == set(NAMES)
    assert len(NAMES) == len(set(NAMES))


@pytest.mark.parametrize("kind", ["fig", "eq"])
def test_figures_and_equations_are_in_the_papers_order(kind):
    numbers = [int(name.removeprefix(kind)) for name in NAMES if re.fullmatch(rf"{kind}\d+", name)]
    assert numbers == sorted(numbers)


@pytest.mark.parametrize("name", NAMES)
def test_an_item_says_where_it_is_in_the_paper_and_in_the_code(name):
    item = items()[name]
    assert item.name == name
    assert re.match(r"Section \d", item.section)
    assert item.claim.endswith(".")
    assert item.title
    assert item.code
    for file in item.code:
        assert (ROOT / file).exists(), file


def test_items_name_rows_of_the_requirements():
    table = yaml.safe_load((ROOT / "docs" / "requirements.yaml").read_text(encoding="utf-8"))
    named = {row for item in items().values() for row in item.rows}
    assert named <= set(table)
    assert {f"R{k}" for k in (11, 23, *range(26, 38), *range(39, 45), 46)} <= named


def test_names_are_put_in_the_papers_order():
    assert chosen(["table1", "EQ1", "fig11"]) == ["eq1", "fig11", "table1"]
    assert chosen(["all", "eq1"]) == list(NAMES)
    assert chosen(["eq19..20", "fig6..fig8"]) == ["fig6", "fig7", "fig8", "eq19", "eq20"]


@pytest.mark.parametrize(
    ("given", "near"),
    [("fig21", "fig2"), ("eq19..21", "eq19"), ("eq5..4", "eq5"), ("eqq1", "eq1"), ("tabel1", "table1"), ("al", "all")],
)
def test_an_unknown_item_gets_the_nearest_names(given, near):
    with pytest.raises(PalpateError, match=f"no item '{given}'") as error:
        chosen([given])
    assert near in error.value.mend
    assert "eq1 to eq20" in error.value.mend
