"""Crossings while own ship rolls and pitches: closed forms in the frame of its deck, and the peak of the engine's beam."""

import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.optimize import brentq

import radar_service as rs
from radar_service.engine.pipeline import Engine
from radar_service.engine.preparation import prepare
from radar_service.numerics.frames import wrap_angle
from radar_service.records.fidelity import PRESETS
from tests.scenes import point, scene

KNOT, TURN = 1852.0 / 3600.0, 2.0 * math.pi
PERIOD, AZIMUTHS = 2.5, 3600
RADAR = {"azimuths": AZIMUTHS, "beamwidth_deg": 1.2, "range_max_m": 6000, "rpm": 24}
COURSE, SPEED = math.radians(30.0), 9.0 * KNOT
OWN_SHIP = {
    "course_deg": 30, "speed_kn": 9, "roll_deg": 12, "roll_period_s": 9, "pitch_deg": 5, "pitch_period_s": 7,
    "yaw_deg": 2, "yaw_period_s": 11, "heave_m": 1, "heave_period_s": 8,
}  # fmt: skip
LATE = 8640  # scans: six hours
DRAWN = [(120, 75, 2), (300, 200, 150), (2000, 75, 5), (2000, 165, 300), (5000, 100, 40), (700, 350, 0)]

Vector = NDArray[np.float64]


def own_position(time: float) -> Vector:
    return time * SPEED * np.array([math.sin(COURSE), math.cos(COURSE)])


def placed(scan: int, distance: float, bearing: float, height: float) -> dict[str, Any]:
    """A point by distance and bearing [degrees] from where own ship is in the middle of a scan."""
    angle = math.radians(bearing)
    east, north = own_position((scan + 0.5) * PERIOD) + distance * np.array([math.sin(angle), math.cos(angle)])
    return point(f"{distance}, {bearing}", east, north, height)


def observed(time: float, body: dict[str, Any], own: dict[str, Any]) -> float:
    """The azimuth [rad] at which a mast sees a point: that in the frame of the deck, on whose upright axis the mast stands.

    Rolled with the starboard side down, then pitched with the bow up, one rotation after the other.
    """

    def angle(name: str) -> float:
        phase = math.radians(own.get(f"{name}_phase_deg", 0.0))
        return math.radians(own.get(f"{name}_deg", 0.0)) * math.sin(TURN * time / own.get(f"{name}_period_s", 10.0) + phase)

    heading, pitch, roll = COURSE + angle("yaw"), angle("pitch"), angle("roll")
    heave = own.get("heave_m", 0.0) * math.sin(TURN * time / own.get("heave_period_s", 8.0))
    east, north = np.array(body["position_m"][:2]) - own_position(time)
    up = body["position_m"][2] - heave - (east**2 + north**2) / (2.0 * 4.0 / 3.0 * 6_371_000.0)
    right, ahead = east * math.cos(heading) - north * math.sin(heading), east * math.sin(heading) + north * math.cos(heading)
    ahead, up = ahead * math.cos(pitch) + up * math.sin(pitch), up * math.cos(pitch) - ahead * math.sin(pitch)
    right = right * math.cos(roll) - up * math.sin(roll)
    return heading + math.atan2(right, ahead)


def slow_crossings(scan: int, body: dict[str, Any], own: dict[str, Any], period: float = PERIOD) -> list[float]:
    """By changes of sign over small steps, each refined by Brent's method."""

    def ahead(time: float) -> float:
        return float(wrap_angle(np.asarray(TURN * time / period - observed(time, body, own))))

    times = (scan + np.linspace(0.0, 1.0, 20_001)) * period
    values = np.array([ahead(time) for time in times.tolist()])
    changes = np.flatnonzero((values[:-1] * values[1:] < 0.0) & (np.abs(values[:-1]) < 1.0))
    return [brentq(ahead, times[k], times[k + 1], xtol=1e-13) for k in changes.tolist()]


@pytest.mark.parametrize("scan", [0, 3, LATE])
def test_a_crossing_is_that_of_the_boresight_that_rolls_and_pitches_with_own_ship(scan: int) -> None:
    """Tolerance: the radius of the earth, to 0.02 %, by which drops differ by 0.3 mm at 5 km, and 1e-9 rad of rounding."""
    bodies = [placed(scan, *drawn) for drawn in DRAWN]
    crossings = rs.Simulator(scene(bodies, radar=RADAR, own_ship=OWN_SHIP), "fast").crossings(scan)
    found = {crossing.body: crossing for crossing in crossings}
    for body in bodies:
        crossing = found[body["name"]]
        expected = observed(crossing.time, body, OWN_SHIP)
        assert wrap_angle(np.asarray(crossing.boresight - expected)) == pytest.approx(0.0, abs=1e-7)
        assert wrap_angle(np.asarray(crossing.boresight - TURN * crossing.time / PERIOD)) == pytest.approx(0.0, abs=1e-9)
        assert crossing.spoke == round(crossing.time / PERIOD * AZIMUTHS)
    aside = [abs(float(wrap_angle(np.asarray(one.boresight - one.bearing)))) for one in crossings]
    assert max(aside) > math.radians(0.5)  # the level boresight is far off


