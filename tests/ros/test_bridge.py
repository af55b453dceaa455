"""The ROS 2 layer: round trips between processes, type hashes, discovery, compilation, errors."""

import hashlib
import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
import warm

from palpate.base.errors import RosMissingError
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
        """Publish, and repeat if the middleware fails: on a busy machine a publisher gives up after 0.1 s."""
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


def test_receiving_threads_have_real_time_priority(built):
    """Receivers of Fast DDS are raised; its asynchronous senders, which spin while they wait, are not."""
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(1))
        os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))
    except PermissionError:
        pytest.skip("this system refuses SCHED_FIFO")
    done = subprocess.run([sys.executable, "-c", THREADS], capture_output=True, text=True, timeout=60)
    assert done.stdout == "True False\n", done.stderr


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


def test_direct_spinner_sleeps_between_messages(start, rclpy, node, until):
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
    assert float(used) < 0.3, "CPU time of a second without messages"


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


def test_messages_are_importable_without_palpate(built):
    if built.ros.kind == "sourced":
        pytest.skip("packages cannot be added to a sourced ROS 2")
    with warm.cold():
        done = subprocess.run([sys.executable, "-c", CLIENT], capture_output=True, text=True, timeout=60)
    assert done.stdout == "False\n", done.stderr


def hash_of(description):
    """RIHS01 by definition: SHA-256 of the type description as JSON in a fixed form, without default values."""

    def field(described):
        kind = {k: described["type"][k] for k in ("type_id", "capacity", "string_capacity", "nested_type_name")}
        return {"name": described["name"], "type": kind}

    def one(described):
        return {"type_name": described["type_name"], "fields": [field(f) for f in described["fields"]]}

    described = {
        "type_description": one(description["type_description"]),
        "referenced_type_descriptions": [one(d) for d in description["referenced_type_descriptions"]],
    }
    text = json.dumps(described, separators=(", ", ": "), sort_keys=False)
    return "RIHS01_" + hashlib.sha256(text.encode()).hexdigest()


def generated(prefix, package, kind, name):
    """Description and hash of a type from the files of the generators."""
    described = json.loads((prefix / "share" / package / kind / f"{name}.json").read_text())
    hashes = {t["type_name"]: t["hash_string"] for t in described["type_hashes"]}
    return described["type_description_msg"], hashes[f"{package}/{kind}/{name}"]


def test_type_hash_by_definition(built):
    """The same function gives the hashes of the types of ROS 2 and of our packages."""
    cases = [("geometry_msgs", "msg", "WrenchStamped"), ("sensor_msgs", "msg", "JointState")]
    cases += [("crtk_msgs", "msg", p.stem) for p in (build.HERE / "messages" / "crtk_msgs" / "msg").iterdir()]
    cases += [("tf2_msgs", "msg", "TFMessage")]
    for package, kind, name in cases:
        prefix = built.messages.get(package, built.ros.prefixes[0])
        description, expected = generated(prefix, package, kind, name)
        assert hash_of(description) == expected, name


UINT8, BOOL, STRING = 3, 15, 17  # type ids of type descriptions
HALF_PLANES = ("position_positive", "position_negative", "orientation_positive", "orientation_negative")
FIELDS = {  # crtk_msgs 1.3.0 as published
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
    listed = [(f["name"], f["type"]["nested_type_name"].split("/")[-1] or f["type"]["type_id"]) for f in fields]
    assert listed == FIELDS[name]


def test_discovery_is_local_unless_the_network_is_enabled(native, monkeypatch):
    """Only the option enables the network, not the environment."""

    def environment(name):
        """Value of an environment variable in C."""
        return subprocess.run(["printenv", name], capture_output=True, text=True, check=False).stdout.strip()

    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "SUBNET")
    monkeypatch.setenv("ROS_STATIC_PEERS", "10.0.0.1")
    assert not native.Context().network
    assert environment("ROS_AUTOMATIC_DISCOVERY_RANGE") == "LOCALHOST"
    assert environment("ROS_STATIC_PEERS") == ""
    assert native.Context(network=True).network
    assert environment("ROS_AUTOMATIC_DISCOVERY_RANGE") == "SUBNET"
    assert environment("ROS_DOMAIN_ID") == str(native.Context().domain)


def test_invalid_arguments_are_reported(native):
    with pytest.raises(native.RosError, match="cannot start ROS"):
        native.Context(arguments=["-r", "no remap"])
    with pytest.raises(native.RosError, match=r"cannot (listen to|publish) /a b"):
        native.Echo(native.Context(), "/a b", "/a b")


def test_missing_ros_is_reported(monkeypatch):
    monkeypatch.delenv("AMENT_PREFIX_PATH", raising=False)
    monkeypatch.setattr(where.importlib.util, "find_spec", lambda name: None)
    with pytest.raises(RosMissingError, match=r"ROS 2 is not here(.|\n)*make setup(.|\n)*setup.bash"):
        where.find()


def test_missing_compiler_is_reported(monkeypatch, tmp_path, built):
    monkeypatch.setenv("CXX", "no-such-compiler")
    with pytest.raises(RosMissingError, match=r"the ROS 2 nodes cannot be compiled(.|\n)*apt install g\+\+"):
        build._cmake(built.ros, tmp_path, tmp_path / "build", {}, "the ROS 2 nodes")


def test_compiler_error_is_reported(monkeypatch, tmp_path, built):
    lines = ("cmake_minimum_required(VERSION 3.22)", "project(x LANGUAGES NONE)", 'message(FATAL_ERROR "no rain")')
    (tmp_path / "CMakeLists.txt").write_text("\n".join(lines))
    with pytest.raises(RosMissingError, match=r"no rain(.|\n)*palpate ros setup"):
        build._cmake(built.ros, tmp_path, tmp_path / "build", {}, "it")


def test_sourced_ros_takes_precedence(monkeypatch, tmp_path, built):
    """A prefix with the layout of a sourced ROS 2: its missing message packages are searched and compiled."""
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


def test_setup_prints_the_ros_it_uses(built):
    done = subprocess.run([sys.executable, "-m", "palpate", "ros", "setup"], capture_output=True, text=True, check=True)
    assert built.ros.words in done.stdout
    assert "crtk_msgs: compiled by Palpate" in done.stdout
    assert "everything was compiled already" in done.stdout


def test_two_releases_are_not_mixed(monkeypatch, tmp_path, built):
    """With wheels installed, the process restarts once with only the sourced libraries."""
    begun = []
    monkeypatch.setattr(where.os, "execve", lambda *call: begun.append(call))
    where.settle()
    assert begun == []  # no sourced ROS 2
    wheels = where._wheel_libraries()
    with monkeypatch.context() as own:  # the wheels' own prefix is none: it was restarted without end
        own.setenv("AMENT_PREFIX_PATH", sys.prefix)
        own.setenv("LD_LIBRARY_PATH", ":".join(wheels))
        where.settle()
    assert begun == []
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
