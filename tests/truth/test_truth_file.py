"""Truth files: each line is JSON with a type, and holds what the simulator says."""

import json
from pathlib import Path

import radar_service as rs
from radar_service.__main__ import main
from radar_service.truth.scene_hash import scene_hash
from radar_service.truth.truth_file import TruthFile, header
from tests.scenes import point, scene

SCENE = {
    "name": "two", "radar": {"azimuths": 60, "beamwidth_deg": 8, "range_max_m": 600, "rpm": 60, "pulse_s": 1e-6},
    "body": [point("a", 0, 300), point("b", 300, 0, course_deg=90, speed_kn=10, mmsi=235000001)],
}  # fmt: skip
KEYS = (
    "scan spoke time radar body mmsi range bearing relative_bearing elevation position latitude_deg longitude_deg velocity "
    "course speed heading turn_rate aspect cpa tcpa length beam visible reason own_ship"
).split()  # docs/feed.md has them too


def test_scan_writes_the_truth_of_each_crossing(tmp_path: Path) -> None:
    (path := tmp_path / "two.json").write_text(json.dumps(SCENE))
    out = tmp_path / "truth.jsonl"
    command = ["scan", str(path), "-o", str(tmp_path / "s.npz"), "--scans", "3", "--seed", "4", "--truth", str(out)]
    assert main(command) == 0
    first, *lines = (json.loads(line) for line in out.read_text().splitlines())
    sim = rs.Simulator(rs.load_scene(path), seed=4)
    assert first == sim.truth_header() == header(sim.scene, 4, "auto") and first["type"] == "header"
    expected = []
    for scan in range(3):
        expected += [crossing.as_dict() for crossing in sim.crossings(scan)]
        expected += [sim.snapshot(scan).as_dict()]
    assert lines == json.loads(json.dumps(expected))
    assert set(KEYS) < set(lines[0]) and lines[0]["latitude_deg"] is None and lines[0]["tcpa"] is None
    assert [line["type"] for line in lines] == 3 * ["crossing", "crossing", "snapshot"]


def test_the_header_names_scene_seed_and_radar() -> None:
    made = scene([point("a", 0, 300)])
    first = header(made, 7, "balanced")
    assert (first["schema"], first["scene"], first["seed"], first["fidelity"]) == (1, "test", 7, "balanced")
    assert first["scene_hash"] == scene_hash(made) and first["version"] == rs.__version__
    (radar,) = first["radars"]
    assert (radar["id"], radar["azimuths"], radar["range_first"]) == ("0", made.radar.azimuths, made.radar.range_step / 2)


def test_each_scan_is_on_disk_before_the_next_begins(tmp_path: Path) -> None:
    sim = rs.Simulator(scene([point("a", 0, 300)]), "fast")
    with TruthFile(path := tmp_path / "t.jsonl", {"schema": 1}) as file:
        file.write(sim.crossings(0), sim.snapshot(0))
        assert len(path.read_text().splitlines()) == 3
