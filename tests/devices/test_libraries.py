"""Where the vendors' libraries are looked for."""

import json

from palpate.cli import main
from palpate.devices import libraries as module
from palpate.devices.libraries import libraries


def test_a_library_is_found_in_the_folders_of_the_environment(tmp_path, monkeypatch):
    sdk = tmp_path / "sdk" / "lib"
    sdk.mkdir(parents=True)
    (sdk / "libdhd.so.3").touch()
    monkeypatch.setattr(module, "FOLDERS", (str(tmp_path / "nowhere"), str(tmp_path / "s*")))
    monkeypatch.setenv("LD_LIBRARY_PATH", str(tmp_path))
    monkeypatch.setenv("FORCEDIM_SDK", str(tmp_path / "sdk"))
    dhd, hd, hdl = libraries()
    assert dhd.found == str(sdk / "libdhd.so.3")
    assert (hd.file, hd.found) == ("libHD.so", None)
    assert (hdl.file, hdl.found) == ("libhdl.so", None)
    assert str(tmp_path) in hd.places
    assert str(tmp_path / "nowhere") not in hd.places, "a folder that does not exist was not searched"


def test_the_list_of_devices_names_library_and_places(capsys, monkeypatch, tmp_path):
    monkeypatch.setattr(module, "FOLDERS", ())
    wheel = tmp_path / "site-packages" / "ros.libs"
    wheel.mkdir(parents=True)
    monkeypatch.setenv("LD_LIBRARY_PATH", f"{wheel}:{tmp_path}")
    assert main(["device", "list", "--json", "-"]) == 0
    out, err = capsys.readouterr()
    rows = {row["driver"]: row for row in json.loads(out)["libraries"]}
    assert rows["openhaptics.so"]["places"] == [str(tmp_path)]
    text = " ".join(err.split())
    assert "libHD.so of the OpenHaptics of 3D Systems: not found in" in text
    assert "haply" in text
