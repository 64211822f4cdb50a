"""Whole scenes: the example of docs/scenes.md, shared files, units, several problems at once, arbitrary input."""

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from radar_service.numerics.constants import KNOT
from radar_service.scene_file.load import load_scene, model_from, scene_from_model
from radar_service.scene_file.model.scene import scene_model
from radar_service.world.error import SceneError
from tests.scene_file.scene_sources import EXAMPLE, point, problems


def test_the_example_of_the_design(folder: Path) -> None:
    scene = load_scene(folder / "scene.toml")
    assert (scene.name, scene.origin) == ("two targets", (50.9, 1.4))
    radar = scene.radar
    assert radar.range_step == pytest.approx(1.9986, abs=5e-5)  # docs/conventions.md#range
    assert radar.bins == math.ceil(5000 / (299_792_458 / 150e6)) == 2502
    assert (radar.gain, radar.loss, radar.rotation_period) == (1000.0, 1.0, 2.5)
    assert radar.beamwidth == pytest.approx(math.radians(3.9))
    assert radar.noise_factor == pytest.approx(2.5119, abs=5e-5)  # 4 dB
    assert scene.environment.earth_factor == pytest.approx(4 / 3)
    reflector, ferry, island = scene.bodies
    assert (reflector.mesh, reflector.scattering, reflector.rcs) == (None, "rcs", pytest.approx(10.0))
    np.testing.assert_array_equal(reflector.motion.position, [[500, 866, 4]])
    assert (ferry.scattering, ferry.mmsi, ferry.material.name, ferry.length, ferry.beam) == (
        "optics",
        235000001,
        "steel",
        1,
        1,
    )
    np.testing.assert_allclose(ferry.motion.pose(1.0).velocity, [[12 * KNOT, 0, 0]], atol=1e-12)
    assert island.scattering == "diffuse" and island.motion.at_rest
    assert [w.split(",")[0] for w in scene.warnings] == [
        "body[0]: reflector is under the ground of island",
        "body[1]: ferry is under the ground of island",
        "body[2]: the antenna is inside or under island",
    ]


def test_json_mapping_and_model_agree(folder: Path) -> None:
    import tomllib

    data = tomllib.loads(EXAMPLE)
    (folder / "scene.json").write_text(json.dumps(data))
    expected = repr(load_scene(folder / "scene.toml"))
    assert repr(load_scene(str(folder / "scene.json"))) == expected
    assert repr(load_scene(data, folder=folder)) == expected
    assert repr(scene_from_model(model_from(folder / "scene.toml"), folder)) == expected
    as_numpy = {**data, "body": [{**data["body"][0], "position_m": np.array([500.0, 866.0, 4.0])}]}
    assert load_scene(as_numpy).bodies[0].motion.position[0, 1] == np.float64(866)


def test_bodies_by_latitude_and_longitude() -> None:
    body = point(latitude_deg=50.9, longitude_deg=1.5, up_m=7)
    location = (
        load_scene({"origin": {"latitude_deg": 50.9, "longitude_deg": 1.4}, "body": [body]}).bodies[0].motion.position[0]
    )
    assert location[0] == pytest.approx(7034.85, abs=0.02)  # m: pi/1800 x N cos(latitude) on WGS 84, and its last digit
    assert location[2] == 7.0


def test_several_problems_come_together(folder: Path) -> None:
    bodies = [{"name": f"b{k}", "mesh": f"missing{k}.obj"} for k in range(25)]
    result = problems({"body": bodies}, folder=folder)
    assert len(result) == 21 and result[0].startswith("body[0].mesh") and result[20] == "... and 5 more problems"
    both = problems({"radar": {"rpm": 0}, "body": [point(swerling=9)]})
    assert [line.split(":")[0] for line in both] == ["radar.rpm", "body[0].swerling"]


def test_too_many_triangles_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("radar_service.scene_file.readers.file_format.InProcessReader.max_triangles", 700)
    bodies = [{"name": f"s{k}", "shape": "sphere", "radius_m": 0.1, "rcs_dbsm": 0} for k in range(3)]
    assert problems({"body": bodies})[0].startswith("body[2]: the body brings the scene to 960 triangles; at most 700")


SCALARS = (
    st.none()
    | st.booleans()
    | st.integers()
    | st.floats()
    | st.text(max_size=5)
    | st.sampled_from(["point", "sphere", "a.obj"])
)

KEYS = st.sampled_from(
    [*scene_model().model_fields, "rpm", "shape", "position_m", "waypoints", "pattern", "name", "track", "x"]
)

ARBITRARY = st.recursive(
    SCALARS,
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(KEYS | st.integers(), inner, max_size=5),
    max_leaves=12,
)


@settings(max_examples=80, deadline=None, derandomize=True, database=None, suppress_health_check=[HealthCheck.too_slow])
@given(st.dictionaries(KEYS, ARBITRARY, max_size=5))
def test_arbitrary_data_raises_only_scene_errors(source: dict[str, Any]) -> None:
    try:
        load_scene(source)
    except SceneError as fault:
        assert fault.problems and all(fault.problems)


def test_far_from_the_origin_a_warning_gives_the_distortion() -> None:
    """c / sin c - 1 at 1000 km: 0.1570 rad, 0.41 %; at 100 km nothing is message."""
    scene = {"origin": {"latitude_deg": 50, "longitude_deg": 0}, "own_ship": {"position_m": [1e6, 0]}}
    (warning,) = load_scene(scene).warnings
    assert warning.startswith("own_ship: at 1000 km from the origin") and "0.41%" in warning
    assert not load_scene(scene | {"own_ship": {"position_m": [1e5, 0]}}).warnings
