"""ASTERIX: video and plots against the truth, the cells that were sent, and true north; the port on loopback."""

import asyncio
import math
import socket
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from radar_service.commands.command_line import parser
from radar_service.plots.extractor import LivePlots, PlotExtractor
from radar_service.plots.marine import MarineThreshold
from radar_service.plots.plot import Plot
from radar_service.ports.asterix import PLOTS, VIDEO
from radar_service.ports.asterix.asterix_port import AsterixPort, PlotSink
from radar_service.ports.asterix.blocks import IN_BLOCK, Form, plot_blocks, summary, video
from radar_service.ports.udp.addresses import Address
from radar_service.ports.udp.sender import UdpSender
from radar_service.ports.udp.udp_port import UdpPort
from radar_service.service.settings import Pace, Settings
from radar_service.service.spokes import SpokeBatch
from tests.ports.asgi import Server
from tests.ports.asterix.reading import Video, blocks, record, reports, videos
from tests.ports.kept import Kept
from tests.ports.playing import play
from tests.ports.reflectors import batches, crossings, radar_of, simulator
from tests.reference.true_north import true_deg
from tests.service.fake import AZIMUTHS, BINS


# blocks: video of category 240.
@pytest.mark.parametrize("bits", [8, 16])
def test_the_cell_and_the_sector_of_each_peak_hold_the_truth(bits: int) -> None:
    """Cells are whole, so a peak is within its own: no margin beside the last bit of the azimuth."""
    source = simulator()
    radar, form = radar_of(source), Form(7, bits, 65507)
    got = videos([each for batch in batches(radar, source) for spoke in video(batch, form, 3) for each in spoke])
    assert len(got) == 720 and {(*each.source, len(each.cells)) for each in got} == {(7, 3, source.range.size)}
    image = np.array([each.cells for each in got])
    truth = crossings(source)
    assert len(truth) == 5
    for crossing in truth:
        near = abs(np.arange(image.shape[1]) * got[0].cell - crossing["range"]) < 30.0
        row, cell = np.unravel_index(np.argmax(np.where(near, image, -1)), image.shape)
        peak = got[row]
        assert peak.first + cell * peak.cell <= crossing["range"] < peak.first + (cell + 1) * peak.cell
        bearing = true_deg(crossing["bearing"], [0.0, 0.0], (50.0, 1.0)) / 360.0
        assert (bearing - peak.begin) % 1.0 <= (peak.end - peak.begin) % 1.0 + 2 / 65536
        assert abs((86399.0 + crossing["time"]) % 86400.0 - peak.time) < 1 / 128 + 2.5 / 720


@pytest.mark.parametrize(("bits", "largest"), [(8, 256), (8, 1400), (16, 1400), (16, 1500), (8, 65507), (16, 65507)])
def test_spokes_are_split_where_they_are_too_long(bits: int, largest: int) -> None:
    """All cells come once, in order, in as few blocks as the items allow, and lost blocks can be counted."""
    source = simulator(64)
    radar, form = radar_of(source), Form(0, bits, largest)
    number = 0
    for batch in batches(radar, source):
        expected = batch.video_bytes(batch.epoch.layout(None))
        for k, spoke in enumerate(video(batch, form, 1)):
            assert all(len(each) <= largest for each in spoke) and len(spoke) == math.ceil(source.range.size / form.cells)
            got = videos(spoke)
            assert [each.sequence for each in got] == list(range(number, number + len(got)))
            assert np.allclose([each.first for each in got], np.arange(len(got)) * form.cells * source.range_step, atol=1e-3)
            cells = np.concatenate([each.cells for each in got])
            if bits == 8:
                assert cells.tolist() == expected[k].tolist()
            else:
                level = 10.0 * np.log10(np.maximum(batch.block.power[k], 1e-40) / source.noise_power)
                assert np.allclose(cells, np.clip((level + 100.0) * 100.0, 0.0, 65535.0), atol=0.51)
            number += len(got)


def test_azimuths_count_from_true_north_and_a_lost_heading_sends_nothing() -> None:
    """600 km to the east of the origin map and true north differ by 9 degrees."""
    source = simulator(64)
    batch = next(batches(radar_of(source), source, size=2))
    far, lost = np.array([[6e5, 0.0], [0.0, 0.0]]), np.array([math.nan, 0.5])
    (first,), (second,) = video(replace(batch, block=replace(batch.block, position=far)), Form(), 1)
    for block, place in ((first, far[0]), (second, far[1])):
        (got,) = videos([block])
        middle = got.begin + (got.end - got.begin) % 1.0 / 2.0
        north = true_deg(float(batch.block.azimuth[int(block is second)]), place.tolist(), (50.0, 1.0)) / 360.0
        assert abs((middle - north + 0.5) % 1.0 - 0.5) <= 0.51 / 65536
    assert list(video(replace(batch, block=replace(batch.block, heading=lost)), Form(), 1)) == [[], [second]]


