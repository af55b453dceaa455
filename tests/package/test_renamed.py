"""Renamed modules: errors for old names state the new ones, and every new name in the table exists."""

from importlib import import_module

import pytest

import palpate
from palpate.certificate import Certificate
from palpate.contact.touchable import Radius
from palpate.identify.gravity import Calibration
from palpate.identify.pairs import Pairs
from palpate.mesh.check import MeshReport
from palpate.renamed import NAMES, RENAMED
from palpate.ros.haptics import HapticSession
from palpate.session.summary import Summary
from palpate.verify.fuzz import Outcome
from palpate.viewer.live import LiveViewer


@pytest.mark.parametrize(("old", "new"), RENAMED.items())
def test_error_for_an_old_name_states_the_new_one(old, new):
    with pytest.raises(ModuleNotFoundError, match=rf"^{old} is now {new}$"):
        import_module(old)
    import_module(new)


@pytest.mark.parametrize(("old", "new"), NAMES.items())
def test_error_for_an_old_name_in_a_module_states_the_new_one(old, new):
    module, _, name = old.rpartition(".")
    with pytest.raises(ImportError, match=rf"^{old} is now {new}$"):
        exec(f"from {module} import {name}")
    assert getattr(import_module(module), new.rpartition(".")[2])
    with pytest.raises(AttributeError, match="no attribute 'nowhere'"):
        import_module(module).nowhere  # noqa: B018


def test_errors_for_submodules_and_attributes_of_an_old_name_state_the_new_one():
    with pytest.raises(ModuleNotFoundError, match=r"palpate\.calibrate is now palpate\.identify"):
        import_module("palpate.calibrate.gravity")
    with pytest.raises(ModuleNotFoundError, match=r"palpate\.dvrk is now palpate\.simulators\.dvrk"):
        exec("from palpate import dvrk")
    with pytest.raises(AttributeError, match=r"palpate\.bag is now palpate\.record\.bags"):
        palpate.bag  # noqa: B018


@pytest.mark.parametrize("owner", [Summary, Certificate, MeshReport, Calibration, Pairs, Outcome])
def test_error_for_a_renamed_method_states_the_new_name(owner):
    with pytest.raises(AttributeError, match=rf"^{owner.__name__}.to_json is now palpate\.arrays\.plain\.plain\("):
        owner.to_json  # noqa: B018


def test_error_for_a_renamed_method_may_state_another_method():
    with pytest.raises(
        AttributeError, match=r"^Radius\.to_json is now palpate\.contact\.touchable\.Radius\.figures\(\)$"
    ):
        Radius.to_json  # noqa: B018


@pytest.mark.parametrize(
    ("owner", "old", "new"), [(LiveViewer, "console", "control_panel"), (HapticSession, "told", "events")]
)
def test_error_for_a_renamed_attribute_states_the_new_name(owner, old, new):
    with pytest.raises(AttributeError, match=rf"^{owner.__name__}\.{old} is now {owner.__name__}\.{new}$"):
        getattr(owner, old)


def test_unknown_name_gives_an_ordinary_error():
    with pytest.raises(ModuleNotFoundError, match=r"No module named 'palpate\.nowhere'"):
        import_module("palpate.nowhere")
    with pytest.raises(AttributeError, match="no attribute 'nowhere'"):
        palpate.nowhere  # noqa: B018
