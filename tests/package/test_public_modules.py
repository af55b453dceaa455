"""Public modules of the root are importable by their public names, and are the same modules."""

from importlib import import_module

import pytest

import palpate
from palpate.scene import contact
from palpate.world.tissue import blocks


def test_public_modules_are_imported_by_their_public_names():
    from palpate.contact import render
    from palpate.tissue import Tissue

    assert render is contact.render
    assert Tissue is palpate.Tissue
    for name in ("contact", "guidance", "planning", "registration", "shapes", "surfaces", "tissue"):
        assert import_module(f"palpate.{name}") is getattr(palpate, name)


def test_what_is_in_a_public_module_is_loaded_once():
    assert import_module("palpate.tissue.blocks") is blocks
    assert blocks.__name__ == blocks.__spec__.name == "palpate.world.tissue.blocks"


@pytest.mark.parametrize("name", ["nowhere", "Tissue", "tissue.nowhere"])
def test_unknown_names_give_an_ordinary_error(name):
    with pytest.raises(ModuleNotFoundError, match="No module named"):
        import_module(f"palpate.{name}")
