"""Processes of Python that start without importing anything: each is forked from a server that has imported it all.

`Process` is a `subprocess.Popen` whose child is forked from the server of this test session, in the place of a new
interpreter; `processes` puts it in the place of `subprocess.Popen`. It is a process like any other: a child of this
one, with its own memory, signals, environment, working directory and standard streams. What it saves is the start of
an interpreter and the imports of Palpate, NumPy and SciPy, a second of processor time. Tests of what a start costs or
imports use `cold`.
"""

from __future__ import annotations

import atexit
import contextlib
import ctypes
import fcntl
import functools
import importlib
import io
import os
import pickle
import pkgutil
import runpy
import signal
import socket
import subprocess
import sys
import time
import types
from pathlib import Path
from unittest import mock

MODULES = """
    palpate.cli palpate.session palpate.scene palpate.record palpate.report palpate.devices palpate.planning
    scipy.optimize scipy.spatial rich.console rich._emoji_codes asyncio unittest.mock typeguard lark em
    rosidl_parser.parser rosidl_generator_py rosidl_generator_py.import_type_support_impl
    sensor_msgs.msg geometry_msgs.msg std_msgs.msg std_srvs.srv tf2_msgs.msg crtk_msgs.msg diagnostic_msgs.msg
    visualization_msgs.msg rcl_interfaces.msg rcl_interfaces.srv rosgraph_msgs.msg type_description_interfaces.srv
"""
"""Modules that the server imports, where they exist. None of them may start a thread: rclpy does."""
ROOMS = ("palpate.ros", "palpate.cli.commands.ros", "palpate.cli.terminal")
"""Packages of which the server imports each module."""
_POPEN, _ENVIRONMENT = subprocess.Popen, dict(os.environ)
_SUBREAPER = 36  # PR_SET_CHILD_SUBREAPER of prctl(2)


class Process(subprocess.Popen):
    """A process, forked from the server if its command is `python -m MODULE`, `python -c CODE` or `python FILE`.

    Takes the arguments of `subprocess.Popen`, and starts another command, or one with a function to run before it, as
    that one does.
    """

    def _execute_child(self, args, executable, preexec_fn, close_fds, pass_fds, cwd, env, *rest):
        shell, ends, new_session, group = rest[2], rest[3:9], rest[-2], rest[-1]
        command = [args] if isinstance(args, str | bytes | os.PathLike) else [os.fsdecode(one) for one in args]
        python = len(command) > 1 and command[0] == sys.executable and executable in (None, sys.executable)
        python = python and (command[1] in ("-m", "-c") or command[1].endswith(".py"))
        if (
            shell
            or preexec_fn
            or not python
            or _interpreter(os.environ if env is None else env) != _interpreter(_ENVIRONMENT)
        ):
            return super()._execute_child(args, executable, preexec_fn, close_fds, pass_fds, cwd, env, *rest)
        theirs = (ends[0], ends[3], ends[5])
        streams = [end if end != -1 else number for number, end in enumerate(theirs)]
        job = {
            "arguments": command[1:],
            "folder": os.fsdecode(cwd or os.getcwd()),
            "environment": dict(os.environ if env is None else env),
            "session": bool(new_session),
            "group": group,
            "passed": list(pass_fds),
        }
        self.pid = server().fork(job, [*streams, *pass_fds])
        self._child_created = True
        for end in {*theirs, getattr(self, "_devnull", None)} - {-1, None}:
            os.close(end)
        return None


def _interpreter(environment):
    """The variables that an interpreter reads when it starts."""
    return {k: v for k, v in environment.items() if k.startswith("PYTHON")}


@contextlib.contextmanager
def processes():
    """A context in which `subprocess` starts processes of Python from the server."""
    with mock.patch("subprocess.Popen", Process):
        yield


@contextlib.contextmanager
def cold():
    """A context in which they start anew."""
    with mock.patch("subprocess.Popen", _POPEN):
        yield


@functools.cache
def server():
    """The server of this process; it ends with it."""
    return Server()


