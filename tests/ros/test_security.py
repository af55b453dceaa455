"""DDS security (SROS 2): the keystore is judged by openssl; nodes run with it where the middleware has it built in.

The `ros-*` wheels' Fast DDS is built without the security plug-ins: there the promise is that nothing starts
unprotected when protection is asked for.
"""

import os
import subprocess
import sys
import time

import pytest

from palpate.errors import PalpateError
from palpate.ros import keystore

NODE = """
import sys, time
from palpate import ros
native = ros.load()
try:
    echo = native.Echo(native.Context(), "/there_secure", "/back_secure")
except native.RosError as error:
    print("refused:", " ".join(str(error).split()), flush=True)
    sys.exit(3)
print("up", flush=True)
sys.stdin.read()
"""


@pytest.fixture(scope="module")
def store(tmp_path_factory):
    folder = tmp_path_factory.mktemp("keys") / "keystore"
    keystore.make(folder, ("/palpate/haptics", "/palpate/leader"))
    return folder


def openssl(*arguments):
    return subprocess.run(["openssl", *map(str, arguments)], capture_output=True, text=True, check=False)


@pytest.mark.parametrize("enclave", ["palpate/haptics", "palpate/leader"])
def test_keys_and_documents_are_those_of_the_authority(store, enclave, tmp_path):
    place, ca = store / "enclaves" / enclave, store / "public" / "ca.cert.pem"
    assert "OK" in openssl("verify", "-CAfile", ca, place / "cert.pem").stdout
    subject = openssl("x509", "-in", place / "cert.pem", "-noout", "-subject", "-nameopt", "RFC2253").stdout
    assert f"CN=/{enclave}" in subject.strip()
    for document in ("permissions.p7s", "governance.p7s"):
        done = openssl("smime", "-verify", "-text", "-in", place / document, "-CAfile", ca, "-out", tmp_path / "told")
        assert done.returncode == 0, done.stderr
        assert "<dds" in (tmp_path / "told").read_text()
    tampered = tmp_path / "tampered.p7s"
    tampered.write_text((place / "permissions.p7s").read_text().replace("DENY", "ALLOW"))
    assert openssl("smime", "-verify", "-text", "-in", tampered, "-CAfile", ca, "-out", os.devnull).returncode != 0
    assert (place / "key.pem").stat().st_mode & 0o077 == 0


def test_a_name_that_is_no_enclave_is_refused(tmp_path):
    with pytest.raises(PalpateError, match="is no enclave"):
        keystore.make(tmp_path, ("../elsewhere",))


@pytest.fixture(scope="module")
def protected(built, store):
    """Starts a node with these variables; answers the process and its first line."""
    running = []

    def start(**variables):
        process = subprocess.Popen(
            [sys.executable, "-c", NODE], env=os.environ | variables, stdin=subprocess.PIPE, stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL, text=True,
        )  # fmt: skip
        running.append(process)
        return process, process.stdout.readline()

    yield start
    for process in running:
        process.kill()
        process.wait()


def test_what_asks_for_protection_never_runs_without(protected, store):
    """With Enforce and no keys of its own a node does not start, whatever the middleware can."""
    variables = keystore.environment(store, "/palpate/nobody")
    process, line = protected(**variables)
    assert line.startswith("refused:"), line
    assert process.wait(20) == 3


def test_who_has_no_keys_is_not_heard(protected, store, node, rclpy):
    """Two nodes of one authority talk; this process, without keys, sees none of their topics."""
    process, line = protected(**keystore.environment(store, "/palpate/haptics"))
    if line.startswith("refused:") and "security" in line:
        assert process.wait(20) == 3
        pytest.skip("this Fast DDS is built without security plug-ins (so are the ros-* wheels): it refuses to start")
    assert line == "up\n"
    end = time.monotonic() + 5.0
    while time.monotonic() < end:
        rclpy.spin_once(node, timeout_sec=0.05)
        assert not node.get_publishers_info_by_topic("/back_secure")
    client = [sys.executable, "-c", PEER]
    done = subprocess.run(
        client, env=os.environ | keystore.environment(store, "/palpate/leader"), capture_output=True, text=True,
        timeout=60, check=False,
    )  # fmt: skip
    assert "echoed" in done.stdout, done.stderr


PEER = """
import time
from palpate import ros
ros.messages()
import rclpy
from geometry_msgs.msg import WrenchStamped
rclpy.init()
node, heard = rclpy.create_node("peer"), []
node.create_subscription(WrenchStamped, "/back_secure", heard.append, 10)
there = node.create_publisher(WrenchStamped, "/there_secure", 10)
end = time.monotonic() + 30
while not heard and time.monotonic() < end:
    there.publish(WrenchStamped())
    rclpy.spin_once(node, timeout_sec=0.1)
print("echoed" if heard else "nothing")
"""
