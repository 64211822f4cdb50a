"""Own ship's structures from end to end: a scan with a mast against one without, under way, turning, over a sea, late."""

from typing import Any

import numpy as np
import pytest

import radar_service as rs
from radar_service.stages.interference.stage import Interference
from radar_service.stages.registry import changed_pattern
from radar_service.stages.structures.reflection import structure_reflectors
from radar_service.stages.structures.structure import Structure
from tests.reference.cylinder_shadow import elements, past_strip, received
from tests.scenes import point, scene

RADAR: dict[str, Any] = {
    "azimuths": 512, "beamwidth_deg": 2.0, "range_max_m": 1200, "rpm": 30, "pulse_s": 2e-7, "bandwidth_hz": 30e6,
    "pattern": "cosine2",
}  # fmt: skip
FUNNEL = {"name": "funnel", "bearing_deg": 170, "distance_m": 6.0, "width_m": 0.8}
SEA = {"noise": True, "multipath": True, "sea_state": 3}
ABEAM = FUNNEL | {"bearing_deg": 88}
TURNING = {"course_deg": 20, "speed_kn": 14, "turn_rate_deg_s": 2.0}
SHIP = {"course_deg": 300, "speed_kn": 22}


def simulator(structure: list[dict[str, Any]], bodies: list[dict[str, Any]], **sections: Any) -> rs.Simulator:
    made = scene(bodies, radar=RADAR | {"structure": structure}, **sections)
    return rs.Simulator(made, "balanced", seed=3, labels=True)


def two_way(sim: rs.Simulator, from_bow: float, offset: float) -> complex:
    """The two-way field past the funnel by elements one by one, over that on boresight without it."""
    radar = sim.scene.radar
    (structure,) = radar.effects["structures"]
    assert isinstance(structure, Structure)
    length = (
        2.0 * 0.720277 * radar.wavelength / radar.beamwidth
    )  # of a cosine-squared aperture: 1.4406 lambda / a (Harris 1978)
    points, along = elements(length, 48, from_bow - offset)
    field = past_strip(from_bow, structure.bearing, structure.distance, structure.radius, points, radar.wavelength)
    return received(field, along, length, {0.0: 1.0, 1.0: 1.0}) ** 2


def test_a_ship_passes_behind_the_funnel_late_in_a_turn() -> None:
    """A target under way, as own ship turns, in the 40th scan: its echoes are those without a funnel times elements summed
    behind it, -45 dB of the strongest (beam extent and tables). At some azimuths of the run it is in full shadow."""
    target, lost = [point("t", 250.0, -420.0, rcs_dbsm=20.0, **SHIP)], []
    settings: dict[str, Any] = {"own_ship": TURNING, "environment": {"noise": False}}
    with_funnel, without = (simulator(each, target, **settings) for each in ([ABEAM], []))
    for sim in (with_funnel, without):
        sim.skip_to(40)
    for _ in range(3):
        shadowed, plain = with_funnel.scan(), without.scan()
        (crossing,) = with_funnel.crossings(shadowed.number)
        row = np.arange(crossing.spoke - 3, crossing.spoke + 4) % 512
        column = np.abs(plain.field[row[3]]).argmax()
        expected, gains = [], []
        for n in range(-3, 4):
            offset = -n * with_funnel.scene.radar.azimuth_step + (
                crossing.boresight - crossing.spoke % 512 * 2 * np.pi / 512
            )
            expected.append(two_way(with_funnel, crossing.relative_bearing, offset))
            gains.append(float(with_funnel.scene.radar.azimuth_gain(np.array([offset]))[0]))
        ratio = shadowed.field[row, column] / plain.field[row, column]
        error = np.abs(ratio * np.array(gains) - np.array(expected)).max()
        assert 20.0 * np.log10(error) < -40.0
        lost.append(20.0 * np.log10(abs(two_way(with_funnel, crossing.relative_bearing, 0.0))))
        assert crossing.structure_db == pytest.approx(-lost[-1], abs=0.2)  # a deep shadow is -20 dB of -54
    assert min(lost) < -6.0


