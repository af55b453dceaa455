"""The bridge itself: messages there and back between processes, type hashes, discovery, building, errors."""

import hashlib
import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from palpate.errors import RosMissingError
from palpate.ros import build, where

ECHO = """
import sys, palpate.ros
ros = palpate.ros.load()
context = ros.Context()
echo = ros.Echo(context, "/there", "/back")
print("ready", flush=True)
sys.stdin.read()
print(echo.count, flush=True)
"""


def test_echo_between_processes(start, rclpy, node, until):
    from geometry_msgs.msg import WrenchStamped
    from rclpy.subscription import RCLError

    def publish():
        """Once more where the middleware could not: a sender that a busy machine keeps waiting gives up after 0.1 s."""
        try:
            there.publish(message)
        except RCLError:
            return False
        return True

    echo = start("-c", ECHO)
    assert echo.stdout.readline() == "ready\n"
    heard = []
    node.create_subscription(WrenchStamped, "/back", heard.append, 10)
    there = node.create_publisher(WrenchStamped, "/there", 10)
    until(lambda: there.get_subscription_count() and node.count_publishers("/back"), "discovery")
    message = WrenchStamped()
    message.header.frame_id = "MTMR"
    message.wrench.force.z = 1.5
    until(lambda: publish() and heard, "an echo")
    for n in range(20):
        message.wrench.torque.x = float(n)
        until(publish, "a message sent")
    until(lambda: heard[-1].wrench.torque.x == 19.0, "the last echo")
    assert heard[-1].header.frame_id == "MTMR"
    assert heard[-1].wrench.force.z == 1.5
    out, err = echo.communicate(timeout=20)
    assert int(out) >= 20, err
    assert echo.returncode == 0


THREADS = """
import os, time, palpate.ros
from pathlib import Path
ros = palpate.ros.load()
echo = ros.Echo(ros.Context(), "/there", "/back")
fifo = {(t / "comm").read_text().strip(): os.sched_getscheduler(int(t.name)) == os.SCHED_FIFO
        for t in Path("/proc/self/task").iterdir()}
print(all(on for name, on in fifo.items() if name.startswith(("dds.shm.", "dds.udp.", "dds.ev."))), end=" ")
print(any(on for name, on in fifo.items() if name.startswith("dds.asyn")))
"""


def test_what_brings_messages_goes_before_a_busy_machine(built):
    """Fast DDS' receivers are raised; its asynchronous senders, which would wait awake for normal threads, are not."""
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(1))
        os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))
    except PermissionError:
        pytest.skip("this system refuses SCHED_FIFO")
    told = subprocess.run([sys.executable, "-c", THREADS], capture_output=True, text=True, timeout=60)
    assert told.stdout == "True False\n", told.stderr


IDLE = """
import sys, time, palpate.ros
ros = palpate.ros.load()
echo = ros.Echo(ros.Context(), "/there", "/back")
print("ready", flush=True)
sys.stdin.readline()
before = time.process_time()
time.sleep(1.0)
print(echo.count, time.process_time() - before, flush=True)
"""


def test_who_is_told_of_messages_sleeps_between_them(start, rclpy, node, until):
    from geometry_msgs.msg import WrenchStamped

    echo = start("-c", IDLE)
    assert echo.stdout.readline() == "ready\n"
    heard = []
    node.create_subscription(WrenchStamped, "/back", heard.append, 10)
    there = node.create_publisher(WrenchStamped, "/there", 10)
    until(lambda: there.get_subscription_count() and node.count_publishers("/back"), "discovery")
    until(lambda: there.publish(WrenchStamped()) or heard, "an echo")
    echo.stdin.write("\n")
    echo.stdin.flush()
    count, used = echo.stdout.readline().split()
    assert int(count) > 0
    assert float(used) < 0.3, "a second in which nothing came"


CLIENT = """
import rclpy
from crtk_msgs.msg import StringStamped
from crtk_msgs.srv import QueryForwardKinematics
rclpy.init()
node = rclpy.create_node("client")
node.create_publisher(StringStamped, "/MTMR/state_command", 1)
node.create_client(QueryForwardKinematics, "/MTMR/forward_kinematics")
print("palpate" in __import__("sys").modules)
"""


