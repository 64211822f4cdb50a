"""The command `export`: captures of a recorded run hold what ports sent, with the time of each spoke."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from radar_service.__main__ import main
from radar_service.display.video import Controls
from radar_service.ports.asterix.asterix_port import PlotSink, VideoSink
from radar_service.ports.asterix.blocks import Form
from radar_service.ports.dialect.announcements import Announcements, DialectSink, Senders
from radar_service.ports.garmin_xhd.datagrams import XHD
from radar_service.ports.navico_halo.datagrams import HALO
from radar_service.ports.udp.udp_port import UdpPort
from radar_service.recording import read, replay_station
from radar_service.service.settings import Settings
from radar_service.service.spokes import Epoch, RadarInfo, SpokeBatch, SpokeSink
from tests.ports.asterix.reading import videos
from tests.ports.kept import Kept
from tests.ports.udp.test_capture import frames
from tests.recording.scenes import AZIMUTHS, recorded, simulator


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return recorded(tmp_path_factory.mktemp("run") / "run.mcap", scans=2)


def sent_live(path: Path, sink: SpokeSink) -> None:
    """What the recorded simulator sends, in blocks of another size."""
    recording, source = read(path), simulator()
    epoch = Epoch("e", source, None, start_utc=recording.start_utc)  # type: ignore[arg-type]
    sink.open_epoch(RadarInfo.unnamed(epoch))
    video, before = replay_station.recorded_settings(recording, Settings()).video, None
    first = 0
    for block in source.blocks(scans=2, size=7):
        sink.send(SpokeBatch(epoch, first, block, video, before))
        first, before = first + len(block), block.power[-1]


def datagrams(path: Path, port: int) -> Iterator[tuple[float, bytes]]:
    """Those of a capture to a port, with their times."""
    return ((time, frame[42:]) for time, frame in frames(path) if int.from_bytes(frame[36:38], "big") == port)


def test_captures_hold_what_ports_send(
    run: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """With controls that look at the spoke before."""
    settings = Settings(video=Controls(gain=60.0, gain_auto=False, interference_rejection=True))
    monkeypatch.setattr(replay_station, "recorded_settings", lambda *_: settings)
    files = {name: tmp_path / f"{name}.pcap" for name in ("asterix", "asterix-plots", "garmin-xhd", "navico-halo")}
    options: list[Any] = [word for name, file in files.items() for word in (f"--{name}", str(file))]
    assert main(["export", str(run), *options, "--asterix-bits", "16", "--asterix-sac", "5"]) == 0
    assert f"{2 * AZIMUTHS} spokes of radar 0" in capsys.readouterr().out
    video = Kept()
    sent_live(run, VideoSink(UdpPort([video]), 1, Form(5, 16)))
    got = list(datagrams(files["asterix"], 8600))
    assert [content for _, content in got if len(content) > 300] == [each for each in video.pieces if len(each) > 300]
    plots = Kept()
    sent_live(run, PlotSink(UdpPort([plots]), 1, 5))
    assert plots.pieces and [content for _, content in datagrams(files["asterix-plots"], 8600)] == plots.pieces
    start = read(run).start_utc
    assert start is not None
    time, first = next((time, videos([content])[0]) for time, content in got[5:] if videos([content]))
    assert abs(first.time - (time - start.timestamp() + start.hour * 3600 + start.minute * 60 + start.second)) < 1 / 128
    for dialect, least in ((XHD, 2 * 1440 - 100), (HALO, 2 * 2048 // 32 - 3)):
        to = Senders(Kept(), Kept(), Kept())
        sent_live(run, DialectSink(Announcements(dialect, "", to), lambda: True, lambda: True, lambda lost: None))
        found, reports, spokes = (
            [content for _, content in datagrams(files[dialect.name], port)] for _, port in dialect.destinations
        )
        assert len(spokes) >= least and spokes == to.spokes.pieces  # type: ignore[attr-defined]
        assert len(reports) > 25 and len(found) == 4  # in 3.6 s


def test_what_cannot_be_exported_is_said_in_a_sentence(
    run: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(run.read_bytes()[:10_000])
    full = tmp_path / "full.pcap"
    full.symlink_to("/dev/full")
    same = str(tmp_path / "same.pcap")
    for words, reason in (
        ([str(cut), "--asterix", same], "cut.mcap: it ends before the first spoke of radar 0"),
        ([str(run), "--asterix", same, "--garmin-xhd", same], "--asterix and --garmin-xhd name one file"),
        ([str(run), "--asterix", str(full), "--overwrite"], "full.pcap: No space left"),
        (
            [str(run)],
            "nothing to write; give --asterix FILE.pcap or --asterix-plots FILE.pcap or",
        ),
        (["none.mcap", "--asterix", str(tmp_path / "a.pcap")], "there is no such file"),
        ([str(run), "--asterix", str(tmp_path / "a.pcap"), "--radar", "stern"], 'the recording has no "stern"'),
        ([str(run), "--asterix", str(run.with_suffix(".pcap"))], "exists already"),
    ):
        run.with_suffix(".pcap").touch()
        assert main(["export", *words]) == 2
        assert reason in capsys.readouterr().err
    assert not Path(same).exists()
