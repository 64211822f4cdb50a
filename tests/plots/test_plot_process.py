"""The plots of a process are those of an extractor here, also in a port. Nobody waits for it; what is too much is lost."""

import asyncio
import socket
import time
from collections.abc import Iterator
from dataclasses import replace
from threading import Thread
from types import SimpleNamespace
from typing import Any, cast

import pytest

from radar_service.plots.extractor import PlotExtractor
from radar_service.plots.marine import MarineThreshold
from radar_service.plots.plot_process import PlotProcess
from radar_service.ports.asterix.asterix_port import PlotPort
from radar_service.ports.asterix.blocks import Form
from radar_service.ports.port import Service
from radar_service.processes.channel import Channel
from radar_service.processes.fork_server import ForkServer
from radar_service.scans.scan import Scan, scan_of
from tests.ports.asterix.reading import reports
from tests.ports.asterix.test_asterix import SOURCE, plots, sent
from tests.ports.kept import Kept
from tests.ports.reflectors import radar_of


@pytest.fixture(scope="module")
def server() -> Iterator[ForkServer]:
    made = ForkServer(("radar_service.plots.plot_process",))
    yield made
    made.close()


def scans() -> Iterator[Scan]:
    """Scans that are alike."""
    first = scan_of([batch.block for batch in sent()[:45]])
    return (replace(first, number=number) for number in range(9))


def far_end(data: list[Channel]) -> ForkServer:
    """A server whose children have the near ends of `data`."""
    return cast(ForkServer, SimpleNamespace(child=lambda _: SimpleNamespace(data=data[0], close=data.pop().close)))


def test_a_process_extracts_as_this_one(server: ForkServer) -> None:
    radar, told, lost = SOURCE().scene.radar, (list[str](), list[str]()), list[int]()
    process = PlotProcess(server, radar, told[0].append, lost.append)
    here = PlotExtractor(radar, MarineThreshold(radar), tell=told[1].append)
    for scan, _ in zip(scans(), range(2), strict=False):
        assert process.add(scan) + process.ended(60.0) == [*here.add(scan).plots] != []
    process.close()
    assert told[0] == told[1] and sum(lost) == 0
    with pytest.raises((OSError, EOFError)):
        process.add(next(scans()))


def test_a_scan_waits_for_another_one_and_more_are_lost() -> None:
    """The test is the process: what it has not read and answered delays nobody."""
    near, far = (Channel(end) for end in socket.socketpair())
    radar, told, lost = SOURCE().scene.radar, list[str](), list[int]()
    process, each = PlotProcess(far_end([near]), radar, told.append, lost.append), scans()
    add = process.begun()

    def small() -> Scan:
        scan = next(each)
        return replace(scan, power=scan.power[:1, :8])

    def read() -> tuple[bool, int]:
        begins, scan = far.receive(60.0)
        return begins == radar, scan.number

    assert [add(small()) for _ in range(4)] == [[]] * 4 and lost == [720, 720]
    assert read() == (True, 0) and process.ended() == []
    far.send((plots(), ["flood"]))
    assert process.ended() == plots() and told == ["flood"]
    assert read() == (False, 1) and add(small()) == []  # 2 and 3 are lost, so 4 begins anew
    far.send(((), []))
    assert process.ended(1e-3) == [] and read() == (True, 4)
    assert process.begun()(small()) == [] and not far.wait(0.0)  # nothing is written before 4 is answered
    far.send((plots(), []))
    assert process.ended() == plots() and read() == (True, 5)
    add(small())
    process.close()
    assert sum(lost) == 4 * 720
    far.close()


def test_a_process_that_reads_nothing_delays_nobody() -> None:
    """A scan is more than a socket holds. The end of the process ends the thread that hands it over."""
    near, far = (Channel(end) for end in socket.socketpair())
    process = PlotProcess(far_end([near]), SOURCE().scene.radar, print, (lost := list[int]()).append)
    adding = Thread(target=process.add, args=(scan := next(scans()),), daemon=True)
    adding.start()
    adding.join(60.0)
    assert scan.power.nbytes > 2**20 and not adding.is_alive()
    far.close()
    with pytest.raises((OSError, EOFError)):
        process.ended(60.0)
    process.close()
    assert lost == [720]


def test_a_port_sends_all_plots_and_goes_on_where_a_process_has_failed(
    server: ForkServer, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The first process has gone. Of the second one nothing is lost at the end; that of another radar has no such end."""
    monkeypatch.setattr("radar_service.ports.asterix.asterix_port.PATIENCE", 60.0)
    ends = [Channel(end) for end in socket.socketpair()]
    ends.pop().close()
    broken, kept = far_end(ends), Kept()
    starts: Any = SimpleNamespace(child=lambda function: (broken if ends else server).child(function))
    port = PlotPort([kept], Form())
    asyncio.run(port.start(cast(Service, SimpleNamespace(fork_server=starts))))
    sinks = [port.sinks(radar)[0] for radar in ("0", "1")]
    for sink in sinks:
        sink.open_epoch(radar_of(SOURCE()))
    for batch in sent()[:44]:
        sinks[0].send(batch)
    with pytest.raises(ConnectionError, match="was killed or ran out of memory; .* free memory"):
        sinks[0].send(sent()[44])
    port.tick("0", 0.0)  # it has nothing to send
    for batch in sent()[45:]:
        sinks[0].send(batch)
    sinks[0].close("end")
    assert [len(reports([block])) for block in kept.pieces] == [len(plots())] and port.lost == 720
    for batch in sent()[:45]:
        sinks[1].send(batch)
    while len(kept.pieces) == 1:
        time.sleep(0.005)
        port.tick("1", 0.0)
    for batch in sent()[45:]:
        sinks[1].send(batch)
    asyncio.run(port.stop())
    assert len(kept.pieces) == 3 and {each.source for each in reports(kept.pieces[1:])} == {(0, 2)} and port.lost == 720
