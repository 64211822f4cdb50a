"""Addresses of the command line, and who may be there."""

import argparse

import pytest

from radar_service.ports.nmea.addresses import Address, address, check_reach, numeric
from radar_service.terminal.arguments import UsageError


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("10110", Address("127.0.0.1", 10110)), ("0.0.0.0:1", Address("0.0.0.0", 1)), ("bridge:65535", Address("bridge", 65535)),
        ("239.192.0.4:60004%192.168.0.7", Address("239.192.0.4", 60004, "192.168.0.7")), ("[::1]:7", Address("::1", 7)),
        ("[ff02::1]:7%eth0", Address("ff02::1", 7, "eth0")),
    ],
)  # fmt: skip
def test_addresses(text: str, expected: Address) -> None:
    assert address(text) == expected and address(str(expected)) == expected


@pytest.mark.parametrize("text", ["", "0", "65536", "a", "host:", "::1:7", ":7", "[::1]", "a b:7", "1%"])
def test_what_is_no_address_is_refused(text: str) -> None:
    with pytest.raises(argparse.ArgumentTypeError, match="10110"):
        address(text)


def test_names_are_not_allowed_in() -> None:
    assert numeric("192.168.0.7") == "192.168.0.7"
    with pytest.raises(argparse.ArgumentTypeError, match="192.168.0.7"):
        numeric("bridge")


@pytest.mark.parametrize(
    ("host", "allowed", "insecure", "listens", "passes"),
    [
        ("127.0.0.1", [], False, True, True), ("::1", [], False, False, True), ("localhost", [], False, False, True),
        ("0.0.0.0", [], False, True, False), ("0.0.0.0", ["10.0.0.2"], False, True, True), ("0.0.0.0", [], True, True, True),
        ("10.0.0.2", [], False, False, False), ("10.0.0.2", ["10.0.0.3"], False, False, False),
        ("10.0.0.2", ["10.0.0.3", "10.0.0.2"], False, False, True), ("239.192.0.4", [], True, False, True),
        ("bridge", [], False, True, False),
    ],
)  # fmt: skip
def test_beyond_this_machine_needs_a_permission(
    host: str, allowed: list[str], insecure: bool, listens: bool, passes: bool
) -> None:
    if passes:
        check_reach("--nmea-tcp", Address(host, 7), allowed, insecure, listens=listens)
        return
    with pytest.raises(UsageError, match="--nmea-allow .*--insecure"):
        check_reach("--nmea-tcp", Address(host, 7), allowed, insecure, listens=listens)
