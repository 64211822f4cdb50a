"""A radar served on loopback, and whether it works."""

import contextlib
from collections.abc import Iterator

from radar_service.ports.app import create_app
from radar_service.service.settings import Pace, Settings
from tests.ports.playing import station
from tests.ports.serving import Turns, answer, dialled, served

Address = tuple[str, int]


GET = b"GET /api/health/alive HTTP/1.1\r\nhost: 127.0.0.1\r\nconnection: close\r\n\r\n"


UPGRADE = (
    b"GET /api/radars/0/feed HTTP/1.1\r\nhost: 127.0.0.1\r\nconnection: upgrade\r\nupgrade: websocket\r\n"
    b"sec-websocket-version: 13\r\nsec-websocket-key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n"
)


@contextlib.contextmanager
def radar(refused: list[str] | None = None, turns: Turns | None = None, **limits: float) -> Iterator[Address]:
    only = station(settings=Settings(pace=Pace(factor=10)))
    report = (lambda _: None) if refused is None else refused.append
    with served(create_app([only]), [only], turns, refused=report, **limits) as address:
        yield address


def works(address: Address) -> bool:
    with dialled(address) as connection:
        connection.sendall(GET)
        return b'{"yes":true}' in answer(connection)
