"""What `palpate doctor` finds, on machines that are made for it: files of a system, ports, a PATH."""

import json
import os
import shutil
import socket
import sys

import json_contract
import pytest

from palpate.base.errors import PalpateError
from palpate.cli import main
from palpate.cli.doctor import TOPICS, connected, examine, machine, programs


def by_thing(findings):
    return {one.thing: one for one in findings}


def plug(folder, vendor, product, bus=1, device=4):
    """A device as the system lists it, and its file; the file's path."""
    place = folder / "sys" / f"{bus}-{device}"
    place.mkdir(parents=True)
    for name, value in (("idVendor", vendor), ("idProduct", product), ("busnum", bus), ("devnum", device)):
        (place / name).write_text(f"{value}\n")
    node = folder / "dev" / f"{bus:03d}" / f"{device:03d}"
    node.parent.mkdir(parents=True, exist_ok=True)
    node.touch()
    return node


def test_each_topic_answers_and_each_deviation_has_a_fix():
    findings = examine()
    assert list(dict.fromkeys(one.topic for one in findings)) == list(TOPICS)
    assert [one for one in findings if (one.state == "ok") == bool(one.fix)] == []
    assert [one for one in findings if one.fix and not one.needed_for] == []


def test_json_has_the_documented_keys_and_the_code_counts_the_problems(capsys):
    code = main(["doctor", "disk", "compiler", "--json", "-"])
    found = json.loads(capsys.readouterr().out)
    assert set(found) == json_contract.keys("doctor")
    assert set(found["findings"][0]) == json_contract.keys_of("doctor", "A row of `findings`:")
    assert {one["topic"] for one in found["findings"]} == {"disk", "compiler"}
    assert found["problems"] == sum(one["state"] == "problem" for one in found["findings"])
    assert code == (1 if found["problems"] else 0)


def test_unknown_topic_lists_the_topics():
    with pytest.raises(PalpateError, match=r"no topic 'usb'\n  mend: name some of: versions,.*USB"):
        examine(["usb"])


def test_device_without_rights_is_a_problem_with_the_rule_of_its_vendor(tmp_path, monkeypatch):
    node = plug(tmp_path, "1451", "0402")
    (one,) = connected.usb(tmp_path / "sys", tmp_path / "dev")
    assert (one.state, one.thing) == ("ok", "Force Dimension")
    monkeypatch.setattr(os, "access", lambda path, mode: path != node)
    (one,) = connected.usb(tmp_path / "sys", tmp_path / "dev")
    assert (one.state, str(node) in one.found) == ("problem", True)
    assert 'ATTR{idVendor}=="1451"' in one.fix


def test_falcon_is_known_by_its_product_since_its_vendor_sells_serial_chips(tmp_path):
    plug(tmp_path, "0403", "6001", device=2)
    assert [one.thing for one in connected.usb(tmp_path / "sys", tmp_path / "dev")] == ["haptic devices"]
    plug(tmp_path, "0403", "cb48", device=3)
    assert [one.thing for one in connected.usb(tmp_path / "sys", tmp_path / "dev")] == ["Novint Falcon"]


def test_governor_that_saves_power_is_a_problem(tmp_path):
    for cpu, governor in ((0, "performance"), (1, "powersave")):
        place = tmp_path / f"cpu{cpu}" / "cpufreq"
        place.mkdir(parents=True)
        (place / "scaling_governor").write_text(governor + "\n")
    one = machine._governor(tmp_path)
    assert (one.state, one.found) == ("problem", "performance, powersave")
    (tmp_path / "cpu1" / "cpufreq" / "scaling_governor").write_text("performance\n")
    assert machine._governor(tmp_path).state == "ok"


def test_refused_priority_names_the_line_of_the_limits(monkeypatch):
    def refuse(*_):
        raise PermissionError

    monkeypatch.setattr(os, "sched_setscheduler", refuse)
    one = by_thing(machine.real_time())["SCHED_FIFO"]
    assert one.state == "problem"
    assert "rtprio 90" in one.fix


def test_examination_leaves_the_scheduler_of_this_process_alone():
    before = os.sched_getscheduler(0)
    machine.real_time()
    assert os.sched_getscheduler(0) == before


def test_missing_compiler_is_told_with_the_package(monkeypatch, tmp_path):
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.setattr(sys, "executable", str(tmp_path / "python"))
    found = by_thing(programs.compiler())
    assert [found[name].found for name in ("g++", "cmake", "ninja")] == ["not found"] * 3
    assert found["g++"].fix == "sudo apt install g++"


def test_old_compiler_is_told(monkeypatch, tmp_path):
    tool = tmp_path / "g++"
    tool.write_text("#!/bin/sh\necho 9.4.0\n")
    tool.chmod(0o755)
    monkeypatch.setenv("PATH", f"{tmp_path}:{os.environ['PATH']}")
    assert by_thing(programs.compiler())["g++"].state == "problem"


def test_missing_package_names_its_extra(monkeypatch):
    monkeypatch.setattr(programs, "_installed", lambda name: name != "viser")
    found = by_thing(programs.extras())
    assert {name for name, one in found.items() if one.state != "ok"} == {"viewer"}
    assert "viser" in found["viewer"].found


def test_every_extra_says_what_it_adds():
    assert [one.thing for one in programs.extras() if not one.needed_for] == []


def test_a_full_disk_is_a_problem(monkeypatch):
    usage = shutil.disk_usage(".")
    monkeypatch.setattr(shutil, "disk_usage", lambda _: usage._replace(free=10**8))
    assert {one.state for one in machine.disk()} == {"problem"}


def test_taken_port_and_running_service_are_seen(monkeypatch):
    with socket.socket() as server:
        server.bind(("127.0.0.1", 0))
        server.listen()
        port = server.getsockname()[1]
        monkeypatch.setattr(connected, "PORTS", {port: "the viewer"})
        monkeypatch.setattr(connected, "HAPLY", port)
        assert connected.ports()[0].found == f"{port} is taken"
        assert by_thing(connected.devices())["Haply's service"].state == "ok"
    assert connected.ports()[0].state == "ok"
    assert by_thing(connected.devices())["Haply's service"].state == "optional"


def test_unreadable_pedals_name_the_group(tmp_path, monkeypatch):
    (tmp_path / "event3").touch()
    assert connected.inputs(tmp_path)[0].state == "ok"
    monkeypatch.setattr(os, "access", lambda *_: False)
    assert "usermod -aG input" in connected.inputs(tmp_path)[0].fix
