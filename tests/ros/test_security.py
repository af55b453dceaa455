"""DDS security (SROS 2): openssl checks the keystore; nodes use it if the middleware supports security.

Fast DDS of the `ros-*` wheels has no security plug-ins. In this case no node may start unprotected when
protection is required. An independent DDS with security, Eclipse Cyclone DDS, also checks the keystore
(`sudo apt install cyclonedds-tools`).
"""

import os
import shutil
import subprocess
import sys
import time

import pytest

from palpate.base.errors import PalpateError
from palpate.ros import keystore

NODE = """
import sys, time
from palpate import ros
try:
    native = ros.load()
    echo = native.Echo(native.Context(), "/there_secure", "/back_secure")
except Exception as error:  # before ROS starts, or by the middleware
    if type(error).__name__ not in ("RosError", "RosMissingError"):
        raise
    print("refused:", " ".join(str(error).split()), flush=True)
    sys.exit(3)
print("up", flush=True)
sys.stdin.read()
"""


@pytest.fixture(scope="module")
def store(tmp_path_factory):
    folder = tmp_path_factory.mktemp("keys") / "keystore"
    keystore.make(folder, ("/palpate/haptics", "/palpate/leader=sim"))
    return folder


def openssl(*arguments):
    return subprocess.run(["openssl", *map(str, arguments)], capture_output=True, text=True, check=False)


@pytest.mark.parametrize("enclave", ["palpate/haptics", "palpate/leader"])
def test_keys_and_documents_are_signed_by_the_authority(store, enclave, tmp_path):
    place, ca = store / "enclaves" / enclave, store / "public" / "ca.cert.pem"
    assert "OK" in openssl("verify", "-CAfile", ca, place / "cert.pem").stdout
    subject = openssl("x509", "-in", place / "cert.pem", "-noout", "-subject", "-nameopt", "RFC2253").stdout
    assert f"CN=/{enclave}" in subject.strip()
    for document in ("permissions.p7s", "governance.p7s"):
        done = openssl("smime", "-verify", "-text", "-in", place / document, "-CAfile", ca, "-out", tmp_path / "text")
        assert done.returncode == 0, done.stderr
        assert "<dds" in (tmp_path / "text").read_text()
    tampered = tmp_path / "tampered.p7s"
    tampered.write_text((place / "permissions.p7s").read_text().replace("DENY", "ALLOW"))
    assert openssl("smime", "-verify", "-text", "-in", tampered, "-CAfile", ca, "-out", os.devnull).returncode != 0
    assert (place / "key.pem").stat().st_mode & 0o077 == 0


def test_invalid_enclave_name_is_rejected(tmp_path):
    with pytest.raises(PalpateError, match="is no enclave"):
        keystore.make(tmp_path, ("../elsewhere",))


@pytest.fixture(scope="module")
def protected(built, store):
    """A function that starts a node with environment variables; returns the process and its first line."""
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


def test_required_protection_is_enforced(protected, store):
    """With Enforce and without keys a node does not start, with any middleware."""
    variables = keystore.environment(store, "/palpate/nobody")
    process, line = protected(**variables)
    assert line.startswith("refused:"), line
    assert process.wait(20) == 3


def test_participant_without_keys_is_ignored(protected, store, node, rclpy):
    """Two nodes of one authority communicate; this process has no keys and discovers none of their topics."""
    process, line = protected(**keystore.environment(store, "/palpate/haptics"))
    if line.startswith("refused:") and "security" in line:
        assert process.wait(20) == 3
        pytest.skip("this Fast DDS has no security plug-ins (as in the ros-* wheels) and refuses to start")
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


CYCLONE = """<CycloneDDS><Domain id="any">
<General><Interfaces><NetworkInterface name="lo" multicast="false"/></Interfaces>
<AllowMulticast>false</AllowMulticast></General>
<Discovery><Peers><Peer address="127.0.0.1"/></Peers><ParticipantIndex>auto</ParticipantIndex></Discovery>
{security}</Domain></CycloneDDS>
"""
SECURITY = """<Security>
<Authentication><Library path="dds_security_auth"
  initFunction="init_authentication" finalizeFunction="finalize_authentication"/>
<IdentityCA>file:{place}/identity_ca.cert.pem</IdentityCA>
<IdentityCertificate>file:{place}/cert.pem</IdentityCertificate><PrivateKey>file:{place}/key.pem</PrivateKey>
</Authentication>
<Cryptographic><Library path="dds_security_crypto"
  initFunction="init_crypto" finalizeFunction="finalize_crypto"/></Cryptographic>
<AccessControl><Library path="dds_security_ac"
  initFunction="init_access_control" finalizeFunction="finalize_access_control"/>
<PermissionsCA>file:{place}/permissions_ca.cert.pem</PermissionsCA>
<Governance>file:{place}/governance.p7s</Governance><Permissions>file:{place}/permissions.p7s</Permissions>
</AccessControl></Security>"""
PLUGINS = "/usr/lib/x86_64-linux-gnu/libddsc0debian"


