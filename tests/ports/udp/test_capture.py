"""Captures: the datagrams that were sent, with headers that add up; a full disk ends the capture and nothing else."""

import socket
import struct
from pathlib import Path

import pytest

from radar_service.commands.command_line import parser
from radar_service.ports import udp
from radar_service.ports.asterix import VIDEO
from radar_service.ports.udp.addresses import Address
from radar_service.ports.udp.capture import HEADER, Capture, CaptureSender
from radar_service.ports.udp.sender import UdpSender
from radar_service.terminal.arguments import UsageError

HERE = "127.0.0.1"


def frames(path: Path) -> list[tuple[float, bytes]]:
    content, found = path.read_bytes(), []
    assert content.startswith(HEADER)
    at = len(HEADER)
    while at < len(content):
        seconds, micros, size, whole = struct.unpack_from("<IIII", content, at)
        assert size == whole
        found.append((seconds + micros / 1e6, content[at + 16 : at + 16 + size]))
        at += 16 + size
    return found


def words_sum(content: bytes) -> int:
    """The sum of words with the carries added: 0xFFFF where a checksum in it is right."""
    total = sum(struct.unpack(f">{-(-len(content) // 2)}H", content + b"\0" * (len(content) % 2)))
    return total % 0xFFFF or 0xFFFF


def test_what_was_sent_stands_in_the_capture(tmp_path: Path) -> None:
    capture = Capture(tmp_path / "a.pcap", lambda: 1.5)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as ear:
        ear.bind((HERE, 0))
        sender = UdpSender("--x", Address(*ear.getsockname()), joined=0, capture=capture)
        sender.send([b"odd", b"even"])
        assert ear.recvfrom(9)[0] == b"odd"
        _, (_, port) = ear.recvfrom(9)
        sender.close()
        to = ear.getsockname()[1]
    CaptureSender(capture, (HERE, 5), ("239.254.2.0", 50102)).send([b"group"])
    CaptureSender(capture, ("fe80::1%lo", 5), ("ff02::1", 7)).send([b"six"])
    capture.close()
    capture.close()
    capture.take((HERE, 1), (HERE, 2), b"after the end")
    got = frames(tmp_path / "a.pcap")
    assert [time for time, _ in got] == [1.5] * 4
    for (_, frame), datagram, ports in zip(
        got[:3], (b"odd", b"even", b"group"), ((port, to), (port, to), (5, 50102)), strict=True
    ):
        assert frame[12:14] == b"\x08\x00" and words_sum(frame[14:34]) == 0xFFFF
        assert struct.unpack_from(">HHH", frame, 34) == (*ports, 8 + len(datagram)) and frame[42:] == datagram
        assert int.from_bytes(frame[16:18], "big") == len(frame) - 14 and frame[23] == 17
    assert got[2][1][:6] == bytes.fromhex("01005e7e0200") and got[2][1][30:34] == bytes([239, 254, 2, 0])
    six = got[3][1]
    assert six[:6] == bytes.fromhex("333300000001") and six[12:14] == b"\x86\xdd" and six[62:] == b"six"
    pseudo = six[22:54] + struct.pack(">II", len(six) - 54, 17) + six[54:]
    assert words_sum(pseudo) == 0xFFFF


def test_ports_share_the_capture_and_nothing_is_overwritten_unasked(tmp_path: Path) -> None:
    capture = ["--pcap", str(tmp_path / "new" / "a.pcap")]
    words = ["replay", "a.mcap", "--asterix", "8600", *capture]
    for options in (parser("replay").parse_args(words), parser("replay").parse_args([*words, "--overwrite"])):
        for port in (VIDEO.opened(options), udp.opened(options)):
            assert port is not None
            port.close()
        assert frames(tmp_path / "new" / "a.pcap") == []
    with pytest.raises(FileExistsError, match="--overwrite"):
        VIDEO.opened(parser("replay").parse_args(words))
    assert udp.opened(parser("serve").parse_args(["serve"])) is None
    with pytest.raises(UsageError, match="--pcap: no port sends by UDP; give one that does, as --asterix"):
        udp.opened(parser("serve").parse_args(["serve", *capture]))


def test_a_process_that_is_killed_leaves_whole_frames(tmp_path: Path) -> None:
    capture = Capture(tmp_path / "a.pcap")
    for count in range(1, 20):
        capture.take((HERE, 1), (HERE, 2), b"x" * 1000)
        assert len(frames(tmp_path / "a.pcap")) == count
    capture.close()


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="this system has no full disk to write to")
def test_a_full_disk_ends_the_start_and_later_the_capture_alone(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    import resource

    with pytest.raises(OSError, match="/dev/full"):
        Capture(Path("/dev/full"))
    gives_up, raises = Capture(tmp_path / "a.pcap"), Capture(tmp_path / "b.pcap", raises=True)
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (5000, before[1]))
    try:
        for _ in range(200):
            gives_up.take((HERE, 1), (HERE, 2), b"x" * 1000)
        with pytest.raises(OSError, match="large"):
            for _ in range(200):
                raises.take((HERE, 1), (HERE, 2), b"x" * 1000)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    gives_up.close()
    raises.close()
    assert [record.message for record in caplog.records] == ["capture given up"]
