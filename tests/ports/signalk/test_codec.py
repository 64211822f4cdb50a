"""Spokes of the Signal K Radar API: angles, range, levels and positions against what was sent."""

import math
from dataclasses import replace
from datetime import UTC, datetime

import numpy as np
import pytest

from radar_service.display.video import Controls, display_video
from radar_service.ports.signalk.codec import LEVELS, MAX_SAMPLES, RadarShape, SignalKCodec
from radar_service.scene_file.load import load_scene
from radar_service.service.spokes import Epoch, SpokeBatch
from tests.ports.signalk.protobuf import spokes
from tests.reference.true_north import true_deg
from tests.service.fake import AZIMUTHS, BINS, RADAR, STEP, FakeEngine, scene

CODEC = SignalKCodec()
VIEW = CODEC.request({}, True).view
START = datetime(2026, 12, 31, 23, 59, 59, tzinfo=UTC)
GAIN = Controls(gain=60.0, gain_auto=False)


def batch(engine: FakeEngine, first: int, count: int, display_range: float | None = None, **changes: object) -> SpokeBatch:
    block = replace(engine.block(first, count), **changes)  # type: ignore[arg-type]
    return SpokeBatch(Epoch("e", engine, display_range, start_utc=START), first, block, GAIN)


def test_each_bearing_and_each_angle_is_there_once_in_a_revolution() -> None:
    """Own ship heads 030: of 24 spokes the bow is number 2."""
    sent = [
        each
        for first in range(0, AZIMUTHS, 5)
        for each in spokes(CODEC.spokes(batch(FakeEngine(scene()), first, min(5, 24 - first)), VIEW))
    ]
    bearings = [each.get("bearing", 0) for each in sent]
    assert bearings == list(range(AZIMUTHS))
    assert [(each.get("angle", 0) + 2) % AZIMUTHS for each in sent] == bearings


def test_each_angle_comes_once_at_a_heading_between_two_spokes() -> None:
    """Heading 38.1 degrees is 2.54 of 24 spokes; rounded apart from the bearing, angles come twice or not at all."""
    heading = np.full(AZIMUTHS, math.radians(38.1))
    drawn = np.arange(AZIMUTHS) * (2.0 * math.pi / AZIMUTHS) + np.tile([0.0, 0.02], AZIMUTHS // 2)  # azimuths are not exact
    engine = FakeEngine(scene())
    angles = [
        spokes(CODEC.spokes(batch(engine, k, 1, heading=heading[k : k + 1], azimuth=drawn[k : k + 1]), VIEW))[0].get(
            "angle", 0
        )
        for k in range(AZIMUTHS)
    ]
    assert sorted(angles) == list(range(AZIMUTHS))


def test_bearings_count_from_true_north_at_own_ship() -> None:
    """At 60 N 600 km to the east of the origin it is 9.3 degrees off the map's: 0.6 of 24 spokes, so one. Angles stay."""
    engine = FakeEngine(load_scene({"radar": RADAR, "origin": {"latitude_deg": 60.0, "longitude_deg": 5.0}}))
    east = np.tile([600e3, 0.0], (5, 1))
    assert true_deg(0.0, east[0].tolist(), (60.0, 5.0)) == pytest.approx(9.3, abs=0.1)
    sent, far = (spokes(CODEC.spokes(batch(engine, 0, 5, **more), VIEW)) for more in ({}, {"position": east}))
    assert [each.get("angle", 0) for each in far] == [each.get("angle", 0) for each in sent]
    assert [(b.get("bearing", 0) - a.get("bearing", 0)) % AZIMUTHS for a, b in zip(sent, far, strict=True)] == [1] * 5


def test_a_spoke_without_heading_has_the_angle_from_the_bow_and_no_bearing() -> None:
    lost = batch(FakeEngine(scene()), 3, 2, heading=np.array([np.nan, 0.0]))
    first, second = spokes(CODEC.spokes(lost, VIEW))
    assert "bearing" not in first and first["angle"] == 3
    assert second["bearing"] == second["angle"] == 4


@pytest.mark.parametrize(("display_range", "far_edge", "samples"), [(None, 200, 20), (95.0, 100, 10), (10.0, 10, 1)])
def test_range_is_the_far_edge_of_the_last_sample(display_range: float | None, far_edge: int, samples: int) -> None:
    (spoke,) = spokes(CODEC.spokes(batch(FakeEngine(scene()), 5, 1, display_range), VIEW))
    assert spoke["range"] == far_edge == samples * STEP and len(spoke["data"]) == samples


def test_samples_are_the_video_up_to_the_highest_level() -> None:
    """The fake's cells are far above noise: with a noise of 1e-15 W the display shows 255, of which the API's legend has 251."""
    sent = batch(FakeEngine(scene()), 7, 2)
    to = sent.epoch.layout(MAX_SAMPLES)
    video = display_video(sent.block.power, to, GAIN, 1e-15)
    rows = [np.frombuffer(each["data"], np.uint8) for each in spokes(CODEC.spokes(sent, VIEW))]
    np.testing.assert_array_equal(rows, np.minimum(video, LEVELS - 1))
    assert video.max() == 255


def test_levels_between_are_not_changed() -> None:
    engine = FakeEngine(scene())
    weak = engine.block(7, 1)
    sent = batch(engine, 7, 1, power=(weak.power / weak.power.max() * 1e-11).astype(np.float32))
    video = display_video(sent.block.power, sent.epoch.layout(MAX_SAMPLES), GAIN, 1e-15)
    assert 0 < video.max() < LEVELS
    (spoke,) = spokes(CODEC.spokes(sent, VIEW))
    assert spoke["data"] == video[0].tobytes()


def test_positions_are_those_of_own_ship_as_reported() -> None:
    """On the equator a degree of longitude is 111 319.49 m (WGS 84, a = 6 378 137 m)."""
    of = load_scene({"radar": RADAR, "origin": {"latitude_deg": 0.0, "longitude_deg": 10.0}})
    degree = math.radians(6_378_137.0)
    (spoke,) = spokes(CODEC.spokes(batch(FakeEngine(of), 0, 1, position=np.array([[degree / 2, 0.0]])), VIEW))
    assert spoke["lon"] == pytest.approx(10.5, abs=1e-9) and spoke.get("lat", 0.0) == pytest.approx(0.0, abs=1e-9)
    (spoke,) = spokes(CODEC.spokes(batch(FakeEngine(scene()), 0, 1), VIEW))
    assert "lat" not in spoke and "lon" not in spoke


def test_times_are_those_of_utc_over_the_end_of_a_year() -> None:
    sent = spokes(CODEC.spokes(batch(FakeEngine(scene()), 0, 2, time=np.array([0.2504, 1.5])), VIEW))
    assert [each["time"] for each in sent] == [1_798_761_599_250, 1_798_761_600_500]  # 2027 begins at 1 798 761 600


def test_the_shape_of_a_radar_is_what_clients_read_once() -> None:
    info = FakeEngine(scene()).info
    assert RadarShape.of(info) == (AZIMUTHS, BINS, 200)
    assert RadarShape.of(replace(info, range=np.arange(21.0))).samples == 24  # a multiple of 4, as textures need it
    assert RadarShape.of(replace(info, range=np.arange(5000.0))).samples == MAX_SAMPLES


def test_a_client_of_another_shape_gets_no_spokes() -> None:
    engine = FakeEngine(scene())
    request = RadarShape.of(engine.info).request
    assert CODEC.spokes(batch(engine, 0, 2), request.view)
    other = RadarShape(48, 20, 200).request
    assert CODEC.spokes(batch(engine, 0, 2), other.view) == b""
