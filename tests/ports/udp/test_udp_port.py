"""A port with senders: what is lost is counted, once."""

from collections.abc import Sequence

from radar_service.ports.port_thread import PortThread
from radar_service.ports.udp.udp_port import UdpPort


class Leaky:
    """A sender that loses all but the first piece, and cannot be closed."""

    lost = 0

    def send(self, pieces: Sequence[bytes]) -> None:
        self.lost += max(0, len(pieces) - 1)

    def close(self) -> None:
        raise OSError("gone")


class LeakyPort(UdpPort):
    name = "leaky"


def test_what_is_lost_is_counted_by_the_thread_of_the_port() -> None:
    port, thread = LeakyPort([Leaky(), Leaky()]), PortThread("leaky")
    port.send([b"a", b"b"])  # before it starts
    port.thread = thread
    for _ in range(2):
        port.send([b"a", b"b", b"c"])
    port.note_lost(1)
    port.note_lost(0)
    port.close()
    assert thread.dropped == 2 * 2 * 2 + 1