def test_a_client_that_knows_nothing_of_palpate_has_the_messages(built):
    if built.ros.kind == "sourced":
        pytest.skip("a sourced ROS 2 is not ours to add packages to")
    told = subprocess.run([sys.executable, "-c", CLIENT], capture_output=True, text=True, timeout=60)
    assert told.stdout == "False\n", told.stderr


def hash_of(description):
    """RIHS01, by its definition: SHA-256 over the type's description as JSON in fixed form, without default values."""

    def field(told):
        kind = {k: told["type"][k] for k in ("type_id", "capacity", "string_capacity", "nested_type_name")}
        return {"name": told["name"], "type": kind}

    def one(told):
        return {"type_name": told["type_name"], "fields": [field(f) for f in told["fields"]]}

    told = {
        "type_description": one(description["type_description"]),
        "referenced_type_descriptions": [one(d) for d in description["referenced_type_descriptions"]],
    }
    text = json.dumps(told, separators=(", ", ": "), sort_keys=False)
    return "RIHS01_" + hashlib.sha256(text.encode()).hexdigest()


def generated(prefix, package, kind, name):
    """Description and hash as the generators wrote them."""
    told = json.loads((prefix / "share" / package / kind / f"{name}.json").read_text())
    hashes = {t["type_name"]: t["hash_string"] for t in told["type_hashes"]}
    return told["type_description_msg"], hashes[f"{package}/{kind}/{name}"]


def test_type_hash_by_definition(built):
    """The same sum over the same words gives the hashes of ROS 2's own types and of ours."""
    cases = [("geometry_msgs", "msg", "WrenchStamped"), ("sensor_msgs", "msg", "JointState")]
    cases += [("crtk_msgs", "msg", p.stem) for p in (build.HERE / "messages" / "crtk_msgs" / "msg").iterdir()]
    cases += [("tf2_msgs", "msg", "TFMessage")]
    for package, kind, name in cases:
        prefix = built.messages.get(package, built.ros.prefixes[0])
        description, told = generated(prefix, package, kind, name)
        assert hash_of(description) == told, name


UINT8, BOOL, STRING = 3, 15, 17  # as type descriptions count them
HALF_PLANES = ("position_positive", "position_negative", "orientation_positive", "orientation_negative")
FIELDS = {  # crtk_msgs 1.3.0 as published, written out once more
    "OperatingState": [("header", "Header"), ("state", STRING), ("is_homed", BOOL), ("is_busy", BOOL)],
    "StringStamped": [("header", "Header"), ("string", STRING)],
    "SetpointMode": [("value", UINT8)],
    "CartesianState": [
        ("header", "Header"),
        *(("pose", "Pose"), ("pose_is_valid", "Bool")),
        *(("twist", "Twist"), ("twist_is_valid", "Bool")),
        *(("wrench", "Wrench"), ("wrench_is_valid", "Bool")),
    ],
    "CartesianImpedanceHalfPlaneGains": [(name, "Vector3") for name in ("p", "d", "bias", "deadband")],
    "CartesianImpedance": [
        ("header", "Header"),
        ("force_orientation", "Quaternion"),
        ("force_position", "Vector3"),
        ("torque_orientation", "Quaternion"),
        *((name, "CartesianImpedanceHalfPlaneGains") for name in HALF_PLANES),
    ],
}


@pytest.mark.parametrize("name", FIELDS)
def test_crtk_types_have_the_published_fields(built, name):
    description, _ = generated(built.messages["crtk_msgs"], "crtk_msgs", "msg", name)
    fields = description["type_description"]["fields"]
    told = [(f["name"], f["type"]["nested_type_name"].split("/")[-1] or f["type"]["type_id"]) for f in fields]
    assert told == FIELDS[name]


