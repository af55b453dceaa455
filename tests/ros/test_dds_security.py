"""Security that is asked for is on or nothing starts; a key may do what its role needs. No ROS is needed here."""

import subprocess
import sys
from fnmatch import fnmatchcase
from xml.etree import ElementTree

import pytest
from dvrk_topics import ROWS

from palpate.base import dds_security
from palpate.base.errors import PalpateError, RosMissingError
from palpate.ros import keystore, roles

NAMES = ("ENABLE", "STRATEGY", "KEYSTORE", "ENCLAVE_OVERRIDE")


@pytest.fixture(scope="module")
def store(tmp_path_factory):
    folder = tmp_path_factory.mktemp("keys") / "store"
    keystore.make(folder, ("/palpate/haptics", "/palpate/camera", "/palpate/sim", "/lab/left=watch", "/lab/me=all"))
    return folder


@pytest.fixture
def asked(monkeypatch, store):
    """A function that sets the variables, given those that differ from the right ones; None removes one."""

    def ask(**changes):
        right = {"ENABLE": "true", "STRATEGY": "Enforce", "KEYSTORE": str(store), "ENCLAVE_OVERRIDE": "/palpate/camera"}
        for name, value in (right | changes).items():
            if value is None:
                monkeypatch.delenv(f"ROS_SECURITY_{name}", raising=False)
            else:
                monkeypatch.setenv(f"ROS_SECURITY_{name}", value)

    return ask


@pytest.mark.parametrize("enable", ["true", "True", "TRUE", "1", "yes", "On", " true "])
@pytest.mark.parametrize("strategy", ["Enforce", "enforce", "ENFORCE", None, "", "Permissive"])
def test_any_spelling_asks_for_it(asked, enable, strategy):
    import os

    asked(ENABLE=enable, STRATEGY=strategy)
    assert dds_security.enforce()
    assert (os.environ["ROS_SECURITY_ENABLE"], os.environ["ROS_SECURITY_STRATEGY"]) == ("true", "Enforce")


@pytest.mark.parametrize("enable", [None, "", "false", "FALSE", "0", "no", "off"])
def test_nothing_is_asked_for(asked, enable):
    asked(ENABLE=enable, KEYSTORE="/nowhere")
    assert not dds_security.enforce()


@pytest.mark.parametrize("enable", ["true", "True", "1"])
@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"KEYSTORE": "/nowhere/keys"}, "no keys for /palpate/camera"),
        ({"KEYSTORE": "/nowhere/keys", "STRATEGY": None}, "no keys"),
        ({"KEYSTORE": None}, "KEYSTORE is not set"),
        ({"ENCLAVE_OVERRIDE": None}, "no enclave is named"),
        ({"ENCLAVE_OVERRIDE": "/palpate/nobody", "STRATEGY": None}, "no keys for /palpate/nobody"),
        ({"ENCLAVE_OVERRIDE": "/palpate"}, "cert.pem"),
        ({"STRATEGY": "Enfroce"}, "Enfroce is unknown"),
    ],
)
def test_wrong_keys_are_refused(asked, enable, changes, words):
    asked(ENABLE=enable, **changes)
    with pytest.raises(RosMissingError, match=words) as refused:
        dds_security.enforce()
    assert refused.value.mend


def test_a_word_that_is_neither_is_refused(asked):
    asked(ENABLE="ture")
    with pytest.raises(RosMissingError, match="ture is neither true nor false"):
        dds_security.enforce()


def test_a_middleware_without_plug_ins_is_told_with_what_to_install(asked, tmp_path, monkeypatch):
    asked(ENABLE="1")
    monkeypatch.delenv("RMW_IMPLEMENTATION", raising=False)
    (tmp_path / "libfastdds.so").write_bytes(b"\x7fELF no plug-ins")
    with pytest.raises(RosMissingError, match=r"no security plug-ins[\s\S]*install a ROS 2"):
        dds_security.enforce([tmp_path])
    (tmp_path / "libfastdds.so").write_bytes(b"\x7fELF DDS:Auth:PKI-DH:1.0")
    assert dds_security.enforce([tmp_path])
    (tmp_path / "libfastdds.so").write_bytes(b"\x7fELF no plug-ins")
    monkeypatch.setenv("RMW_IMPLEMENTATION", "rmw_cyclonedds_cpp")
    assert dds_security.enforce([tmp_path])


@pytest.mark.parametrize("command", [["sim", "--arms", "MTMR"], ["topic", "list"], ["graph"]])
def test_commands_end_with_words_and_no_traceback(command, tmp_path):
    import os

    variables = {"ROS_SECURITY_ENABLE": "True", "ROS_SECURITY_KEYSTORE": str(tmp_path / "wrong")}
    done = subprocess.run(
        [sys.executable, "-m", "palpate", "ros", *command], env=os.environ | variables, capture_output=True, text=True,
        timeout=120, check=False,
    )  # fmt: skip
    assert done.returncode == 2, done.stdout + done.stderr
    assert "DDS security is asked for" in done.stderr
    assert "Traceback" not in done.stderr


def allowed(store, enclave):
    """Patterns that a signed document lets an enclave publish, and hear."""
    tree = ElementTree.fromstring((store / "enclaves" / enclave / "permissions.xml").read_bytes())
    return [[topic.text for topic in tree.findall(f".//{kind}/topics/topic")] for kind in ("publish", "subscribe")]