class Server:
    """The process that forks others, seen from the tests."""

    def __init__(self):
        self._socket, other = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        for end in (self._socket, other):
            end.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, 1 << 20)
        with other:
            self._process = _POPEN(
                [sys.executable, __file__, str(other.fileno())], pass_fds=[other.fileno()], start_new_session=True
            )
        atexit.register(self.end)

    def fork(self, job, streams):
        """Start a process; returns its number, once it is a child of this process."""
        prctl = ctypes.CDLL(None).prctl
        prctl(_SUBREAPER, 1, 0, 0, 0)  # the parent of the new process ends, and this one becomes its parent
        try:
            socket.send_fds(self._socket, [pickle.dumps(job)], streams)
            answer = self._socket.recv(64)
        finally:
            prctl(_SUBREAPER, 0, 0, 0, 0)
        assert answer, "the server of warm processes has ended"
        return int(answer)

    def end(self):
        """End the server, as its socket closes."""
        self._socket.close()
        self._process.wait()


# --- the server ------------------------------------------------------------------------------------------------------


def _import():
    """Import what processes of the tests import."""
    with contextlib.suppress(Exception):  # no ROS 2
        ros = importlib.import_module("palpate.ros")
        ros.messages()
    rooms = [importlib.import_module(name) for name in ROOMS]
    found = [module.name for room in rooms for module in pkgutil.walk_packages(room.__path__, room.__name__ + ".")]
    for name in (*MODULES.split(), *found):
        with contextlib.suppress(ImportError):
            importlib.import_module(name)


def _serve(requests):
    """Fork a process for each request; returns the request and its streams in the new process, None at the end."""
    while True:
        message, streams, _, _ = socket.recv_fds(requests, 1 << 20, 16)
        if not message:
            return None
        out, into = os.pipe()
        between = os.fork()
        if between == 0:
            parent, pid = os.getpid(), os.fork()
            if pid == 0:
                while os.getppid() == parent:
                    time.sleep(1e-3)
                return pickle.loads(message), streams
            os.write(into, str(pid).encode())
            os._exit(0)
        os.waitpid(between, 0)
        requests.send(os.read(out, 64))
        for end in (out, into, *streams):
            os.close(end)


def _become(job, streams):
    """Take over streams, folder, environment and signals as after exec."""
    if job["session"]:
        os.setsid()
    elif (group := job["group"]) is not None and group >= 0:
        os.setpgid(0, group)
    wanted = [0, 1, 2, *job["passed"]]
    highest = 1 + max(*wanted, *streams)
    copies = [fcntl.fcntl(stream, fcntl.F_DUPFD, highest) for stream in streams]
    os.closerange(3, highest)
    for number, copy in zip(wanted, copies, strict=True):
        os.dup2(copy, number)
    os.closerange(highest, max(copies) + 1)
    for name in (signal.SIGINT, signal.SIGTERM):
        signal.signal(name, signal.default_int_handler if name is signal.SIGINT else signal.SIG_DFL)
    os.environ.clear()
    os.environ.update(job["environment"])
    os.chdir(job["folder"])
    sys.stdin = io.TextIOWrapper(io.BufferedReader(io.FileIO(0, closefd=False)))
    sys.stdout = io.TextIOWrapper(io.BufferedWriter(io.FileIO(1, "w", closefd=False)))
    errors = io.BufferedWriter(io.FileIO(2, "w", closefd=False))
    sys.stderr = io.TextIOWrapper(errors, errors="backslashreplace", line_buffering=True)
    sys.__stdin__, sys.__stdout__, sys.__stderr__ = sys.stdin, sys.stdout, sys.stderr


def _run(arguments):
    """Run the module, code or file, as the command line of Python does."""
    what, *rest = arguments
    if what == "-m":
        sys.argv, sys.path[0] = rest, os.getcwd()
        runpy.run_module(rest[0], run_name="__main__", alter_sys=True)
    elif what == "-c":
        sys.argv, sys.path[0] = ["-c", *rest[1:]], ""
        main = sys.modules["__main__"] = types.ModuleType("__main__")
        exec(compile(rest[0], "<string>", "exec"), main.__dict__)
    else:
        assert not what.startswith("-"), f"no option of Python: {what}"
        sys.argv, sys.path[0] = list(arguments), str(Path(what).resolve().parent)
        runpy.run_path(what, run_name="__main__")


if __name__ == "__main__":
    import gc

    requests_ = socket.socket(fileno=int(sys.argv[1]))
    _import()
    threads = os.listdir("/proc/self/task")
    assert len(threads) == 1, f"a process with {len(threads)} threads cannot be forked"
    gc.collect()
    gc.freeze()
    if (request := _serve(requests_)) is not None:
        requests_.detach()
        _become(*request)
        _run(request[0]["arguments"])
