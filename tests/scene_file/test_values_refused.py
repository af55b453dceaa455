"""Numbers of scene files are refused unless they are finite numbers of the stated sign; text is not a number."""

import math

import numpy as np
import pytest
from pydantic import TypeAdapter, ValidationError

from palpate.base import values
from palpate.base.values import units
from palpate.base.values.descriptions import descriptions, unit_of

ANY = ["Number", "Positive", "NotNegative"]


def accepted(alias, value):
    try:
        found = TypeAdapter(getattr(values, alias)).validate_python(value)
    except ValidationError:
        return False
    assert found == value
    return True


@pytest.mark.parametrize("alias", ANY)
@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf, True, None, [1.0], "one"])
def test_what_is_no_finite_number_is_refused(alias, value):
    assert not accepted(alias, value)


@pytest.mark.parametrize("alias", ANY)
def test_signs(alias):
    assert accepted(alias, 0.5)
    assert accepted(alias, 0.0) == (not alias.startswith("Positive"))
    assert accepted(alias, -0.5) == (alias == "Number")


@pytest.mark.parametrize("alias", ["Number", "Positive", "NotNegative"])
def test_text_is_no_number(alias):
    assert not accepted(alias, "0.5")


SIZES = {
    "m": {"um": 1e-6, "mm": 1e-3, "cm": 1e-2, "m": 1.0, "in": 0.0254},
    "kg": {"kg": 1.0, "g": 1e-3},
    "s": {"s": 1.0, "ms": 1e-3, "us": 1e-6, "min": 60.0},
    "rad": {"rad": 1.0, "mrad": 1e-3, "deg": math.pi / 180.0},
    "1/s": {"Hz": 1.0, "kHz": 1e3},
    "kg m/s^2": {"N": 1.0, "mN": 1e-3, "kN": 1e3},
    "kg m^2/s^2": {"J": 1.0, "mJ": 1e-3, "uJ": 1e-6, "Nm": 1.0, "Nmm": 1e-3},
    "kg m/s": {"Ns": 1.0},
    "kg/m s^2": {"Pa": 1.0, "kPa": 1e3, "MPa": 1e6, "GPa": 1e9},
}


def test_every_unit_has_its_size_and_its_dimension():
    """Reference: the definitions in base units of the SI."""
    assert {name for names in SIZES.values() for name in names} == set(units._UNITS)
    for base, names in SIZES.items():
        target = "Hz" if base == "1/s" else base
        for name, size in names.items():
            assert units.convert(f"2 {name}", target) == pytest.approx(2.0 * size, rel=1e-12), name
            for other in SIZES.keys() - {base, "1/s"}:
                assert units.convert(f"2 {name}", other) is None, (name, other)


def test_a_rate_is_the_inverse_of_a_time():
    for size, name in ((1.0, "Hz"), (1e3, "kHz")):
        assert units.convert(f"3 mm {name}", "m/s") == pytest.approx(3e-3 * size, rel=1e-12)
        assert units.convert(f"3 m {name}", "m s") is None


def test_a_pose_is_a_homogeneous_matrix():
    X = values.Pose(xyz=(1.0, 2.0, 3.0), rpy_deg=(0.0, 0.0, 90.0)).matrix()
    assert pytest.approx(np.array([[0, -1, 0, 1], [1, 0, 0, 2], [0, 0, 1, 3], [0, 0, 0, 1.0]]), abs=1e-15) == X


@pytest.mark.parametrize(
    ("unit", "names"),
    [
        *(("m", "um, mm, cm, m, in"), ("m, rad", "um, mm, cm, m, in")),
        *(("rad", "rad, mrad, deg"), ("N/m", "N/m"), ("furlong", "furlong")),
    ],
)
def test_other_ways_to_write_a_unit(unit, names):
    assert units.examples(unit) == names


@pytest.mark.parametrize(("unit", "known"), [("m", True), ("rad, m", True), ("rad, furlong", False), ("%", False)])
def test_a_unit_is_known_if_all_its_alternatives_are(unit, known):
    assert units.is_known(unit) == known


def test_a_colour_is_read_digit_by_digit():
    read = TypeAdapter(values.Color).validate_python
    assert read("#0a1bff") == read([10, 27, 255]) == (10, 27, 255)
    assert read("#000000") == read([0, 0, 0]) == (0, 0, 0)
    for wrong in ("#0a1bf", "#0a1bff0", "#0g1bff", [0, 0, 256], [-1, 0, 0], [0, 0]):
        with pytest.raises(ValidationError):
            read(wrong)


def test_the_schema_states_the_ranges_of_stiffness_and_colour():
    three = TypeAdapter(values.Diagonal).json_schema()["anyOf"]
    assert three == [{"type": "number", "minimum": 0}, {"type": "array", "items": {"type": "number", "minimum": 0},
                                                        "minItems": 3, "maxItems": 3}]  # fmt: skip
    text, numbers = TypeAdapter(values.Color).json_schema()["anyOf"]
    assert text == {"type": "string", "pattern": "^#[0-9a-fA-F]{6}$"}
    assert numbers == {"type": "array", "items": {"type": "integer", "minimum": 0, "maximum": 255},
                       "minItems": 3, "maxItems": 3}  # fmt: skip


@pytest.mark.parametrize("module", ["palpate.base.values", "builtins"])
def test_a_section_without_source_has_no_descriptions(module):
    """A class made at run time: its module has no such class (OSError), or no file (TypeError)."""
    made = type(f"Made{module[0]}", (values.Section,), {"__module__": module, "__annotations__": {"x": int}})
    assert descriptions(made) == {}
    assert unit_of(made, "x") == ""
