"""The plots of a process are those of an extractor here, also in a port, where a new process follows one that has ended."""

from dataclasses import replace

import pytest

from radar_service.plots.extractor import PlotExtractor
from radar_service.plots.marine import MarineThreshold
from radar_service.plots.plot_process import PlotProcess
from radar_service.ports.asterix.plot_blocks import PlotSink
from radar_service.ports.udp.udp_port import UdpPort
from radar_service.processes.fork_server import ForkServer
from radar_service.scans.scan import scan_of
from tests.commands.test_export import Kept
from tests.ports.asterix.test_plot_blocks import SOURCE, plots, sent
from tests.ports.reflectors import radar_of


def test_a_process_extracts_as_this_one() -> None:
    """The same plots, and an error where it has ended; a port goes on with another one."""
    radar, first = SOURCE().scene.radar, scan_of([batch.block for batch in sent()[:45]])
    told, server, kept = (list[str](), list[str]()), ForkServer(), Kept()
    process = PlotProcess(server, told[0].append).begin(radar)
    here = PlotExtractor(radar, MarineThreshold(radar), tell=told[1].append)
    for scan in (first, replace(first, number=1)):
        assert process.add(scan).plots == here.add(scan).plots
    assert told[0] == told[1]
    process.close()
    with pytest.raises((OSError, EOFError)):
        process.add(first)
    port = UdpPort([kept])
    port.fork_server = server
    sink = PlotSink(port, 1, 0)
    sink.open_epoch(radar_of(SOURCE()))
    for batch in sent()[:45]:
        sink.send(batch)
    sink.close("end")
    server.close()
    assert sum(len(block) - 3 for block in kept.pieces) == 14 * len(plots())
