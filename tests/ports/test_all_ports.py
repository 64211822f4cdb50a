"""All ports at once: the feed keeps its promises while programs read NMEA, AIS, Signal K, ASTERIX, xHD and HALO, or never."""

import asyncio
import contextlib
import json
import socket
from collections.abc import Iterator

import pytest

from radar_service.ports.ais.ais_port import AisPort
from radar_service.ports.app import create_app
from radar_service.ports.asterix.asterix_port import AsterixPort, PlotPort
from radar_service.ports.asterix.blocks import Form
from radar_service.ports.feed.feed_socket import FeedPort
from radar_service.ports.navico_halo.datagrams import HALO
from radar_service.ports.nmea.listeners import TcpSender
from radar_service.ports.nmea.nmea_port import NmeaPort
from radar_service.ports.port_host import PortHost
from radar_service.ports.rest.rest_port import RestPort
from radar_service.ports.signalk.signalk_port import SignalKPort
from radar_service.ports.udp.addresses import Address
from radar_service.ports.udp.sender import UdpSender
from radar_service.scene_file.load import load_scene
from radar_service.service.radio.station import Station
from tests.ports.asgi import running
from tests.ports.dialect.test_dialect import Display
from tests.ports.garmin_xhd.reading import read_spoke
from tests.ports.navico_halo.reading import read_frame
from tests.ports.nmea.test_senders import free_port
from tests.ports.playing import FLAT_OUT
from tests.ports.signalk.protobuf import spokes
from tests.service.fake import AZIMUTHS, RADAR, FakeEngine, factory

HERE = "127.0.0.1"
SCANS = 10
SHIPS = [
    {"name": f"ship {k}", "shape": "point", "rcs_dbsm": 20, "mmsi": 211_000_000 + k, "course_deg": 36 * k, "speed_kn": 12}
    for k in range(10)
]


@pytest.fixture
def senders() -> Iterator[list[TcpSender]]:
    made = [TcpSender(f"--{name}-tcp", Address(HERE, 0), []) for name in ("nmea", "ais")]
    yield made
    for sender in made:
        sender.close()


def test_the_feed_keeps_its_promises_beside_all_ports(senders: list[TcpSender]) -> None:
    """A lossless client gets each spoke once and in order, readers get whole sentences, and no port has a fault."""
    scene = load_scene({"radar": RADAR, "origin": {"latitude_deg": 54.0, "longitude_deg": 8.0}, "body": SHIPS})
    video, shown, halo = UdpSender("--asterix", Address(HERE, free_port()), joined=0), Display(), Display(HALO)
    ports = (
        NmeaPort([senders[0]]),
        AisPort([senders[1]]),
        SignalKPort(),
        AsterixPort([video], Form()),
        PlotPort([video], Form()),
        shown.port,
        halo.port,
    )
    host = PortHost((RestPort(), FeedPort(), *ports))

    async def whole() -> None:
        station = Station("0", FakeEngine(scene), factory(), settings=FLAT_OUT, sinks=host.sinks("0"), wait_for=2)
        async with running(create_app([station], host)) as server:
            server.stations = [station]
            with contextlib.ExitStack() as on_end:
                readers = [on_end.enter_context(socket.create_connection(sender.address, 60)) for sender in senders]
                for sender in senders:
                    on_end.enter_context(socket.create_connection(sender.address, 60))  # connects, and never reads
                stream, idle = await server.open("/signalk/v1/stream?subscribe=all"), await server.open("/signalk/v1/stream")
                other = await server.open("/signalk/v2/api/vessels/self/radars/sim-0/spokes")
                lossless = await server.feed("?mode=lossless")
                got = await lossless.spokes(SCANS * AZIMUTHS)
                numbers = [n for m in got for n in range(m["first"], m["first"] + m["count"])]
                assert numbers == list(range(len(numbers)))
                assert spokes(await other.raw()) and json.loads(await stream.text())["name"] and idle.holds_message
                for reader in readers:
                    lines = (await asyncio.to_thread(reader.recv, 4096)).split(b"\r\n")
                    assert lines[0][:1] in b"$!" and all(b"*" in line for line in lines[:-1])
                health = (await server.http.get("/api/health")).json()
                assert health["status"] in ("ok", "behind") and health["radars"][0]["restarts"] == 0
        assert [thread.faults for thread in host.threads.values()] == [0] * 9
        assert {each.number for frame in halo.spokes.pieces for each in read_frame(frame)} == set(range(2048))
        assert {read_spoke(each).number for each in shown.spokes.pieces} == set(range(1440)) and video.lost == 0
        video.close()
        shown.close()
        halo.close()

    asyncio.run(asyncio.wait_for(whole(), 60))
