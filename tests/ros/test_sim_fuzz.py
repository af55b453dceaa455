"""Random messages neither crash the simulated dVRK nor make its measurements non-finite."""

import array
import random
import re

import numpy as np
from dvrk_topics import ROWS

NUMBERS = [0.0, 1.0, -1.0, 0.05, 1e-9, 1e9, -1e308, float("nan"), float("inf"), float("-inf")]
WORDS = [
    "",
    "enable",
    "disable",
    "home",
    "pause",
    "resume",
    "align_MTM",
    "MTMR_PSM1",
    "LARGE_NEEDLE_DRIVER",
    "x" * 5000,
    "ä☃",
]
MESSAGES = 1500


def filled(kind, chance):
    """A message of a type with random fields."""
    from dvrk_client import message_type

    message = kind()
    for name, type_name in kind.get_fields_and_field_types().items():
        many = re.fullmatch(r"sequence<(.*)>", type_name)
        one = many[1] if many else type_name

        def value(one=one):
            if "/" in one:
                return filled(message_type(one), chance)
            if one in ("double", "float"):
                return chance.choice(NUMBERS)
            if one == "boolean":
                return chance.random() < 0.5
            if one == "string":
                return chance.choice(WORDS)
            return chance.randrange(-1, 3) if one.startswith("int") else chance.randrange(3)

        if not many:
            setattr(message, name, value())
        elif one == "double":
            setattr(message, name, array.array("d", (value() for _ in range(chance.choice([0, 1, 6, 7, 8, 40])))))
        else:
            setattr(message, name, [value() for _ in range(chance.choice([0, 1, 7]))])
    return message


def test_sim_survives_random_messages(start_once, node, until):
    from dvrk_client import Dvrk, message_type

    process = start_once("-m", "palpate", "ros", "sim", "--arms", "MTMR", "PSM1", "--rate", "200")
    while "Ctrl-C" not in (line := process.stdout.readline()):
        assert line, process.stderr.read()
    dvrk, chance = Dvrk(node, until), random.Random(6)
    dvrk.subscribe("/MTMR/operating_state", "/MTMR/measured_js", "/MTMR/local/measured_cp", "/PSM1/measured_js")
    topics = ("/MTMR/warning", "/MTMR_PSM1/warning", "/console/teleop/selected", "/PSM1/tool_type")
    dvrk.subscribe(*topics, wait=False)  # a message that cannot be decoded would end the test
    dvrk.home("MTMR")
    into = [(topic, message_type(row.type)) for topic, row in ROWS if row.direction == "in"]
    for n in range(MESSAGES):
        topic, kind = chance.choice(into)
        dvrk.publish(topic, filled(kind, chance))
        if n % 50 == 0:
            seen = dict(dvrk.count)
            until(lambda seen=seen: dvrk.count["/MTMR/measured_js"] > seen["/MTMR/measured_js"] + 5, "new measures")
            for arm in ("MTMR", "PSM1"):
                assert np.isfinite(dvrk.last[f"/{arm}/measured_js"].position).all()
            position = dvrk.last["/MTMR/local/measured_cp"].pose.position
            assert np.isfinite([position.x, position.y, position.z]).all()
    assert process.poll() is None
    process.terminate()
    _, err = process.communicate(timeout=20)
    assert process.returncode == 0
    assert err == ""
