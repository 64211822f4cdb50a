"""Truth files: each line is JSON with a type, and holds what the simulator says."""

import json
import tomllib
from pathlib import Path
from typing import Any

import pytest

import radar_service as rs
from radar_service.__main__ import main
from radar_service.truth.truth_file import header, scene_hash
from tests.limits import full_disk
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


def test_a_full_disk_leaves_no_half_truth(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (path := tmp_path / "two.json").write_text(json.dumps(SCENE))
    out, kept = tmp_path / "truth.jsonl", tmp_path / "s.npz"
    with full_disk(1000):
        assert main(["scan", str(path), "-o", str(kept), "--truth", str(out)]) == 2
    assert capsys.readouterr().err == f"{out}: File too large\n" and sorted(tmp_path.iterdir()) == [path]


BODY = point("a", 100, 200)
OPEN_SEA = "8066494bf7c7f60c1625144f92d2c18e428289e431e61ba893f421309563207c"  # by commit f2943c4, 2026-11-22
BOX = {
    "name": "b",
    "shape": "box",
    "length_m": 4,
    "width_m": 3,
    "height_m": 2,
    "position_m": [500, 0, 0],
    "material": "wood",
}


def hash_of(*bodies: dict[str, Any], **sections: Any) -> str:
    return scene_hash(scene(list(bodies or (BODY, BOX)), **sections))


def test_equal_scenes_have_equal_hashes() -> None:
    assert hash_of() == hash_of() == hash_of(errors={"gyro": {}}) and len(hash_of()) == 64
    assert scene_hash(rs.load_scene("open-sea")) == scene_hash(rs.load_scene("open-sea"))


@pytest.mark.parametrize(
    "other",
    [
        hash_of(BODY), hash_of(BOX, BODY), hash_of(BODY | {"name": "c"}, BOX), hash_of(BODY | {"rcs_dbsm": 10.1}, BOX),
        hash_of(BODY | {"mmsi": 235000001}, BOX), hash_of(BODY | {"course_deg": 5, "speed_kn": 1}, BOX),
        hash_of(BODY, BOX | {"length_m": 4.001}), hash_of(BODY, BOX | {"material": "steel"}),
        hash_of(radar={"azimuths": 1024}), hash_of(radar={"pattern": "taylor"}), hash_of(own_ship={"roll_deg": 1}),
        hash_of(errors={"gyro": {"bias_deg": 1}}),
        hash_of(environment={"sea_state": 3}), hash_of(origin={"latitude_deg": 50.0, "longitude_deg": 0.0}),
    ],
)  # fmt: skip
def test_any_change_changes_it(other: str) -> None:
    assert other != hash_of()


def test_what_it_does_not_know_is_an_error() -> None:
    made = scene([BODY]).with_world(environment=object())
    with pytest.raises(TypeError, match="object"):
        scene_hash(made)


def test_a_radar_of_a_scene_has_a_hash_of_its_own() -> None:
    """Radars with equal settings differ by their ids; the id "0" has the hash of a single [radar], a platform's body counts."""
    both = scene([BODY], radar=[{"id": "0"}, {"id": "aft"}])
    assert scene_hash(both) == scene_hash(scene([BODY])) != scene_hash(both.for_radar("aft"))
    assert scene_hash(scene([BODY], own_ship={"body": BODY["name"]})) != scene_hash(scene([BODY]))


def test_scenes_keep_their_hash_from_version_to_version() -> None:
    """Computed before scenes could have several radars, and when the ships had other numbers."""
    content = (Path(rs.__file__).parents[1] / "scenes" / "open-sea.toml").read_text()
    assert scene_hash(rs.load_scene(tomllib.loads(content.replace("mmsi = 2990", "mmsi = 9990")))) == OPEN_SEA
