"""The port of ASTERIX on loopback: all spokes, in order, with a summary; a reader that is absent delays nobody."""

import asyncio
import socket

from radar_service.commands.command_line import parser
from radar_service.ports.asterix import PLOTS, VIDEO
from radar_service.ports.asterix.asterix_port import AsterixPort
from radar_service.ports.asterix.blocks import Form
from radar_service.ports.udp.addresses import Address
from radar_service.ports.udp.sender import UdpSender
from radar_service.service.settings import Pace, Settings
from tests.ports.asgi import Server
from tests.ports.asterix.reading import Video, blocks, record
from tests.ports.playing import play
from tests.service.fake import AZIMUTHS, BINS

HERE = "127.0.0.1"


def test_a_reader_gets_all_spokes_and_a_summary_each_scan() -> None:
    ear = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    ear.bind((HERE, 0))
    ear.settimeout(30)
    sender = UdpSender("--asterix", Address(*ear.getsockname()), joined=0)
    port = AsterixPort([sender], Form(1))
    got: list[str | Video] = []

    async def listen(server: Server) -> None:
        while len([each for each in got if isinstance(each, Video)]) < 2 * AZIMUTHS:
            got.extend(map(record, blocks(await asyncio.to_thread(ear.recv, 2**16))))

    host = play(port, listen, Settings(pace=Pace("run", 10.0)))
    ear.close()
    videos = [each for each in got if isinstance(each, Video)]
    assert [each.sequence for each in videos] == list(range(len(videos)))
    assert {(each.source, len(each.cells)) for each in videos} == {((1, 1), BINS)}
    assert isinstance(got[0], str) and isinstance(got[AZIMUTHS + 1], str) and len(got) - len(videos) <= 3
    assert host.threads[port].faults == 0


def test_replay_has_its_options() -> None:
    assert parser("replay").parse_args(["replay", "a.mcap"]).asterix_sac == 0
    for package in (VIDEO, PLOTS):
        assert package.opened(parser("serve").parse_args(["serve"])) is None
        allowed = f"--{package.name} 127.0.0.1:8600 --asterix-bits 16 --asterix-datagram 65507 --asterix-sac 9"
        port = package.opened(parser("replay").parse_args(["replay", *allowed.split(), "a.mcap"]))
        assert isinstance(port, AsterixPort) and port.name == package.name
        port.close()