def may(patterns, topic):
    return any(fnmatchcase(topic, pattern) for pattern in patterns)


COMMANDS = [topic for topic, row in ROWS if row.direction == "in"]
MEASURES = [topic for topic, row in ROWS if row.direction == "out"]


def test_a_camera_moves_no_hand(store):
    said, heard = allowed(store, "palpate/camera")
    assert may(said, "rt/camera/depth/points")
    assert may(said, "rt/tf_static")
    for topic in (*COMMANDS, *MEASURES, "/MTMR/following/mtm/body/servo_cf", "/palpate/resume"):
        assert not may(said, f"rt{topic}"), topic
    assert not may(heard, "rt/MTMR/measured_cp")
    assert not any(pattern == "*" or pattern == "rt/*" for pattern in (*said, *heard))


def test_the_haptic_node_writes_its_wrench_and_not_the_robot_s_states(store):
    said, heard = allowed(store, "palpate/haptics")
    for topic in ("MTMR_PSM1/following/mtm/body/servo_cf", "MTMR/body/servo_cf", "PSM1/servo_cp", "diagnostics", "tf"):
        assert may(said, f"rt/{topic}")
    for topic in ("MTMR/measured_cp", "MTMR/operating_state", "console/operator_present", "MTMR/state_command",
                  "PSM1/move_jp", "MTMR/free", "system/power_on"):  # fmt: skip
        assert not may(said, f"rt/{topic}"), topic
    needed = (
        "MTMR/measured_cp",
        "MTMR/gripper/measured_js",
        "PSM1/operating_state",
        "console/clutch",
        "console/camera",
    )
    for topic in (*needed, "MTMR_PSM1/following", "MTMR_PSM1/scale", "footpedals/coag", "PSM1/tool_type"):
        assert may(heard, f"rt/{topic}"), topic


def test_the_robot_publishes_its_measures_and_takes_commands_alone(store):
    said, heard = allowed(store, "palpate/sim")
    assert [topic for topic in MEASURES if not may(said, f"rt{topic}")] == []
    assert [topic for topic in COMMANDS if not may(heard, f"rt{topic}")] == []
    shared = set(MEASURES)
    assert [topic for topic in COMMANDS if may(said, f"rt{topic}") and topic not in shared] == []


def test_who_watches_publishes_nothing(store):
    said, heard = allowed(store, "lab/left")
    assert {one.removeprefix("rt/") for one in said} == {"ros_discovery_info", "rosout", "parameter_events", "clock"}
    assert may(heard, "rt/MTMR/measured_cp")
    assert may(allowed(store, "lab/me")[0], "rt/MTMR/servo_cp")


def test_the_exported_folder_holds_no_key_of_the_authority(store):
    authority = store.with_name("store-authority")
    private = (authority / "ca.key.pem").read_bytes()
    assert not [file for file in store.rglob("*") if file.is_file() and private in file.read_bytes()]
    assert not list(store.rglob("*ca.key*"))
    assert authority.stat().st_mode & 0o077 == 0
    assert (authority / "ca.key.pem").stat().st_mode & 0o077 == 0
    keys = [file.read_bytes() for file in store.rglob("key.pem")]
    assert len(set(keys)) == 5


def test_a_keystore_of_before_gives_its_authority_away_and_goes_on(tmp_path):
    old = tmp_path / "old"
    keystore.make(old, ("/a/sim",))
    (old / "private").mkdir()
    authority = tmp_path / "old-authority"
    (authority / "ca.key.pem").rename(old / "private" / "ca.key.pem")
    (authority / "ca.cert.pem").unlink()
    before = (old / "enclaves" / "a" / "sim" / "key.pem").read_bytes()
    keystore.make(old, ("/a/sim", "/a/camera"))
    assert (old / "enclaves" / "a" / "sim" / "key.pem").read_bytes() == before
    assert not (old / "private").exists()
    for name in ("sim", "camera"):
        place = old / "enclaves" / "a" / name
        done = subprocess.run(
            ["openssl", "verify", "-CAfile", place / "identity_ca.cert.pem", place / "cert.pem"],
            capture_output=True, text=True, check=False,
        )  # fmt: skip
        assert "OK" in done.stdout


def test_a_keystore_without_its_authority_takes_no_new_enclave(tmp_path):
    import shutil

    keystore.make(tmp_path / "keys", ("/a/sim",))
    shutil.rmtree(tmp_path / "keys-authority")
    with pytest.raises(PalpateError, match="has no key here"):
        keystore.make(tmp_path / "keys", ("/a/camera",))
    with pytest.raises(PalpateError, match="must not lie in the keystore"):
        keystore.make(tmp_path / "keys", ("/a/camera",), tmp_path / "keys" / "private")


@pytest.mark.parametrize("name", ["/palpate/leader", "/a/b=boss", "/a=", "/x"])
def test_an_unknown_role_is_refused_with_those_that_are_known(name, tmp_path):
    with pytest.raises(PalpateError, match=r"is no role[\s\S]*camera: a camera"):
        keystore.make(tmp_path / "keys", (name,))
    assert set(roles.WORDS) == set(roles.roles())
