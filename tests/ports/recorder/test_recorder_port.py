"""The recorder of a service: a disk that is full, slow or broken ends the recording with a line, and the feed goes on."""

import asyncio
import contextlib
import errno
import logging
import threading
from collections.abc import Callable
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from radar_service.ports.port_host import PortHost
from radar_service.ports.recorder.recorder_port import MAX_WAITING, RecorderPort, Work
from radar_service.recording import Recording, read
from radar_service.recording.error import RecordingError
from radar_service.records.cell_sources import SourceList, SourceRequest
from tests.ports.playing import FLAT_OUT, playing, station
from tests.service.fake import AZIMUTHS, SOURCES, FakeEngine, labels_of, scene


@pytest.fixture
def lines() -> Any:
    got: list[str] = []
    handler = logging.Handler(logging.ERROR)
    handler.emit = lambda record: got.append(f"{record.getMessage()} {getattr(record, 'fields', {}).get('reason')}")  # type: ignore[method-assign]
    logger = logging.getLogger("radar_service")
    logger.addHandler(handler)
    yield got
    logger.removeHandler(handler)


def play(
    recorder: RecorderPort, count: int, before: Callable[[], None] = lambda: None, engine: FakeEngine | None = None
) -> list[int]:
    """Runs a fake radar that is recorded; returns the numbers of so many spokes that a lossless client got."""

    async def body() -> list[int]:
        radar = station(
            engine, settings=FLAT_OUT, wait_for=1, allow_truth=True, sinks=recorder.sinks("0"), recorded=recorder.sources
        )  # fmt: skip
        async with playing(radar) as server:
            before()
            got = await (await server.feed("?mode=lossless")).spokes(count)
        return [n for message in got for n in range(message["first"], message["first"] + message["count"])]

    with contextlib.closing(recorder):
        return asyncio.run(asyncio.wait_for(body(), 60))


def test_what_a_client_gets_is_recorded(tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    numbers = play(RecorderPort(path, True), 3 * AZIMUTHS)
    result = read(path)
    got = list(result.spokes())
    assert [spoke.number for spoke in got[: len(numbers)]] == numbers and got[30].power[1] == FakeEngine(scene()).block(
        30, 1
    ).power[0, 1]
    assert [line.time > 0 for line in result.truth_lines(0)] == [True] * 3
    assert result.record["controls"]["pace"]["factor"] == "max" and result.record["plan"] == {"modelled": []}


def test_labels_are_recorded_that_no_client_asks_for(tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    play(RecorderPort(path, False, SourceRequest(True, (256,))), 3 * AZIMUTHS)
    result = read(path)
    assert result.label_names == SOURCES
    spokes = list(result.spokes())
    assert len(spokes) >= 3 * AZIMUTHS
    for spoke in spokes:
        np.testing.assert_array_equal(spoke.labels, labels_of([spoke.number], len(spoke.power))[0])
        assert spoke.powers is not None and spoke.powers[256].tobytes() == spoke.power.tobytes()


def test_a_radar_without_labels_is_recorded_without_them(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    engine = FakeEngine(scene())
    engine.sources = SourceList(SOURCES, no_labels="it has several pulses")
    path = tmp_path / "a.mcap"
    play(RecorderPort(path, False, SourceRequest(True, (256, 999))), AZIMUTHS, engine=engine)
    spoke = next(read(path).spokes())
    assert spoke.labels is None and spoke.powers is not None and list(spoke.powers) == [256]
    assert "sources are not all recorded" in caplog.text


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs /dev/full")
def test_a_full_disk_is_logged_and_the_feed_goes_on(lines: list[str], tmp_path: Path) -> None:
    (path := tmp_path / "full.mcap").symlink_to("/dev/full")
    recorder = RecorderPort(path, False)
    assert play(recorder, 5 * AZIMUTHS)[: 5 * AZIMUTHS] == list(range(5 * AZIMUTHS))
    assert lines == [f"recording failed, the feed goes on {path}: No space left on device"]
    assert recorder.fault == f"{path}: No space left on device"


def test_a_disk_that_is_full_after_a_while_leaves_what_is_whole(lines: list[str], tmp_path: Path) -> None:
    path = tmp_path / "later.mcap"
    recorder = RecorderPort(path, False, create=lambda _: Limited())
    assert len(play(recorder, 40 * AZIMUTHS)) >= 40 * AZIMUTHS
    assert len(lines) == 1 and "File too large" in lines[0]
    path.write_bytes(Limited.content)
    kept = [spoke.number for spoke in Recording(path).spokes()]
    assert 0 < len(kept) < 40 * AZIMUTHS and kept == list(range(len(kept))) and len(kept) % AZIMUTHS == 0


class Limited(BytesIO):
    """A file on a disk that takes 60 kB. content: what it took."""

    content = b""

    def write(self, data: Any) -> int:
        super().write(data[: 60_000 - self.tell()])
        Limited.content = self.getvalue()
        if self.tell() >= 60_000:
            raise OSError(errno.EFBIG, "File too large")
        return len(data)


def test_a_disk_that_takes_too_long_ends_the_recording(lines: list[str], tmp_path: Path) -> None:
    path, hung = tmp_path / "slow.mcap", threading.Event()
    recorder = RecorderPort(path, False, patience=0.05)

    def hang() -> None:
        recorder.put(Work(lambda: hung.wait(30) and None, MAX_WAITING))

    numbers = play(recorder, 2 * AZIMUTHS, hang)
    hung.set()
    assert numbers[: 2 * AZIMUTHS] == list(range(2 * AZIMUTHS))
    assert lines == [f"recording failed, the feed goes on {path}: the disk took more than 0.05 s"]


def test_whatever_goes_wrong_in_the_thread_ends_only_the_recording(lines: list[str], tmp_path: Path) -> None:
    def broken() -> None:
        raise ZeroDivisionError("by nothing")

    recorder = RecorderPort(tmp_path / "a.mcap", False)
    assert play(recorder, AZIMUTHS, lambda: recorder.put(Work(broken)))[0] == 0
    assert "a.mcap: ZeroDivisionError: by nothing" in lines[0]


def test_an_end_of_scan_waits_for_the_one_before(tmp_path: Path) -> None:
    """So that the truth of a scan is known before the next one is sent, however fast the radar is."""
    done, release = list[int](), threading.Event()
    with contextlib.closing(RecorderPort(tmp_path / "a.mcap", False)) as recorder:
        recorder.put(Work(lambda: done.append(release.wait(10) and 1), ends_scan=True))
        recorder.put(Work(lambda: done.append(2)))
        second = threading.Thread(target=recorder.put, args=[Work(lambda: done.append(3), ends_scan=True)])
        second.start()
        second.join(0.05)
        assert second.is_alive() and not done
        release.set()
        second.join(10)
    assert done == [1, 2, 3]


def test_the_sources_that_are_recorded_are_asked_for(tmp_path: Path) -> None:
    port = RecorderPort(tmp_path / "a.mcap", False, SourceRequest(True, (256,)))
    assert PortHost((port,)).sources == SourceRequest(True, (256,))
    port.close()


def test_its_file_is_closed_without_a_spoke_too(tmp_path: Path) -> None:
    RecorderPort(tmp_path / "a.mcap", False).close()
    with pytest.raises(RecordingError, match="ends before its first message"):
        Recording(tmp_path / "a.mcap")


def test_a_file_that_cannot_be_written_is_named_at_once(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError, match="none/a.mcap"):
        RecorderPort(tmp_path / "none" / "a.mcap", False)
