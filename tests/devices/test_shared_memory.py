"""A device in a second process, by shared memory: its force, and zero force after kill -9 and SIGSTOP."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from test_driven import with_driver

from palpate.base.errors import DeviceError
from palpate.devices.shared_memory import SIZE, Server, SharedMemoryDevice, path_of
from palpate.session import Session

ROOT = Path(__file__).resolve().parents[2]
DEVICE = """
import sys, time
import numpy as np
from palpate.devices.shared_memory import Server
with Server(sys.argv[1], 500.0, 5.0) as server:
    print("ready", flush=True)
    X, felt, count = np.eye(4), 0.0, 0
    sys.stdin.readline()
    end = time.monotonic() + 20.0
    while time.monotonic() < end:
        count += 1
        X[2, 3] = -0.0002 * min(count, 150) - 2e-5 * count  # goes on downwards, as a busy machine interrupts the force
        server.send(X)
        felt = max(felt, float(np.linalg.norm(server.wrench()[:3])))
        if felt > 1.0:
            print(felt, flush=True)
            felt = -1e9
        time.sleep(0.002)
"""


@pytest.fixture
def device():
    name = f"test-{os.getpid()}"
    process = subprocess.Popen(
        [sys.executable, "-c", DEVICE, name], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
    )  # fmt: skip
    assert process.stdout.readline() == "ready\n"
    yield name, process
    process.kill()
    process.wait()
    path_of(name).unlink(missing_ok=True)


@pytest.mark.parametrize("sign", [signal.SIGKILL, signal.SIGSTOP], ids=["kill -9", "stopped"])
def test_second_process_feels_the_surface_and_its_end_gives_zero_force(device, sign):
    name, process = device
    session = Session(with_driver(f"shared-memory:{name}"))
    session.start()
    process.stdin.write("go\n")
    process.stdin.flush()
    assert float(process.stdout.readline()) > 1.0, "the other process was commanded the force"
    process.send_signal(sign)
    time.sleep(0.3)
    assert session.state.force == 0.0
    assert session.failed is False
    summary = session.close()
    assert any("not finite" in fault for fault in summary.faults)


def test_wrench_of_a_dead_session_is_zero_in_the_device_process(tmp_path):
    with Server(f"dead-{os.getpid()}", 500.0, 5.0) as server:
        client = SharedMemoryDevice(f"dead-{os.getpid()}")
        client.write(np.array([1.0, 2.0, 3.0, 0.0, 0.0, 0.0]))
        assert server.wrench()[2] == 3.0
        time.sleep(0.03)
        assert not server.wrench().any()


def test_states_are_never_torn():
    """A writer that stops in the middle of a block leaves an odd counter: no state."""
    with Server(f"torn-{os.getpid()}", 500.0, 5.0) as server:
        client = SharedMemoryDevice(f"torn-{os.getpid()}")
        client.open()
        assert np.isnan(client.read().X).all(), "nothing sent yet"
        server.send(np.eye(4), 0.3, 1)
        reading = client.read()
        assert np.array_equal(reading.X, np.eye(4))
        assert (reading.gripper, reading.buttons) == (0.3, 1)
        memory = np.memmap(path_of(f"torn-{os.getpid()}"), dtype=np.uint64, mode="r+", shape=(SIZE // 8,))
        memory[8] += 1
        assert np.isnan(client.read().X).all()


def test_missing_and_foreign_files_are_refused():
    with pytest.raises(DeviceError, match="start the device's process first"):
        SharedMemoryDevice("nowhere")
    path = path_of(f"foreign-{os.getpid()}")
    path.write_bytes(b"x" * SIZE)
    try:
        with pytest.raises(DeviceError, match="no device of Palpate"):
            SharedMemoryDevice(f"foreign-{os.getpid()}")
    finally:
        path.unlink()
