"""Addresses of the command line, and who may be there."""

import argparse
import re
import select
import socket
import sys

import pytest

from radar_service.ports.nmea_in.receivers import UdpReceiver
from radar_service.ports.udp.addresses import IP_MULTICAST_ALL, REJOIN, Address, UdpListener, address, check_reach, numeric
from radar_service.ports.udp.sender import UdpSender
from radar_service.terminal.arguments import UsageError
from tests.ports.nmea.test_senders import free_port
from tests.ports.nmea_in.test_receivers import Clock


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
        ("bridge", [], False, True, False), ("FF02:0::1", ["ff02::1"], False, False, True),
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


@pytest.mark.parametrize(
    ("host", "remedy"),
    [
        ("10.0.0.2", "give --nmea-allow 10.0.0.2, or"), ("FF02:0::1", "give --nmea-allow ff02::1, or"),
        ("bridge", "give an address in numbers, here and to --nmea-allow, or"), ("127.1", "give an address in numbers, here and"),
    ],
)  # fmt: skip
def test_the_remedy_of_a_message_works(host: str, remedy: str) -> None:
    """A name cannot be allowed: which machine has it may change. What --nmea-allow takes is what is compared."""
    with pytest.raises(UsageError, match=re.escape(remedy)):
        check_reach("--nmea-udp", Address(host, 7), [], False, listens=False)
    if allowed := re.search("--nmea-allow ([^ ,]+),", remedy):
        check_reach("--nmea-udp", Address(host, 7), [numeric(allowed[1])], False, listens=False)


@pytest.mark.parametrize(
    ("where", "message"),
    [
        (Address("ff02::1", 7, "nosuch9"), "no interface has the name nosuch9"),
        (Address("fe80::1", 7), r"needs an interface, as \[fe80::1\]:7%eth0"), (Address("FF12::1", 7), "needs an interface"),
    ],
)  # fmt: skip
def test_an_interface_that_is_absent_or_missing_is_named(where: Address, message: str) -> None:
    with pytest.raises(OSError, match=message):
        _ = where.for_sockets
    with pytest.raises(OSError, match="eth0 is not the address of an interface"):
        _ = Address("239.1.1.1", 7, "eth0").interface_address
    assert Address("::1", 7).for_sockets == ("::1", 7, 0, 0) and Address("bridge", 7).for_sockets == ("bridge", 7)


@pytest.mark.parametrize("where", [Address("239.1.2.3", 5, "nosuch9"), Address("ff05::1", 5, "nosuch9")])
def test_sockets_say_so(where: Address) -> None:
    for make in (lambda: UdpSender("--x", where), lambda: UdpReceiver("--x", where, [])):
        with pytest.raises(UsageError, match="--x: .* cannot be (reached|opened) .*nosuch9"):
            make()


def test_a_group_is_listened_to_beside_readers_of_it() -> None:
    where, clock = Address("239.255.77.9", free_port(), "127.0.0.1"), Clock()
    listeners = [UdpListener("--x", where, clock) for _ in range(2)]  # as readers do
    clock.now = REJOIN  # it is in the group
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        sender.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_IF, socket.inet_aton("127.0.0.1"))
        sender.sendto(b"\1\xb1", (where.host, where.port))
    for each in listeners:
        assert select.select(each.sockets, [], [], 10)[0] and [data for data, *_ in each.datagrams(64)] == [b"\1\xb1"]
        if sys.platform == "linux":  # nothing comes by other interfaces, which a test has not
            assert each.sockets[0].getsockopt(socket.IPPROTO_IP, IP_MULTICAST_ALL) == 0
        each.close()
