"""The compilation of message packages against a ROS 2 whose generated files cannot be joined."""

import pytest

from palpate.base.errors import RosMissingError
from palpate.ros import build, where


@pytest.mark.parametrize("fails", [("ON",), ("ON", "OFF")])
def test_generated_files_that_clash_are_compiled_one_by_one(fails, monkeypatch, tmp_path):
    tried = []

    def cmake(ros, source, folder, options, *more):
        tried.append(options["JOINED"])
        if tried[-1] in fails:
            raise RosMissingError(f"tf2_msgs cannot be compiled: JOINED={tried[-1]}")

    monkeypatch.setattr(build, "_cmake", cmake)
    arguments = (where.find(), tmp_path / "work", build.HERE / "messages", "tf2_msgs")
    if "OFF" in fails:
        with pytest.raises(RosMissingError, match="JOINED=OFF"):
            build._compiled(*arguments)
    else:
        assert build._compiled(*arguments) == tmp_path / "work" / "install"
    assert tried == ["ON", "OFF"]
