"""The command against a scripted feed: pictures, arrays, summaries and exit status."""

import json
import math
import os
import signal
import subprocess
import sys
from io import BytesIO
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image

import radar_service as rs
from clients.ppi.__main__ import main
from radar_service import wire
from radar_service.display.palettes import colour_map
from radar_service.display.picture import UNSEEN
from tests.clients import fake_feed
from tests.clients.fake_feed import DATA, GREETING, TARGETS, Script, batch, gap, hello, running

# The command with the handler of an interactive shell: a shell without job control has its background jobs ignore SIGINT.
# With an argument more, the signal comes while a message is put into the queue of received ones, the worst of all instants
INTERRUPTIBLE = """
import runpy, signal, sys
from websockets.asyncio.messages import SimpleQueue
signal.signal(signal.SIGINT, signal.default_int_handler)
def interrupted(self, item):
    if self.get_waiter is None:
        self.loop.call_soon(self.put, item)  # once somebody waits for it
        return
    self.queue.append(item)
    if not self.get_waiter.done():
        signal.raise_signal(signal.SIGINT)
        self.get_waiter.set_result(None)
if sys.argv.pop() == "within":
    SimpleQueue.put = interrupted
runpy.run_module("clients.ppi", run_name="__main__", alter_sys=True)
"""


def targets_in(png: bytes, up_deg: float, range_max: float = 2000.0) -> None:
    """Each target where theory puts it in a picture of the command, and nothing else as bright."""
    image = np.asarray(Image.open(BytesIO(png))).astype(int)
    size = image.shape[0]
    radius = (size - 2 * round(0.052 * size)) / 2
    lit: NDArray[np.bool_] = np.abs(image - colour_map()[255]).sum(axis=2) < 60
    for bearing_deg, distance in TARGETS:
        if distance > range_max:
            continue
        angle, far = math.radians(bearing_deg - up_deg), distance / range_max * radius
        y, x = size / 2 - 0.5 - far * math.cos(angle), size / 2 - 0.5 + far * math.sin(angle)
        i0, j0 = round(y) - 24, round(x) - 24
        pixels = np.argwhere(lit[i0 : i0 + 49, j0 : j0 + 49]) + (i0, j0)
        # a range bin is 20 m and the target's middle is known to half of one; a pixel of rounding
        assert np.abs(pixels.mean(axis=0) - (y, x)).max() <= 10.0 / range_max * radius + 1.0
        lit[i0 : i0 + 49, j0 : j0 + 49] = False
    assert not lit.any()


@pytest.mark.parametrize("head_up", [False, True])
def test_command_draws_targets_at_their_bearings_and_ranges(tmp_path: Path, head_up: bool) -> None:
    out = tmp_path / "ppi.png"
    messages = [GREETING, batch(40, 32, heading_deg=70.0), batch(72, 40, heading_deg=70.0)]
    with running(Script(messages, wait=True)) as feed:
        status = main([feed.url, "--out", str(out), "--size", "600", *(["--head-up"] if head_up else [])])
    assert status == 0
    targets_in(out.read_bytes(), 70.0 if head_up else 0.0)


def test_command_sends_the_token_of_its_file(tmp_path: Path) -> None:
    (tmp_path / "token").write_text("a-token-of-the-radar \nanother line\n")
    with running(Script([GREETING, batch(0, 72)], wait=True), Script([GREETING, batch(0, 72)], wait=True)) as feed:
        assert main([feed.url, "--token-file", str(tmp_path / "token")]) == main([feed.url]) == 0
    assert feed.authorizations == ["Bearer a-token-of-the-radar", ""]


