"""The command `record`."""

import contextlib
from pathlib import Path

import pytest

import radar_service as rs
from radar_service.__main__ import main
from radar_service.commands.command_line import parser
from radar_service.recording import read


def test_a_scene_is_recorded_with_its_truth(one_target: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "a.mcap"
    assert (
        main(["record", str(one_target), "--scans", "2", "--seed", "3", "--fidelity", "fast", "--truth", "-o", str(path)])
        == 0
    )
    assert capsys.readouterr().out == f"{path}: 2 x 60 spokes of 301 cells\n"
    made = rs.Simulator(rs.load_scene(one_target), "fast", 3)
    assert [scan.field.tobytes() for scan in read(path).scans()] == [made.scan().field.tobytes() for _ in range(2)]
    assert len(list(read(path).crossings())) == 4  # a crossing and a snapshot a scan
    assert read(path).seed == 3 and read(path).record["document"]["body"][0]["name"] == "p"


def test_a_recording_without_truth_has_none(one_target: Path, tmp_path: Path) -> None:
    assert main(["record", str(one_target), "-o", str(tmp_path / "a.mcap")]) == 0
    assert not list(read(tmp_path / "a.mcap").crossings())


def test_labels_and_powers_are_recorded(one_target: Path, tmp_path: Path) -> None:
    options = ["--fidelity", "fast", "--labels", "--powers", "256", "-o", str(tmp_path / "a.mcap")]
    assert main(["record", str(one_target), *options]) == 0
    made = rs.Simulator(rs.load_scene(one_target), "fast", labels=True, powers=(256,))
    (ours,), its = read(tmp_path / "a.mcap").scans(), made.scan()
    assert ours.labels is not None and its.labels is not None and ours.labels.tobytes() == its.labels.tobytes()
    assert ours.powers is not None and its.powers is not None and ours.powers[256].tobytes() == its.powers[256].tobytes()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--powers", "7"], "--powers: 7 is no source of this scene; it has 0 noise"),
        (["--powers", "ship"], 'powers: "ship" is not all, nor 1 to 64 numbers'),
        (["--labels", "--fidelity", "documented"], "--labels: the fidelity documented has none"),
        (["--powers", "all", "--fidelity", "documented"], "--powers: the fidelity documented has none"),
    ],
)
@pytest.mark.parametrize(("command", "name"), [("record", "a.mcap"), ("scan", "a.npz")])
def test_sources_that_are_not_there_are_refused_and_no_file_made(
    command: str, name: str, arguments: list[str], words: str, one_target: Path, tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:  # fmt: skip
    with contextlib.suppress(SystemExit):  # of the parser
        assert main([command, str(one_target), *arguments, "-o", str(tmp_path / name)]) == 2
    assert words in capsys.readouterr().err and not (tmp_path / name).exists()


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs /dev/full")
def test_a_full_disk_is_a_clear_error(one_target: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (path := tmp_path / "full.mcap").symlink_to("/dev/full")
    assert main(["record", str(one_target), "-o", str(path), "--overwrite"]) == 2
    assert capsys.readouterr().err.splitlines()[-1] == f"{path}: No space left on device"


def test_what_it_takes() -> None:
    options = ["record", "harbour", "-o", "a.mcap", "--scans", "7", "--seed", "2", "--threads", "2"]
    record = parser("record").parse_args(options)
    assert (record.scene, record.out, record.scans, record.seed, record.truth) == ("harbour", Path("a.mcap"), 7, 2, False)
    assert parser("serve").parse_args(["serve", "--record", "a.mcap"]).record == Path("a.mcap")
