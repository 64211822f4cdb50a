"""Plots of category 048 against the extractor's plots, the truth, and true north."""

import math
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from radar_service.plots.extractor import LivePlots, PlotExtractor
from radar_service.plots.marine import MarineThreshold
from radar_service.plots.plot import Plot
from radar_service.ports.asterix.asterix_port import PlotSink
from radar_service.ports.asterix.blocks import IN_BLOCK, plot_blocks
from radar_service.ports.udp.udp_port import UdpPort
from radar_service.service.spokes import SpokeBatch
from tests.ports.asterix.reading import reports
from tests.ports.kept import Kept
from tests.ports.reflectors import batches, crossings, radar_of, simulator
from tests.reference.true_north import true_deg

UNIT = 1852.0 / 256.0  # m
SOURCE = cache(simulator)


@cache
def sent() -> list[SpokeBatch]:
    """Two scans."""
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
