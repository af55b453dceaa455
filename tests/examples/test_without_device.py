"""Examples that need a device, or a robot, say so without a traceback."""

import os
import subprocess
import sys
from pathlib import Path

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"


def run(*args, **env):
    return subprocess.run(
        [sys.executable, *args], capture_output=True, text=True, timeout=100, env={**os.environ, **env}
    )


def test_gamepad_that_is_not_there():
    done = run(EXAMPLES / "08_gamepad.py", "--device", "/dev/input/no-such-file", "--duration", "1")
    assert done.returncode == 1
    assert "Traceback" not in done.stderr
    assert "/dev/input/no-such-file cannot be opened" in done.stderr
    assert "--pretended" in done.stderr


def test_client_without_ros(tmp_path):
    (tmp_path / "rclpy.py").write_text("raise ImportError('no ROS here')")
    done = run(EXAMPLES / "ros2_client.py", PYTHONPATH=str(tmp_path))
    assert done.returncode == 1
    assert "Traceback" not in done.stderr
    assert "needs ROS 2" in done.stderr