@pytest.mark.sample(2)
@pytest.mark.parametrize("height_m", [12, 60])
@pytest.mark.parametrize("scan", [1, LATE])
def test_the_beam_of_the_engine_has_its_peak_at_the_crossing(scan: int, height_m: float) -> None:
    """A parabola through the three strongest of spokes a twelfth of the beam apart. The elevation gain changes over the dwell by
    0.3 % a spoke at most, which moves the peak by 0.03 spokes of 0.1 degrees; the level boresight is up to 10 spokes off."""
    for drawn in DRAWN[:5:2]:
        made = scene([placed(scan, *drawn)], radar=RADAR | {"height_m": height_m}, own_ship=OWN_SHIP)
        (crossing,) = rs.Simulator(made, "fast").crossings(scan)
        near = crossing.spoke - scan * AZIMUTHS + np.arange(-5, 6)
        requested = np.isin(np.arange(AZIMUTHS), near)
        tiles = Engine(prepare(made, PRESETS["reference"], 0)).tiles(scan, requested)
        power = {start + k: float(row.max()) for start, _, rows in tiles for k, row in enumerate(rows)}
        peak = max(power, key=lambda spoke: power[spoke])
        before, at, after = np.log([power[peak - 1], power[peak], power[peak + 1]])
        place = peak + 0.5 * (before - after) / (before - 2.0 * at + after)
        assert place == pytest.approx(crossing.time / PERIOD * AZIMUTHS - scan * AZIMUTHS, abs=0.05)


@pytest.mark.parametrize(("sector", "blind"), [([44.3, 60.0], False), ([30.0, 44.3], True)])
def test_a_blind_sector_is_that_of_the_tilted_boresight(sector: list[float], blind: bool) -> None:
    """Rolled by 20 degrees a point at 45 degrees from the bow appears at 43.2: truth and engine agree on which side it is."""
    own = {"heading_deg": 0, "roll_deg": 20, "roll_period_s": 3600, "roll_phase_deg": 90}
    radar = RADAR | {"blind_sectors_deg": [sector], "beamwidth_deg": 0.5, "beamwidth_el_deg": 60}
    made = scene([point("p", 1000.0, 1000.0, 0.0)], radar=radar, own_ship=own)
    (crossing,) = rs.Simulator(made, "fast").crossings(0)
    assert crossing.reason == ("blind sector" if blind else "")
    requested = np.arange(AZIMUTHS) == crossing.spoke
    tiles = Engine(prepare(made, PRESETS["fast"], 0)).tiles(0, requested)
    power = {start + k: float(row.max()) for start, _, rows in tiles for k, row in enumerate(rows)}
    assert (power[crossing.spoke] == 0.0) == blind


@pytest.mark.sample(4)
@pytest.mark.parametrize("scan", [0, 5])
@pytest.mark.parametrize(("distance", "height"), [(0.3, 1), (9, 1), (40, 60), (150, 60), (12, 90), (3, 300)])
def test_steep_points_are_crossed_as_often_as_the_deck_turns_to_them(scan: int, distance: float, height: float) -> None:
    """Rolling by 20 degrees in 1 s: the azimuth of a bridge overhead swings faster than the beam turns, and meets it often."""
    own = {"course_deg": 30, "roll_deg": 20, "roll_period_s": 1, "pitch_deg": 8, "pitch_period_s": 1.7}
    body = placed(scan, distance, 140.0, height)
    sim = rs.Simulator(scene([body], radar=RADAR, own_ship=own | {"speed_kn": 9}), "fast")
    times = [crossing.time for crossing in sim.crossings(scan)]
    np.testing.assert_allclose(times, slow_crossings(scan, body, own), atol=1e-6, rtol=0)  # the earth's radius, see above


def test_a_slow_antenna_follows_a_roll_that_returns_at_each_step_of_a_coarse_search() -> None:
    """Eight rolls in a scan of 15 s: at eighths of the scan the deck always leans alike."""
    own = {"course_deg": 30, "roll_deg": 20, "roll_period_s": 15 / 8, "roll_phase_deg": 20}
    counts = []
    for east, north in ((80.0, 40.0), (160.0, -20.0), (-30.0, 110.0), (-120.0, -60.0)):
        body = point("p", east, north, 120.0)
        made = scene([body], radar=RADAR | {"rpm": 4}, own_ship=own | {"speed_kn": 9})
        times = [crossing.time for crossing in rs.Simulator(made, "fast").crossings(0)]
        np.testing.assert_allclose(times, slow_crossings(0, body, own, 15.0), atol=1e-6, rtol=0)
        counts.append(len(times))
    assert max(counts) > 1


def test_what_is_exactly_below_a_rolling_mast_has_crossings_of_its_scan() -> None:
    """Its azimuth in the deck's frame is rounding: any instants of the scan do, none fails."""
    made = scene([point("p", 0.0, 0.0, 0.0)], radar=RADAR, own_ship={"roll_deg": 12, "pitch_deg": 5})
    for scan in range(3):
        for crossing in rs.Simulator(made, "fast").crossings(scan):
            assert scan * PERIOD <= crossing.time < (scan + 1) * PERIOD and math.isfinite(crossing.boresight)
