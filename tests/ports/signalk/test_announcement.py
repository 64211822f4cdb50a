"""Announcements by mDNS are found by zeroconf's own browser; without it, a sentence."""

import asyncio
import sys
from typing import Any

import pytest

from radar_service.__main__ import main
from radar_service.terminal.arguments import UsageError

HERE = "127.0.0.1"


def found(port: int) -> Any:
    """What a browser on loopback learns of a service there."""
    pytest.importorskip("zeroconf", reason="the extra announce is absent")
    from zeroconf import ServiceStateChange
    from zeroconf.asyncio import AsyncServiceBrowser, AsyncServiceInfo, AsyncZeroconf

    from radar_service.ports.signalk.announcement import KIND, Announcement

    async def whole() -> Any:
        announcement, reader = Announcement(HERE, port), AsyncZeroconf(interfaces=[HERE])
        changes: asyncio.Queue[tuple[ServiceStateChange, str]] = asyncio.Queue()

        def note(name: str, state_change: ServiceStateChange, **_: Any) -> None:
            changes.put_nowait((state_change, name))

        browser = AsyncServiceBrowser(reader.zeroconf, KIND, handlers=[note])
        await announcement.start()
        while f"port {port}" not in (name := (await changes.get())[1]):
            pass
        info = AsyncServiceInfo(KIND, name)
        assert await info.async_request(reader.zeroconf, 10_000)
        await announcement.stop()
        while (await changes.get()) != (ServiceStateChange.Removed, name):
            pass
        await browser.async_cancel()
        await reader.async_close()
        return info

    return asyncio.run(asyncio.wait_for(whole(), 60))


def test_without_the_package_the_command_names_the_extra(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.delitem(sys.modules, "radar_service.ports.signalk.announcement", raising=False)
    monkeypatch.setitem(sys.modules, "zeroconf", None)
    assert main(["serve", "harbour", "--signalk", "--announce"]) == 2
    assert capsys.readouterr().err.startswith("announcements need the package zeroconf, of the extra announce;")


def test_what_cannot_be_announced_is_said_in_a_sentence() -> None:
    pytest.importorskip("zeroconf")
    from radar_service.ports.signalk.announcement import Announcement

    for host, number, reason in (
        (HERE, 0, "give --port"),
        ("0.0.0.0", 8000, "give one of this machine"),
        ("::1", 8000, "::1 is no address of IPv4"),
    ):
        with pytest.raises(UsageError, match=reason):
            Announcement(host, number)


def test_a_browser_finds_the_service_and_learns_of_its_end() -> None:
    info = found(8123)
    assert info.port == 8123 and info.parsed_addresses() == [HERE] and info.decoded_properties["self"] == "simulated"