def test_local_discovery_unless_asked(native, monkeypatch):
    """What the environment says does not open the network; only the option does."""

    def environment(name):
        """As C sees it, and hands it on."""
        return subprocess.run(["printenv", name], capture_output=True, text=True, check=False).stdout.strip()

    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "SUBNET")
    monkeypatch.setenv("ROS_STATIC_PEERS", "10.0.0.1")
    assert not native.Context().network
    assert environment("ROS_AUTOMATIC_DISCOVERY_RANGE") == "LOCALHOST"
    assert environment("ROS_STATIC_PEERS") == ""
    assert native.Context(network=True).network
    assert environment("ROS_AUTOMATIC_DISCOVERY_RANGE") == "SUBNET"
    assert environment("ROS_DOMAIN_ID") == str(native.Context().domain)


def test_bad_arguments_are_told(native):
    with pytest.raises(native.RosError, match="cannot start ROS"):
        native.Context(arguments=["-r", "no remap"])
    with pytest.raises(native.RosError, match=r"cannot (listen to|publish) /a b"):
        native.Echo(native.Context(), "/a b", "/a b")


def test_no_ros_is_told(monkeypatch):
    monkeypatch.delenv("AMENT_PREFIX_PATH", raising=False)
    monkeypatch.setattr(where.importlib.util, "find_spec", lambda name: None)
    with pytest.raises(RosMissingError, match=r"ROS 2 is not here(.|\n)*make setup(.|\n)*setup.bash"):
        where.find()


def test_no_compiler_is_told(monkeypatch, tmp_path, built):
    monkeypatch.setenv("CXX", "no-such-compiler")
    with pytest.raises(RosMissingError, match=r"the ROS 2 nodes cannot be compiled(.|\n)*apt install g\+\+"):
        build._cmake(built.ros, tmp_path, tmp_path / "build", {}, "the ROS 2 nodes")


def test_what_does_not_compile_is_told(monkeypatch, tmp_path, built):
    lines = ("cmake_minimum_required(VERSION 3.22)", "project(x LANGUAGES NONE)", 'message(FATAL_ERROR "no rain")')
    (tmp_path / "CMakeLists.txt").write_text("\n".join(lines))
    with pytest.raises(RosMissingError, match=r"no rain(.|\n)*palpate ros setup"):
        build._cmake(built.ros, tmp_path, tmp_path / "build", {}, "it")


def test_sourced_ros_wins(monkeypatch, tmp_path, built):
    """A prefix laid out as a sourced ROS 2 is; the message packages it lacks are looked for, and made, for it."""
    wheels = built.ros.prefixes[0]
    for part in ("include", "lib", "share"):
        (tmp_path / part).symlink_to(wheels / part)
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(tmp_path))
    found = where.find()
    assert found.kind == "sourced"
    assert found.prefixes == (tmp_path,)
    assert "sourced" in found.words
    assert found.release == built.ros.release
    assert found.environment()["AMENT_PREFIX_PATH"] == str(tmp_path)
    assert Path(found.python()).is_file()


def test_setup_says_what_it_uses(built):
    done = subprocess.run([sys.executable, "-m", "palpate", "ros", "setup"], capture_output=True, text=True, check=True)
    assert built.ros.words in done.stdout
    assert "crtk_msgs: compiled by Palpate" in done.stdout
    assert "everything was compiled already" in done.stdout


def test_two_releases_do_not_mix(monkeypatch, tmp_path, built):
    """Beside the wheels, the process begins anew with the sourced libraries alone, once."""
    begun = []
    monkeypatch.setattr(where.os, "execve", lambda *call: begun.append(call))
    where.settle()
    assert begun == []  # nothing is sourced
    wheels = where._wheel_libraries()
    (tmp_path / "include" / "rcl").mkdir(parents=True)
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(tmp_path))
    monkeypatch.setenv("LD_LIBRARY_PATH", ":".join([*wheels, "/opt/other"]))
    where.settle()
    [(program, arguments, environment)] = begun
    assert (program, arguments) == (sys.executable, sys.orig_argv)
    assert environment["LD_LIBRARY_PATH"] == f"{tmp_path / 'lib'}:/opt/other"
    monkeypatch.setenv("LD_LIBRARY_PATH", environment["LD_LIBRARY_PATH"])
    where.settle()
    assert len(begun) == 1
