"""Parts join by entry points; one that is broken, or that two packages have, ends in a sentence, and all others work."""

from importlib.metadata import EntryPoint

import pytest

from radar_service import plug_ins
from tests.plug_ins import join


def test_parts_are_ours_and_those_of_others_by_name(monkeypatch: pytest.MonkeyPatch) -> None:
    join(monkeypatch, "scattering", "mirror", "tests.plug_ins")
    assert plug_ins.names("scattering") == ["diffuse", "mirror", "optics", "rcs"]
    assert plug_ins.load("scattering", "mirror").join is join and not plug_ins.is_own(plug_ins.entry("scattering", "mirror"))
    assert plug_ins.is_own(plug_ins.entry("scattering", "rcs"))


def test_a_broken_part_is_told_once_and_the_others_work(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    join(monkeypatch, "ports", "gone", "package_of_nobody.port")
    for _ in range(2):
        assert {"rest", "feed"} <= plug_ins.working("ports").keys() and "gone" not in plug_ins.working("ports")
    (line,) = capsys.readouterr().err.splitlines()
    assert "gone of radar_service.ports: the package package_of_nobody.port" in line and "is broken (ModuleNotFound" in line


def test_two_packages_with_one_name_are_named(monkeypatch: pytest.MonkeyPatch) -> None:
    join(monkeypatch, "ports", "rest", "one")
    both = [*plug_ins.groups()["radar_service.ports"]["rest"], EntryPoint("rest", "two", "radar_service.ports")]
    known = plug_ins.groups()
    ports = {**known["radar_service.ports"], "rest": both}
    monkeypatch.setattr(plug_ins, "groups", lambda: {**known, "radar_service.ports": ports})
    with pytest.raises(plug_ins.PlugInError, match="the packages one and two both have rest; uninstall one of them"):
        plug_ins.load("ports", "rest")
    assert "feed" in plug_ins.working("ports")


def test_what_parts_of_strangers_raise_later_names_them_and_what_ours_raise_stays() -> None:
    with pytest.raises(
        plug_ins.PlugInError, match=r"^x of g: the package one is broken \(KeyError: 1\); update or uninstall it$"
    ):
        with plug_ins.guarded(EntryPoint("x", "one", "g")):
            raise KeyError(1)
    for own in (None, EntryPoint("x", "radar_service.ports.rest", "g")):
        with pytest.raises(KeyError), plug_ins.guarded(own):
            raise KeyError(1)
    with pytest.raises(OSError), plug_ins.guarded(EntryPoint("x", "one", "g"), OSError):
        raise OSError


def test_an_installation_without_entry_points_says_what_to_do(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(plug_ins.metadata, "distributions", lambda: [])
    with pytest.raises(plug_ins.PlugInError, match="install it again: pip install -e"):
        plug_ins.groups.__wrapped__()
