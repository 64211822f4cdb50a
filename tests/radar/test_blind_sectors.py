"""Blind sectors: one rule decides for the engine and for the feed."""

import math

import numpy as np
import pytest

import radar_service as rs
from radar_service.display.video import Controls
from radar_service.service.codecs.native import messages
from radar_service.service.feed_request import View
from radar_service.service.spokes import Epoch, SpokeBatch
from tests.scenes import radar

DEGREE = math.pi / 180


@pytest.mark.parametrize(
    ("sector", "inside", "outside"),
    [
        ([80, 100], [80, 90, 100], [79, 101, 270]),
        ([350, 10], [350, 0, 10, 360], [349, 11, 180]),
        ([-10, 10], [350, 0, 10], [349, 11, 180]),
        ([0, 360], [0, 90, 359], []),
        ([-180, 180], [0, 90, 180, 359], []),
        ([-360, 360], [0, 90, 180, 359], []),
        ([-299.9, 60.1], [0, 60.1, 180, 300], []),  # a full turn but for rounding in radians
    ],
)
def test_a_sector_runs_clockwise_and_holds_both_its_ends(
    sector: list[float], inside: list[float], outside: list[float]
) -> None:
    silent = radar(blind_sectors_deg=[sector]).is_blind(np.array(inside + outside) * DEGREE)
    assert silent.tolist() == [True] * len(inside) + [False] * len(outside)


@pytest.mark.parametrize(("sector", "count"), [([0, 360], 36), ([-180, 180], 36), ([0, 90], 10), ([350, 10], 3)])
def test_engine_and_feed_are_silent_at_the_same_azimuths(sector: list[float], count: int) -> None:
    """36 azimuths 10 degrees apart, own ship heading 070. Noise fills every spoke that is not silent."""
    settings = {
        "azimuths": 36, "beamwidth_deg": 12, "range_max_m": 300, "pulse_s": 1e-6, "blind_sectors_deg": [sector],
    }  # fmt: skip
    echo = {"name": "p", "shape": "sphere", "radius_m": 5, "position_m": [20, 0, 15], "rcs_dbsm": 40}
    scene = rs.load_scene({"radar": settings, "own_ship": {"heading_deg": 70}, "body": [echo]})
    engine = rs.Simulator(scene)
    scan = engine.scan()
    heading = scene.own_ship.pose(scan.time).heading
    silent = scene.blind(scan.time, scan.azimuth)
    marked: list[bool] = []
    epoch = Epoch("e", engine, None)
    for block in rs.Simulator(scene).blocks(scans=1):
        message = messages.spokes(SpokeBatch(epoch, block.first, block, Controls()), View("f32"))
        marked += message.get("blind", [False] * len(block))
    assert marked == silent.tolist()
    assert marked == scene.radar.is_blind(scan.azimuth - heading).tolist()
    assert sum(marked) == count == int(np.sum(np.abs(scan.field).max(axis=1) == 0.0))


def test_a_sector_without_width_is_refused() -> None:
    with pytest.raises(rs.SceneError) as fault:
        radar(blind_sectors_deg=[[0, 10], [90, 90]])
    message = str(fault.value)
    for part in ("radar.blind_sectors_deg[1]: [90, 90] is not allowed", "from -360 to 360", "remove the sector"):
        assert part in message
