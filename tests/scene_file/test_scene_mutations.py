"""Random mutations of the shipped scenes: each mistake gives one message, in words of Palpate."""

import random
import re
from copy import deepcopy
from pathlib import Path

import pytest
import yaml
from effort import examples

from palpate.base.arrays.yaml_loader import Dumper
from palpate.base.errors import SceneError
from palpate.scene import Scene

SCENES = sorted((Path(__file__).parents[2] / "scenes").glob("*.yaml"))

#: Words of pydantic, nanobind and Python that mean nothing to the author of a scene.
FOREIGN = re.compile(
    r"pydantic|nanobind|incompatible|Input should|should be|Field required|Extra inputs|validation error|type=|ctx"
    r"|valid (number|integer|boolean|string|list|tuple|dictionary)|NoneType|Traceback|Error\b|tuple"
    r"|expected: |instance of"
)
VALUES = (
    -1,
    0,
    1e9,
    1.5,
    "soft",
    "3 ft",
    "3 mm",
    "",
    True,
    None,
    [],
    [1],
    ["a", 2, 3],
    [1, 2, 3, 4],
    {},
    {"a": 1},
    {1: 2},
)


def places(value, above=()):
    """Places of all values in a scene."""
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, inner in items:
        yield (*above, key)
        yield from places(inner, (*above, key))


def put(data, place, value):
    for key in place[:-1]:
        data = data[key]
    data[place[-1]] = value


def messages(data):
    """The errors of a scene with these values; none for a valid scene."""
    try:
        Scene.parse(yaml.dump(data, Dumper=Dumper), str(SCENES[0].with_name("s.yaml")))
    except SceneError as error:
        return [SceneError(error.what, where=error.where, why=error.why, mend=error.mend), *error.others]
    return []


def faults(error):
    """What is wrong with a message itself."""
    text = str(error)
    if match := FOREIGN.search(text):
        yield f"foreign word {match[0]!r}"
    if not error.mend:
        yield "no mend"
    if not re.search(r"s\.yaml:\d+$", error.where):
        yield f"no line: {error.where}"
    if error.why and error.mend and error.mend in error.why:
        yield "the mend repeats the description"


@pytest.mark.parametrize("path", SCENES, ids=lambda path: path.stem)
def test_mutated_scene_is_refused_in_own_words(path):
    chance = random.Random(path.name)
    text = path.read_text()
    all_places = list(places(yaml.safe_load(text)))
    valid = yaml.safe_load(text)
    for _ in range(examples(90)):
        data, place, value = deepcopy(valid), chance.choice(all_places), chance.choice(VALUES)
        put(data, place, value)
        found = messages(data)
        wrong = [fault for error in found for fault in faults(error)]
        assert not wrong, f"{place} = {value!r}: {wrong}\n" + "\n".join(map(str, found))


@pytest.mark.parametrize("path", SCENES, ids=lambda path: path.stem)
@pytest.mark.parametrize("value", ["soft", [[]]], ids=str)
def test_one_wrong_number_is_one_message(path, value):
    text = path.read_text()
    valid = data = yaml.safe_load(text)
    numbers = [p for p in places(data) if isinstance(_at(data, p), (int, float)) and not isinstance(_at(data, p), bool)]
    for place in random.Random(path.name).sample(numbers, min(12, len(numbers))):
        data = deepcopy(valid)
        put(data, place, value)
        found = messages(data)
        assert len(found) == 1, f"{place} = {value!r}:\n" + "\n".join(map(str, found))


def _at(data, place):
    for key in place:
        data = data[key]
    return data


@pytest.mark.parametrize(
    ("error", "fault"),
    [
        (SceneError("Input should be a valid number", where="s.yaml:3", mend="write it"), "foreign word"),
        (SceneError("x must be a number", where="s.yaml:3"), "no mend"),
        (SceneError("x must be a number", where="s.yaml", mend="write it"), "no line"),
        (SceneError("x", where="s.yaml:3", why="x: radius [m]", mend="radius [m]"), "repeats"),
    ],
)
def test_judge_of_messages_finds_each_fault(error, fault):
    assert any(fault in found for found in faults(error))
