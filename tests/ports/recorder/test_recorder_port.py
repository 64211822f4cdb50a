"""The recorder as a port: it delays radars, says which sources it needs, and closes its file."""

from pathlib import Path

import pytest

from radar_service.ports.port_host import PortHost
from radar_service.ports.recorder.recorder_port import RecorderPort
from radar_service.recording import Recording, read
from radar_service.recording.error import RecordingError
from radar_service.records.cell_sources import SourceRequest
from radar_service.service.spokes import Epoch, RadarInfo, SpokeBatch
from tests.service.fake import FakeEngine, scene


def test_what_its_sinks_take_is_in_the_file(tmp_path: Path) -> None:
    port, engine = RecorderPort(tmp_path / "a.mcap", False, SourceRequest()), FakeEngine(scene())
    host = PortHost((port,))
    (sink,) = host.sinks("0")
    epoch = Epoch("one", engine, None)  # type: ignore[arg-type]
    sink.open_epoch(RadarInfo("0", "radar 0", epoch, 0.0, {"pace": {}}, False))
    sink.send(SpokeBatch(epoch, 0, engine.block(0, 5), None))  # type: ignore[arg-type]
    port.close()
    assert [spoke.number for spoke in read(tmp_path / "a.mcap").spokes()] == list(range(5))


def test_the_sources_that_are_recorded_are_asked_for(tmp_path: Path) -> None:
    port = RecorderPort(tmp_path / "a.mcap", False, SourceRequest(True, (256,)))
    assert PortHost((port,)).sources == SourceRequest(True, (256,))
    port.close()


def test_its_file_is_closed_without_a_spoke_too(tmp_path: Path) -> None:
    RecorderPort(tmp_path / "a.mcap", False, SourceRequest()).close()
    with pytest.raises(RecordingError, match="ends before its first message"):
        Recording(tmp_path / "a.mcap")


def test_a_file_that_cannot_be_written_is_an_error_at_once(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError):
        RecorderPort(tmp_path / "none" / "a.mcap", False, SourceRequest())