@pytest.fixture
def ping(tmp_path):
    """A function that runs Cyclone's `ddsperf` between pairs of enclaves (None: no security), all at the same time.

    Returns the ping outputs. Each pair has its own domain.
    """
    if shutil.which("ddsperf") is None or not os.path.isdir(PLUGINS):
        pytest.skip("Cyclone DDS with security plug-ins is not installed: sudo apt install cyclonedds-tools")

    def begin(k, first, second):
        domain, ends = str(60 + (4 * os.getpid() + k) % 100), []
        for mode, place, seconds in (("pong", first, 7), ("ping", second, 5)):
            file = tmp_path / f"{mode}_{k}.xml"
            file.write_text(CYCLONE.format(security="" if place is None else SECURITY.format(place=place)))
            variables = {"CYCLONEDDS_URI": f"file://{file}", "LD_LIBRARY_PATH": PLUGINS}
            ends.append(
                subprocess.Popen(
                    ["ddsperf", "-i", domain, "-D", str(seconds), mode], env=os.environ | variables,
                    stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                )
            )  # fmt: skip
        return ends

    def run(*pairs):
        running = [begin(k, *pair) for k, pair in enumerate(pairs)]
        outputs = [end.communicate(timeout=30)[0] for _, end in running]
        for pong, _ in running:
            pong.kill()
            pong.communicate()
        return outputs

    return run


def for_ddsperf(store, enclave, topics="*"):
    """Folder of an enclave whose permissions allow partitions, as ddsperf uses them, and also these of its topics."""
    place = store / "enclaves" / enclave
    authority = store.with_name(f"{store.name}-authority")
    document = place / "permissions.xml"
    more = f"<topic>{topics}</topic>" if topics else ""
    text = document.read_text()
    if "partition" not in text:
        text = text.replace("</topics>", f"{more}</topics><partitions><partition>*</partition></partitions>")
        document.write_text(text)
        done = openssl("smime", "-sign", "-text", "-in", document, "-signer", authority / "ca.cert.pem",
                       "-inkey", authority / "ca.key.pem", "-out", place / "permissions.p7s")  # fmt: skip
        assert done.returncode == 0, done.stderr
    return place


def test_cyclone_dds_admits_only_keys_of_the_authority(ping, store, tmp_path):
    """The documents checked by an independent implementation of DDS Security."""
    first, second = for_ddsperf(store, "palpate/haptics"), for_ddsperf(store, "palpate/leader")
    strangers = tmp_path / "strangers"
    keystore.make(strangers, ("/palpate/leader=sim",))
    (tmp_path / "borrowed").mkdir()
    for file in second.iterdir():
        shutil.copy(file, tmp_path / "borrowed")
    shutil.copy(first / "permissions.p7s", tmp_path / "borrowed")
    refused = {
        "a participant without a key": None,
        "key of another authority": for_ddsperf(strangers, "palpate/leader"),
        "permissions of another enclave": tmp_path / "borrowed",
    }
    output, *others = ping((first, second), *((first, other) for other in refused.values()))
    assert " mean " in output, "two enclaves of one keystore communicate"
    for what, heard in zip(refused, others, strict=True):
        assert " mean " not in heard, what


def test_cyclone_dds_lets_a_key_publish_only_what_its_role_names(ping, tmp_path):
    """The same role, with and without the topics of ddsperf in its lists: without them it is not heard."""
    store = tmp_path / "roles"
    keystore.make(store, ("/a/all", "/b/camera", "/c/camera"))
    everything = for_ddsperf(store, "a/all")
    named, not_named = for_ddsperf(store, "b/camera", "DDSPerf*"), for_ddsperf(store, "c/camera", "")
    heard, unheard = ping((everything, named), (everything, not_named))
    assert " mean " in heard
    assert " mean " not in unheard