def test_at_rest_it_is_the_same() -> None:
    """Own ship and a point at rest, 3 degrees off the funnel's middle: all azimuths of the beam, -40 dB of the strongest."""
    bearing = np.radians(173.0)
    target = [point("t", 400.0 * np.sin(bearing), 400.0 * np.cos(bearing), rcs_dbsm=20.0)]
    with_funnel, without = (simulator(each, target, environment={"noise": False}) for each in ([FUNNEL], []))
    shadowed, plain = with_funnel.scan(), without.scan()
    row = round(bearing / (2.0 * np.pi) * 512) + np.arange(-3, 4)
    column = np.abs(plain.field[row[3]]).argmax()
    offset = bearing - row * 2.0 * np.pi / 512
    expected = np.array([two_way(with_funnel, bearing, float(each)) for each in offset])
    ratio = shadowed.field[row, column] / plain.field[row, column] * with_funnel.scene.radar.azimuth_gain(offset)
    assert np.abs(ratio - expected).max() < 10.0 ** (-40.0 / 20.0)
    assert np.abs(expected).max() < 0.5


def ghost_of(sim: rs.Simulator, number: int) -> tuple[float, complex]:
    """Range [m] of the indirect echo by the funnel of the only body at an azimuth from the start, and its two-way field over that
    of the direct one on boresight at that instant."""
    made, radar = sim.scene, sim.scene.radar
    boresight, time = (float(each[0]) for each in radar.schedule(np.array([number])))
    offset = made.bodies[0].motion.pose(np.array([time])).position[0] - made.antenna(time)[0]
    heading = float(made.platform.heading(np.array([time]))[0])
    (reflector,) = structure_reflectors(radar)
    from_bow = np.array([[np.arctan2(offset[0], offset[1]) - heading]])
    field, ray = reflector.field(from_bow, np.array([boresight - heading]))
    return float(np.hypot(*offset[:2]) + ray.detour[0, 0]), complex(field[0, 0] ** 2)


def test_a_false_echo_stands_in_the_bearing_of_the_funnel_late_in_a_turn() -> None:
    """Own ship turns, the target is under way, in the 30th scan: range by the detour, level over the direct echo."""
    target = [point("t", 350.0, 420.0, 15.0, rcs_dbsm=60.0, course_deg=300, speed_kn=12)]
    sim = simulator([FUNNEL | {"bearing_deg": 60}], target, own_ship=TURNING, environment={"noise": False, "earth": "flat"})
    plain = simulator([], target, own_ship=TURNING, environment={"noise": False, "earth": "flat"})
    for each in (sim, plain):
        each.skip_to(30)
    scan, direct = sim.scan(), plain.scan()
    assert scan.labels is not None and sim.label_names[7] == "indirect"
    rows = np.flatnonzero((scan.labels == 7).any(axis=1))
    (crossing,) = plain.crossings(30)
    one = np.abs(direct.field[crossing.spoke % 512]).max() * crossing.range**2  # an echo falls as R^-2
    step, compared = sim.scene.radar.range_step, 0
    for row in rows:
        distance, field = ghost_of(sim, 30 * 512 + int(row))
        if abs(field) < 10.0 ** (-75.0 / 20.0):
            continue
        profile = np.abs(scan.field[row])
        near = round(distance / step - 0.5)
        peak = near - 4 + int(profile[near - 4 : near + 5].argmax())
        side = profile[peak - 1 : peak + 2]
        centre = peak + 0.5 + 0.5 * (side[2] - side[0]) / (2.0 * side[1] - side[0] - side[2])  # parabola
        assert centre * step == pytest.approx(distance, abs=0.25 * step)
        height = side[1] + (side[2] - side[0]) ** 2 / (8.0 * (2.0 * side[1] - side[0] - side[2]))
        level_db = 20.0 * np.log10(height * (distance - 10.0) ** 2 / one)
        assert level_db == pytest.approx(20.0 * np.log10(abs(field)), abs=0.6)  # 0.3 of R, 0.3 of the parabolas
        compared += 1
    assert compared > 8


