"""The command `scan`: the files that it writes, and what it refuses."""

import json
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import radar_service as rs
from radar_service.__main__ import main
from radar_service.records.truth import Radiometry
from tests.scenes import TWO_RADARS


def test_scan_writes_what_the_simulator_gives(one_target: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out, png = tmp_path / "scans.npz", tmp_path / "last.png"
    assert main(["scan", str(one_target), "-o", str(out), "--scans", "2", "--png", str(png), "--seed", "3"]) == 0
    printed = capsys.readouterr()
    assert "2 x 60 spokes" in printed.out and printed.err == ""  # no bar where there is no terminal
    simulator = rs.Simulator(rs.load_scene(one_target), seed=3)
    scans = [simulator.scan(), simulator.scan()]
    with np.load(out) as file:
        for key in ("azimuth", "time", "heading", "position", "field", "power"):
            expected = scans[0].azimuth if key == "azimuth" else np.stack([getattr(scan, key) for scan in scans])
            np.testing.assert_array_equal(file[key], expected)
        np.testing.assert_array_equal(file["range"], scans[0].range)
        np.testing.assert_array_equal(file["number"], [0, 1])
        np.testing.assert_array_equal(file["spoke"], np.arange(120).reshape(2, 60))
        assert (str(file["name"]), int(file["seed"]), str(file["fidelity"])) == ("one target", 3, "auto")
    picture = np.asarray(Image.open(png).convert("L")).astype(int)
    north = picture[100:420, 440:461]  # where a target at half range ahead shows
    south = picture[480:800, 440:461]
    assert north.sum() > south.sum()


def test_labels_are_written_with_their_names_and_read_again(one_target: Path, tmp_path: Path) -> None:
    out = tmp_path / "scans.npz"
    assert main(["scan", str(one_target), "-o", str(out), "--scans", "2", "--labels"]) == 0
    simulator = rs.Simulator(rs.load_scene(one_target), labels=True)
    first, second = simulator.scan(), simulator.scan()
    with np.load(out) as file:
        np.testing.assert_array_equal(file["labels"], np.stack([first.labels, second.labels]))
        assert file["labels"].dtype == np.uint32
        names = dict(zip(file["label_numbers"].tolist(), file["label_names"].tolist(), strict=True))
    assert names == simulator.label_names and names[256] == "p"
    np.testing.assert_array_equal(rs.load_scan(out, 1).labels, second.labels)
    assert main(["scan", str(one_target), "-o", str(out), "--overwrite"]) == 0
    with np.load(out) as file:
        assert not [name for name in file if name.startswith("label")]
    assert rs.load_scan(out).labels is None


@pytest.mark.parametrize(("text", "numbers"), [("all", [0, 256]), ("256", [256])])
def test_powers_are_written_and_read_again(text: str, numbers: list[int], one_target: Path, tmp_path: Path) -> None:
    one_target.write_text(json.dumps(json.loads(one_target.read_text()) | {"environment": {"noise": True}}))
    out = tmp_path / "scans.npz"
    assert main(["scan", str(one_target), "-o", str(out), "--scans", "2", "--powers", text]) == 0
    simulator = rs.Simulator(rs.load_scene(one_target), powers="all")
    _, second = simulator.scan(), simulator.scan()
    with np.load(out) as file:
        assert file["power_sources"].tolist() == numbers and file["powers"].shape == (2, len(numbers), *second.power.shape)
        assert file["label_names"][file["label_numbers"] == 256].tolist() == ["p"]
    read = rs.load_scan(out, 1)
    assert read.labels is None and second.powers is not None and read.powers is not None
    assert list(read.powers) == numbers and second.powers[256].any()
    for number, power in read.powers.items():
        np.testing.assert_array_equal(power, second.powers[number])


def test_radiometric_truth_is_written_where_it_is_asked_for(one_target: Path, tmp_path: Path) -> None:
    lines = {}
    for asked in ([], ["--radiometric"]):
        truth = tmp_path / "truth.jsonl"
        assert (
            main(["scan", str(one_target), "-o", str(tmp_path / "s.npz"), "--truth", str(truth), "--overwrite", *asked]) == 0
        )
        lines[bool(asked)] = [json.loads(line) for line in truth.read_text().splitlines()]
    (plain,), (measured,) = ([line for line in lines[asked] if line["type"] == "crossing"] for asked in (False, True))
    (expected,) = rs.Simulator(rs.load_scene(one_target)).crossings(0, radiometric=True)
    assert measured == json.loads(json.dumps(expected.as_dict()))
    assert measured["rcs_dbsm"] == pytest.approx(10.0, abs=0.01) and len(measured["extent"]["range"]) == 2
    assert {name for name in measured if measured[name] != plain[name]} <= set(Radiometry.__dataclass_fields__)
    assert all(plain[name] is None for name in Radiometry.__dataclass_fields__)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--radiometric"], "add --truth"),
        (["--radiometric", "--truth", "t.jsonl", "--fidelity", "documented"], "documented has none"),
    ],
)
def test_radiometric_truth_that_cannot_be_is_refused(
    options: list[str], message: str, one_target: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "a.npz"
    assert main(["scan", str(one_target), "-o", str(out), *options]) == 2
    assert message in capsys.readouterr().err and not out.exists()


def test_an_option_names_one_of_several_radars(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path, out, truth = (tmp_path / name for name in ("two.json", "scans.npz", "truth.jsonl"))
    path.write_text(json.dumps(TWO_RADARS))
    assert main(["scan", str(path), "-o", str(out), "--truth", str(truth), "--radar", "pier"]) == 0
    expected = rs.Simulator(rs.load_scene(path), radar="pier").scan()
    with np.load(out) as file:
        np.testing.assert_array_equal(file["field"][0], expected.field)
    header, *crossings, snapshot = map(json.loads, truth.read_text().splitlines())
    assert [its["id"] for its in header["radars"]] == ["pier"] == [snapshot["radar"]]
    assert [(its["radar"], its["body"]) for its in crossings] == [("pier", "tug"), ("pier", "p")]
    assert main(["scan", str(path), "-o", str(tmp_path / "b.npz"), "--radar", "stern"]) == 2
    assert 'radar: "stern" is not a radar of this scene; it has bow, pier' in capsys.readouterr().err
