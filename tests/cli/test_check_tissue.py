"""Warnings of `palpate check` on soft tissue whose motion suffers from its mesh or its modulus."""

from __future__ import annotations

import warnings

import pytest

from palpate import Tissue
from palpate.base.errors import PalpateWarning
from palpate.cli.commands.check.tissue import inspect_tissue, warn_of_tissue
from palpate.world.tissue.blocks import block


def words_of(soft, radius=0.0):
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        warn_of_tissue(inspect_tissue(soft, radius), "object 'liver'")
    return [str(one.message) for one in caught if issubclass(one.category, PalpateWarning)]


@pytest.mark.parametrize(("young", "count"), [(5e3, 0), (2e6, 1)])
def test_much_added_mass_is_told(young, count):
    found = words_of(Tissue(block((3, 3, 2), (0.06, 0.06, 0.04)), young=young, poisson=0.49))
    assert len(found) == count
    assert all("of mass is added to make the time step stable" in one for one in found)


def test_flat_tetrahedra_are_told():
    nodes, tets = block((3, 3, 2), (0.06, 0.06, 0.001))
    found = words_of(Tissue((nodes, tets), young=500.0))
    assert any("tetrahedra are poor (quality below 0.1)" in one for one in found)


@pytest.mark.parametrize(
    ("through", "radius", "told"), [(4, 0.010, True), (5, 0.010, False), (4, 0.005, False), (2, 0.005, False)]
)
def test_layer_as_thin_as_the_tip_needs_five_cells(through, radius, told):
    cells = (through, through, through)
    found = words_of(Tissue(block(cells, (0.010, 0.010, 0.010)), young=5e3), radius)
    assert any("less than the tip's diameter" in one for one in found) == told


@pytest.mark.parametrize(
    ("through", "poisson", "percent"), [(1, 0.3, 40), (1, 0.49, 142), (2, 0.49, None), (3, 0.3, None)]
)
def test_parts_of_one_cell_are_told_with_the_error_of_their_bending(through, poisson, percent):
    soft = Tissue(block((6 * through, 4 * through, through), (0.06, 0.04, 0.01)), young=5e3, poisson=poisson)
    told = [one for one in words_of(soft) if "one tetrahedron thick" in one]
    assert len(told) == (percent is not None)
    assert all(f"about {percent} % too stiff in bending" in one for one in told)
    if percent is None:
        assert inspect_tissue(soft).bending_error_percent == 10.0


@pytest.mark.parametrize(("cells", "told"), [(2, True), (8, False), (60, True)])
def test_a_tip_beside_what_is_judged_is_told(cells, told):
    """A tip of 5 mm on cells of 50, 12.5 and 1.7 mm, one cell deep for the fine ones."""
    deep = 1 if cells > 10 else cells
    soft = Tissue(block((cells, 2, deep), (0.1, 0.2 / cells, 0.1 * deep / cells)), young=5e3)
    found = words_of(soft, 0.004 if cells == 2 else 0.0068)
    assert any("comes to rest is judged" in one for one in found) == told


def test_a_slower_thread_than_judged_is_told():
    mesh = block((4, 4, 4), (0.04, 0.04, 0.04))
    for period, told in ((0.004, False), (0.006, True), (0.05, True)):
        found = words_of(Tissue(mesh, young=5e3, thread="own", period=period), 0.005)
        assert any("may swing by 65 mN" in one for one in found) == told