def test_sea_and_rain_are_weaker_behind_it() -> None:
    """In the middle of the shadow clutter has the share of power that it lets pass; the receiver's noise stays."""
    environment = {"noise": True, "sea_state": 5, "rain_mm_h": 5.0}
    with_funnel, without = (
        simulator(each, [], own_ship={"heading_deg": 90}, environment=environment) for each in ([FUNNEL], [])
    )
    shadowed, plain = with_funnel.scan(), without.scan()
    behind, away = round((170 + 90) / 360 * 512), 100
    near = slice(20, 60)
    power = [
        np.mean(np.abs(each.field[row - 2 : row + 3, near]) ** 2) for each in (shadowed, plain) for row in (behind, away)
    ]
    assert power[1] == pytest.approx(power[3], rel=0.02)
    assert 10.0 * np.log10(power[0] / power[2]) < -15.0
    assert np.isin(shadowed.labels[away, near], (1, 2)).mean() > 0.9


def test_pulses_of_other_radars_pass_a_structure_one_way() -> None:
    """Behind the middle of the funnel each pulse has the one-way field that it lets pass; opposite to it nothing changes."""
    ratios = []
    for bearing in (173.0, 10.0):
        other = [{"bearing_deg": bearing, "prf_hz": 9000.0, "rpm": 24, "level_db": 90, "beamwidth_deg": 60}]
        with_funnel, without = (simulator(each, [], interference=other).scene for each in ([FUNNEL], []))
        boresight, time = np.full(2000, np.radians(bearing)), np.arange(2000) * 0.00131
        behind, plain = (Interference(each, 0, 3).arrivals(boresight, time) for each in (with_funnel, without))
        kept = np.isin(plain.delay, behind.delay)
        assert len(behind.delay) > 20
        ratios.append(np.abs(behind.amplitude / plain.amplitude[kept]))
        shadow = changed_pattern(with_funnel.radar)
        assert shadow is not None
        expected = abs(shadow.one_way(np.radians([bearing]), np.zeros(1))[0])
        np.testing.assert_allclose(ratios[-1], expected, rtol=1e-6)
    assert ratios[0].max() < 0.5 and ratios[1].min() > 0.99


def test_the_noise_of_the_receiver_stays() -> None:
    with_funnel, without = (simulator(each, [], environment={"noise": True}).scan() for each in ([FUNNEL], []))
    np.testing.assert_array_equal(with_funnel.field, without.field)


def test_bytes_do_not_depend_on_threads_or_the_start() -> None:
    metal = {"name": "box", "shape": "box", "length_m": 8, "width_m": 3, "height_m": 3, "scattering": "optics",
             "position_m": [200, 150, 0], "course_deg": 90, "speed_kn": 16, "turn_rate_deg_s": 3}  # fmt: skip
    bodies = [point("t", 250.0, -420.0, swerling=1), point("u", 100.0, 300.0, roll_deg=8, roll_period_s=4.0), metal]
    settings: dict[str, Any] = {"own_ship": TURNING, "environment": {"noise": True, "multipath": True, "sea_state": 3}}
    through = simulator([FUNNEL], bodies, **settings)
    third = [through.scan() for _ in range(3)][2]
    later = rs.Simulator(through.scene, "balanced", seed=3, threads=2)
    later.skip_to(2)
    np.testing.assert_array_equal(third.field, later.scan().field)


def test_a_ship_that_passes_takes_resting_echoes_away_behind_the_funnel_too() -> None:
    """A point at rest in the shadow of the funnel, and a ship that comes to hide it: then nothing is left of it, as without."""
    bearing = np.radians(173.0)
    target = point("t", 400.0 * np.sin(bearing), 400.0 * np.cos(bearing), 5.0, rcs_dbsm=20.0)
    ship = {"name": "ship", "shape": "box", "length_m": 60, "width_m": 10, "height_m": 30, "rcs_dbsm": -60.0,
            "position_m": [-300, -200, 0], "course_deg": 90, "speed_kn": 60}  # fmt: skip
    sim = simulator([FUNNEL], [target, ship], environment={"noise": False})
    row, column = round(bearing / (2.0 * np.pi) * 512), round(400.0 / sim.scene.radar.range_step - 0.5)
    peaks = [float(np.abs(sim.scan().field[row - 2 : row + 3, column - 3 : column + 4]).max()) for _ in range(8)]
    assert max(peaks) < 1.01 * peaks[0] and min(peaks) < 1e-3 * peaks[0]