def test_the_summary_says_north_and_law() -> None:
    radar = radar_of(simulator(8))
    for bits in (8, 16):
        (content,) = blocks(summary(radar, Form(0, bits), 2))
        text = record(content)
        assert not isinstance(text, Video) and "reflectors" in text and "true north" in text and f"{bits} bit" in text


# blocks: plots of category 048 against the extractor's.
UNIT = 1852.0 / 256.0  # m
SOURCE = cache(simulator)


@cache
def sent() -> list[SpokeBatch]:
    return list(batches(radar_of(SOURCE()), SOURCE(), 2))


@cache
def plots() -> list[Plot]:
    """The plots of the first one."""
    radar = SOURCE().scene.radar
    extractor = PlotExtractor(radar, MarineThreshold(radar))
    live = LivePlots(720, lambda: lambda scan: extractor.add(scan).plots, list[int]().append)
    return [plot for batch in sent()[:45] for plot in live.add(batch.block)]


def test_reports_are_the_plots_to_the_last_bit_and_near_the_truth() -> None:
    source, got = SOURCE(), Kept()
    sink = PlotSink(UdpPort([got]), 3, 7)
    sink.open_epoch(radar_of(source))
    for batch in sent()[:45]:
        sink.send(batch)
    found, truth = reports(got.pieces), sorted(crossings(source), key=lambda crossing: crossing["time"])
    assert len(found) == len(plots()) == len(truth) == 5
    for each, plot, crossing in zip(found, plots(), truth, strict=True):
        assert (each.source, each.type) == ((7, 3), "primary simulated")
        assert abs(each.range - plot.range) <= 0.5 * UNIT + 1e-9 and abs(plot.range - crossing["range"]) < 0.1
        bearing = true_deg(crossing["bearing"], [0.0, 0.0], (50.0, 1.0)) / 360.0
        assert abs((each.bearing - bearing + 0.5) % 1.0 - 0.5) <= 0.51 / 65536 + 1e-5
        assert abs((86399.0 + crossing["time"]) % 86400.0 - each.time) <= 0.5 / 128 + 1e-3
        assert abs(each.amplitude - (10.0 * math.log10(source.noise_power) + 30.0 + plot.snr_db)) <= 0.5
        extent = (plot.bearing_extent[1] - plot.bearing_extent[0]) % (2.0 * math.pi)
        assert abs(each.run - min(extent / (2.0 * math.pi), 255 / 8192)) <= 0.5 / 8192


def test_blocks_fit_a_frame_and_values_the_items() -> None:
    plot, epoch = plots()[0], radar_of(SOURCE()).epoch
    blocks = plot_blocks([plot] * (IN_BLOCK + 1), epoch, 0, 1)
    assert [len(reports([each])) for each in blocks] == [IN_BLOCK, 1] and all(len(each) <= 1400 for each in blocks)
    wide = replace(plot, range=1e6, snr_db=400.0, bearing_extent=(0.0, 6.0), time=1.0)  # a second behind midnight
    ring = replace(wide, bearing_extent=(1.0, 1.0))
    for got in reports(plot_blocks([wide, ring], epoch, 0, 1)):
        assert (got.range, got.run, got.amplitude, got.time) == (65535 * UNIT, 255 / 8192, 127, 0.0)


def test_bearings_count_from_true_north_where_own_ship_is() -> None:
    """600 km to the east of the origin map and true north differ by 9 degrees."""
    plot, far = plots()[0], np.array([6e5, 0.0])
    east, north = far + plot.range * np.array([math.sin(plot.bearing), math.cos(plot.bearing)])
    (got,) = reports(plot_blocks([replace(plot, east=east, north=north)], radar_of(SOURCE()).epoch, 0, 1))
    expected = true_deg(plot.bearing, far.tolist(), (50.0, 1.0)) / 360.0
    assert abs((got.bearing - expected + 0.5) % 1.0 - 0.5) <= 0.51 / 65536


@pytest.mark.parametrize("change", ["repeated", "heading lost", "standby", "labels end"])
def test_what_has_no_bearing_or_comes_again_is_lost(change: str) -> None:
    port = UdpPort([got := Kept()])
    sink = PlotSink(port, 1, 0)
    sink.open_epoch(radar_of(SOURCE()))
    for batch in sent():
        first, scan = batch.block.index, batch.block.scan
        if change == "standby" and 300 <= scan * 720 + first < 1000:  # the rest of the first scan comes never
            continue
        labels = np.zeros(batch.block.power.shape, dtype=np.uint32) if change == "labels end" and first < 300 else None
        lost = np.full(len(batch), math.nan) if change == "heading lost" and scan == 0 else batch.block.heading
        for _ in range(1 + (change == "repeated" and first == 0)):
            sink.send(replace(batch, block=replace(batch.block, heading=lost, labels=labels)))
    counts = {"repeated": (10, 32), "heading lost": (5, 720), "standby": (3, 0), "labels end": (10, 0)}
    assert (len(reports(got.pieces)), port.lost) == counts[change]


# asterix_port: all spokes, in order, with a summary; a reader that is absent delays nobody.
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