def test_command_draws_a_shorter_range_and_reconnects_after_a_break(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "ppi.png"
    with running(Script([GREETING, batch(0, 30)], code=1011), Script([GREETING, batch(30, 42)], wait=True)) as feed:
        assert main([feed.url, "--out", str(out), "--range", "1500"]) == 0
    targets_in(out.read_bytes(), 0.0, 1500.0)
    output = capsys.readouterr()
    assert "close code 1011); trying again in 0.25 s" in output.err and "back after 0." in output.err
    assert "tried to reconnect 1 time(s)" in output.out


def test_command_saves_all_scans_as_arrays_and_counts_missing_spokes(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out, npz = tmp_path / "a.png", tmp_path / "a.npz"
    greeting = hello(encoding="u8-log")
    messages = [greeting, batch(0, 50, greeting), gap(greeting, 50, 10), batch(60, 12, greeting)]
    # the second scan begins with the first spoke after a hole, at 75
    messages += [batch(75, 69, greeting), batch(144, 3, greeting)]
    with running(Script(messages, wait=True)) as feed:
        arguments = [feed.url, "--scans", "2", "--encoding", "u8-log", "--out", str(out), "--npz", str(npz), "--bins", "100"]
        arguments += ["--mode", "lossless"]
        assert main(arguments) == 0
    assert feed.queries == [{"encoding": "u8-log", "bins": "100", "mode": "lossless"}]
    with np.load(npz) as saved:
        assert saved["samples"].shape == (2, 72, 100) and saved["samples"].dtype == np.uint8
        assert (saved["spoke"][0] < 0).sum() == 10 and (saved["spoke"][1] >= 0).all()
        assert saved["number"].tolist() == [0, 1]
        np.testing.assert_array_equal(saved["samples"][1], DATA)
        assert saved["time"][1, 0] == 144 / 30.0
        assert np.isnan(saved["heading"][0, 50:60]).all()
        np.testing.assert_allclose(saved["range"], (np.arange(100) + 0.5) * 20.0)
        np.testing.assert_allclose(saved["azimuth"], np.arange(72) * 2 * np.pi / 72)
        assert json.loads(str(saved["hello"]))["epoch"] == "a"
    output = capsys.readouterr()
    assert "2 scan(s) of 72 azimuths" in output.out and "10 lost and announced, 3 lost and not announced" in output.out
    assert output.err == ""  # no progress bar where there is no terminal


def test_command_paints_missing_azimuths_grey(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "a.png"
    with running(Script([GREETING, batch(0, 14), gap(GREETING, 14, 8), batch(22, 50)], wait=True)) as feed:
        assert main([feed.url, "--out", str(out), "--size", "300"]) == 0
    image = np.asarray(Image.open(out))
    assert image[150 - 4, 150 + 90].tolist() == list(UNSEEN)  # 14 to 21 of 72 are 070 to 105 degrees
    assert "64 azimuths received, 8 missing" in capsys.readouterr().out


def test_command_fails_with_a_sentence(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with running(Script([b"rubbish"])) as feed:
        assert main([feed.url, "--out", str(tmp_path / "a.png"), "--no-reconnect"]) == 1
    output = capsys.readouterr().err
    assert "not a message" in output and "Traceback" not in output
    assert not (tmp_path / "a.png").exists()


@pytest.mark.parametrize("instant", ["any", "within"])
def test_interrupting_the_command_is_clean(tmp_path: Path, instant: str) -> None:
    with running(Script([GREETING, batch(0, 5)], wait=True)) as feed:
        command = [sys.executable, "-c", INTERRUPTIBLE, feed.url, "--out", str(tmp_path / "a.png"), instant]
        process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True, cwd=Path(__file__).parents[2])
        if instant == "any":
            assert feed.greeted.wait(60)
            os.kill(process.pid, signal.SIGINT)
        _, err = process.communicate(timeout=60)
    assert process.returncode == 130
    assert "interrupted" in err and "Traceback" not in err
    assert not (tmp_path / "a.png").exists()


def test_command_writes_a_film(tmp_path: Path) -> None:
    out, greeting = tmp_path / "a.gif", hello()
    with running(Script([greeting, *(batch(36 * k, 36, greeting) for k in range(4))], wait=True)) as feed:
        assert main([feed.url, "--scans", "2", "--out", str(out), "--fps", "5", "--size", "200"]) == 0
    with Image.open(out) as made:
        assert (made.size, made.n_frames, made.info["duration"]) == ((200, 200), 24, 200)  # type: ignore[attr-defined]
        first = np.asarray(made.convert("RGB")).astype(int)
        made.seek(23)
        last = np.asarray(made.convert("RGB")).astype(int)
    lit = np.abs(last - first).sum(axis=2) > 60
    assert lit[:, :95].any() and lit[:, 105:].any()  # the grey that no spoke had reached, on either side


def test_a_reader_that_has_gone_ends_the_command_without_a_word(tmp_path: Path) -> None:
    reader, writer = os.pipe()
    os.close(reader)
    out = tmp_path / "a.png"
    with running(Script([GREETING, batch(0, 72)], wait=True)) as feed, os.fdopen(writer, "wb") as pipe:
        command = [sys.executable, "-m", "clients.ppi", feed.url, "--out", str(out)]
        ended = subprocess.run(command, stdout=pipe, stderr=subprocess.PIPE, cwd=Path(__file__).parents[2])
    assert (ended.returncode, ended.stderr) == (141, b"") and out.is_file()


def test_the_command_writes_only_the_requested_files(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    with running(Script([GREETING, batch(0, 72)], wait=True)) as feed:
        assert main([feed.url]) == 0
    assert "wrote no file: --out FILE" in capsys.readouterr().out and not list(tmp_path.iterdir())


@pytest.mark.parametrize("encoding", ["u8", "f32", "c64"])
def test_saved_scans_are_loaded_as_those_of_the_simulator(tmp_path: Path, encoding: str) -> None:
    npz, greeting = tmp_path / "a.npz", hello(encoding=encoding)
    came = fake_feed.spokes(greeting, DATA.astype(wire.DTYPES[encoding]), 72, 60)
    with running(Script([greeting, gap(greeting, 70, 2), came, gap(greeting, 132, 12)], wait=True)) as feed:
        assert main([feed.url, "--encoding", encoding, "--npz", str(npz)]) == 0
    if encoding == "u8":
        with pytest.raises(ValueError, match="holds no power"):
            rs.load_scan(npz)
        return
    scan = rs.load_scan(npz)
    assert scan.number == 1 and np.isnan(scan.time[60:]).all() and np.isnan(scan.power[60:]).all()
    np.testing.assert_array_equal(scan.power[:60] > 0, DATA[:60] > 0)
    assert np.isnan(scan.field[:60]).all() == (encoding == "f32")
    if encoding == "c64":
        np.testing.assert_array_equal(scan.power[:60], scan.field[:60].real ** 2 + scan.field[:60].imag ** 2)
    assert scan._repr_png_() and "72 azimuths" in repr(scan)


def test_labels_are_saved_with_the_scans(tmp_path: Path) -> None:
    """A spoke without labels, as from a scene that has none, has label 0."""
    npz, greeting = (
        tmp_path / "a.npz",
        hello(encoding="f32", sources=[{"number": 0, "name": "noise"}, {"number": 256, "name": "x"}]),
    )
    came = fake_feed.spokes(greeting, DATA.astype("<f4"), 0, 40)
    came["labels"] = np.where(DATA[:40] > 0, 256, 0).astype("<u4").tobytes()
    rest = fake_feed.spokes(greeting, DATA.astype("<f4"), 40, 32)
    with running(Script([greeting, came, rest], wait=True)) as feed:
        assert main([feed.url, "--encoding", "f32", "--npz", str(npz), "--labels"]) == 0
    assert feed.queries[0]["labels"] == "1"
    labels = rs.load_scan(npz).labels
    assert labels is not None and not labels[40:].any()
    np.testing.assert_array_equal(labels[:40] == 256, DATA[:40] > 0)
    with np.load(npz) as file:
        assert dict(zip(file["label_numbers"].tolist(), file["label_names"].tolist(), strict=True)) == {0: "noise", 256: "x"}


def test_the_command_says_that_the_heading_is_lost(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with running(Script([GREETING, batch(0, 72, heading_deg=math.nan)])) as feed:
        assert main([feed.url, "--out", str(tmp_path / "a.png")]) == 0
    assert "heading lost" in capsys.readouterr().out and (tmp_path / "a.png").is_file()
