"""Moving echoes against a loop over azimuths and bodies in float64, by own formulas."""

from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import radar_service as rs
from radar_service.echo.echoes import AzimuthTimes, BeamWeightedEchoes
from radar_service.echo.moving import FEW_ECHOES
from radar_service.echo.range_history import TOLERANCE
from radar_service.engine.preparation import Prepared, prepare
from radar_service.propagation.multipath import two_ray_factor
from radar_service.propagation.radar_equation import elevation_gain
from radar_service.records.fidelity import PRESETS
from tests.reference.compressed_pulse import sinc2_beam
from tests.scenes import point, scene
from tests.test_motion import SWAY, deck

Floats = NDArray[np.float64]
EARTH = 4 / 3 * 6_371_000.0
RADAR = {"range_max_m": 2500, "azimuths": 720, "beamwidth_deg": 4, "beamwidth_el_deg": 20}
ALL_ROUND = replace(PRESETS["balanced"], beam_extent=np.inf)
FIELD = 10 ** (-50 / 20)  # of an amplitude on boresight: moving points err by -55 dB (docs/engine.md#errors)


def ring(count: int = 9, nearest: float = 300.0, **motion: Any) -> list[dict[str, Any]]:
    """Points all round, each at a range of its own."""
    bodies = []
    for k in range(count):
        distance, azimuth = nearest + 220.0 * k, 2 * np.pi * k / count + 0.3
        bodies.append(point(f"p{k}", distance * np.sin(azimuth), distance * np.cos(azimuth), 3.0 + 2 * k, 10.0, **motion))
    return bodies


def block(made: rs.Scene, scan: int, index: int, count: int = 16) -> AzimuthTimes:
    """Consecutive azimuths of a scan."""
    number = scan * made.radar.azimuths + np.arange(index, index + count)
    return AzimuthTimes(number, *made.radar.schedule(number))


def block_at(made: rs.Scene, scan: int, b: int) -> AzimuthTimes:
    """The 16 azimuths of a scan about the bearing of a point when the beam is on it."""
    radar = made.radar
    time = (scan + 0.5) * radar.rotation_period
    for _ in range(4):
        turn = observed(made, b, time)[1] / (2 * np.pi) % 1.0
        time = (scan + turn) * radar.rotation_period
    return block(made, scan, int(np.clip(turn * radar.azimuths - 8, 0, radar.azimuths - 16)))


def observed(made: rs.Scene, b: int, time: float) -> tuple[Floats, float, float]:
    """Position (3,) of a point relative to the antenna with the earth's drop, and azimuth and elevation on a swaying mast."""
    own, height = made.own_ship.pose(time), made.radar.height
    to_map, heading = np.eye(3), 0.0
    if made.own_ship.sway is not None:
        matrices, headings = deck(np.array([time]), np.deg2rad(40))
        to_map, heading = matrices[0], float(headings[0])
    antenna = np.array([*own.position[0, :2], 0.0]) + height * to_map[:, 2]
    offset = made.bodies[b].motion.pose(time).position[0] - antenna
    offset[2] -= (offset[0] ** 2 + offset[1] ** 2) / (2 * EARTH)
    x, y, z = to_map.T @ offset
    return offset, float(np.arctan2(x, y) + heading), float(np.arctan2(z, np.hypot(x, y)))


def reference_echo(made: rs.Scene, b: int, azimuths: AzimuthTimes) -> tuple[Floats, NDArray[np.complex128], float]:
    """Ranges (K,) and amplitudes (K,) of a point by the radar equation, azimuth by azimuth, and the level on boresight."""
    radar, rcs = made.radar, made.bodies[b].rcs
    assert rcs is not None
    ranges, amplitudes = [], []
    constant = np.sqrt(radar.power * radar.gain**2 * radar.wavelength**2 * rcs / (4 * np.pi) ** 3)
    for boresight, time in zip(azimuths.boresight, azimuths.time, strict=True):
        offset, azimuth, elevation = observed(made, b, float(time))
        distance = float(np.sqrt(offset @ offset))
        one_way = sinc2_beam(np.array(boresight - azimuth), radar.beamwidth) * sinc2_beam(
            np.array(elevation), radar.beamwidth_el
        )
        phase = np.exp(-4j * np.pi * distance / radar.wavelength)
        ranges.append(distance)
        amplitudes.append(constant / distance**2 * one_way * phase)
    return np.array(ranges), np.array(amplitudes), float(constant / np.min(ranges) ** 2)


def assert_echoes(made: rs.Scene, echoes: BeamWeightedEchoes, azimuths: AzimuthTimes) -> None:
    """Each point is among the echoes with its range, change of range and amplitude, and there are no others."""
    assert len(echoes.range) == len(made.bodies)
    middle = len(azimuths.time) // 2
    for b in range(len(made.bodies)):
        ranges, amplitude, level = reference_echo(made, b, azimuths)
        e = int(np.argmin(np.abs(echoes.range - ranges.mean())))
        at_nodes = (azimuths.time[0] + azimuths.time[-1]) / 2
        assert echoes.range[e] == pytest.approx(
            np.linalg.norm(observed(made, b, float(at_nodes))[0]), abs=1e-6
        )  # m, float64
        migrated = echoes.range[e] + echoes.range_migration[e].astype(np.float64)
        # float32 of the change beside the parabola's tolerance
        assert np.abs(migrated - ranges).max() < 2 * TOLERANCE + 2.0**-23 * np.abs(ranges - ranges[middle]).max()
        assert np.abs(echoes.amplitude[e] - amplitude).max() < FIELD * level, made.bodies[b].name


def all_round(made: rs.Scene) -> Prepared:
    return prepare(made, ALL_ROUND, 3)


STRAIGHT = {"course_deg": 50, "speed_kn": 15}
SQUARE = [{"position_m": list(p), "speed_kn": 25} for p in [(700, 500), (700, 700), (500, 700)]]


WIDE_BEAM = {"beamwidth_deg": 20, "beamwidth_el_deg": 60}
LOOP = [{"position_m": [900 + 300 * k, 400], "speed_kn": 25} for k in (0, 1)]
CASES: dict[str, tuple[list[dict[str, Any]], dict[str, Any], dict[str, Any], list[tuple[int, int]], int]] = {
    "points under way": (ring(**STRAIGHT), {}, {}, [(0, n) for n in (0, 96, 352, 704)], 16),
    "single azimuths": (ring(**STRAIGHT), {}, {}, [(1, n) for n in (160, 165, 175)], 1),
    "own ship under way": (
        ring(), {}, {"course_deg": 200, "speed_kn": 12}, [(k, n) for k in (0, 3, 25) for n in (0, 304, 640)], 16,
    ),
    # in one block, from 400 times its way on (0.88 km)
    "a whole tile of few": (
        ring(nearest=900, **STRAIGHT), {"range_max_m": 5000}, {"course_deg": 200, "speed_kn": 25},
        [(2, n) for n in (0, 320, 672)], 32,
    ),
    # 2.5 million seconds: times are exact to 5e-10 s, so ranges to 6 nm; float32 of the time would be 0.25 s
    "after 29 days": ([point("t", 900, 700, waypoints=LOOP, loop=True)], {}, {}, [(1_000_000, n) for n in (96, 400)], 16),
    # 6 m off and 12 m below at 80 kn, where the parabola would err by centimetres and the elevation changes by degrees
    "close by": (
        [point("t", 6, -14, 3, course_deg=0, speed_kn=40)], WIDE_BEAM, {"course_deg": 180, "speed_kn": 40},
        [(0, n) for n in range(0, 320, 16)], 16,
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", CASES)
def test_points_have_their_range_phase_and_beam_weight(name: str) -> None:
    bodies, radar, own_ship, begins, count = CASES[name]
    made = scene(bodies, radar=RADAR | radar, own_ship=own_ship)
    prepared = all_round(made)
    for begin in begins:
        azimuths = block(made, *begin, count)
        assert count != 32 or prepared.moving.block_size(azimuths, 16) == count
        assert_echoes(made, prepared.moving.echoes(azimuths), azimuths)


CROWD = [point(f"c{k}", 0.2 * k, 2500.0 + k) for k in range(FEW_ECHOES + 1)]
PLATE = {"name": "p", "shape": "plate", "width_m": 2, "height_m": 1, "scattering": "optics", "position_m": [0, 2900, 5]}
FAR = ring(nearest=2100)


@pytest.mark.parametrize(
    "bodies, own, usual",
    [
        (CROWD, {}, 16), (FAR, {}, 1), (FAR, {"heading_deg": 40, **SWAY}, 16),
        ([*FAR, point("rolling", 0, -2900, **STRAIGHT, **SWAY)], {}, 16), ([*FAR, point("near", 0, -200)], {}, 16),
        ([*FAR, {**PLATE, "course_deg": 90, "speed_kn": 5}], {}, 16),
    ],
    ids=["many", "one by one", "sway", "a body sways", "near", "by optics"],
)  # fmt: skip
def test_other_echoes_keep_to_the_usual_blocks(bodies: list[dict[str, Any]], own: dict[str, Any], usual: int) -> None:
    """With the beam to where something keeps blocks short, and to the other side."""
    made = scene(bodies, radar={**RADAR, "range_max_m": 5000}, own_ship={"course_deg": 200, "speed_kn": 12, **own})
    moving = prepare(made, replace(PRESETS["balanced"], beam_extent=3.0), 3).moving
    north, south = (moving.block_size(block(made, 1, index, 32), usual) for index in (0, 344))
    name = bodies[-1]["name"]
    assert (north, south) == (
        (usual, 32) if name in ("p", CROWD[-1]["name"]) else (32, 16) if name == "near" else (usual, usual)
    )


def test_a_swaying_mast_moves_ranges_azimuths_and_elevations() -> None:
    """With the beam on every fourth point in turn, in four scans of a roll of 9 s."""
    own = {"heading_deg": 40, "course_deg": 40, "speed_kn": 8, **SWAY}
    made = scene(ring(), radar=RADAR, own_ship=own)
    prepared = all_round(made)
    for b in range(0, len(made.bodies), 4):
        for scan in range(4):
            azimuths = block_at(made, scan, b)
            assert_echoes(made, prepared.moving.echoes(azimuths), azimuths)


def test_multipath_follows_the_height_of_a_swaying_mast() -> None:
    """Echoes with sea reflection over those without are F^2 for the antenna's height and tilt at each azimuth. Roll lowers the
    mast by 2 %. 2e-3 of F^2: parabolas of gains, and quotients where the beam's weight is small."""
    own = {"heading_deg": 40, **SWAY}
    with_sea, without = (
        scene(ring(), radar=RADAR, own_ship=own, environment={"multipath": on, "sea_state": 0}) for on in (True, False)
    )
    azimuths = block(without, 0, 640)
    one, other = (all_round(made).moving.echoes(azimuths) for made in (with_sea, without))
    middle = (azimuths.time[0] + azimuths.time[-1]) / 2
    changed = []
    for b, body in enumerate(without.bodies):
        e = int(np.argmin(np.abs(one.range - np.linalg.norm(observed(without, b, middle)[0]))))
        factors = []
        for time in azimuths.time:
            matrices, _ = deck(np.array([time]), np.deg2rad(40))
            height = float(without.radar.height * matrices[0, 2, 2])
            assert height < 0.99 * without.radar.height
            offset, _, elevation = observed(without, b, float(time))
            ground = float(np.hypot(offset[0], offset[1]))
            gain = partial(elevation_gain, without.radar, tilt_error=elevation - float(np.arctan2(offset[2], ground)))
            factors.append(two_ray_factor(
                np.array([ground]), body.motion.position[0, 2:], height, without.radar.wavelength, earth_radius=EARTH,
                polarization=without.radar.polarization, elevation_gain=gain)[0] ** 2)  # fmt: skip
        changed.append(abs(factors[-1] - factors[0]))
        np.testing.assert_allclose(one.amplitude[e] / other.amplitude[e], factors, rtol=0, atol=2e-3)
    assert max(changed) > 0.04  # held over the block it would fail


def test_a_body_on_an_arc_keeps_to_it() -> None:
    """25 kn round corners of 60 m, 12 degrees a second: blocks in which arcs begin and end, and those with the beam on it."""
    made = scene([point("t", 500, 500, waypoints=SQUARE, loop=True, turn_radius_m=60)], radar=RADAR)
    prepared, radar = all_round(made), made.radar
    knots = made.bodies[0].motion.time[1:]
    assert len(knots) > 6
    blocks = [block_at(made, scan, 0) for scan in range(12)]
    for knot in knots:
        scan, index = divmod(int(knot / radar.spoke_period), radar.azimuths)
        blocks.append(block(made, scan, int(np.clip(index - 5, 0, radar.azimuths - 16))))
    for azimuths in blocks:
        assert_echoes(made, prepared.moving.echoes(azimuths), azimuths)


def test_echoes_beyond_the_extent_of_the_beam_are_left_out() -> None:
    """By `fast`, 3 beamwidths of 4 degrees: those within it at some azimuth of the block, and the rest not."""
    made = scene(ring(36, **STRAIGHT), radar={**RADAR, "range_max_m": 9000})
    prepared = prepare(made, PRESETS["fast"], 3)
    azimuths = block(made, 0, 90)
    echoes = prepared.moving.echoes(azimuths)
    off = []
    for b in range(36):
        offsets = [observed(made, b, float(t))[1] - a for a, t in zip(azimuths.boresight, azimuths.time, strict=True)]
        off.append(np.rad2deg(np.abs(np.angle(np.exp(1j * np.array(offsets)))).min()))
    assert len(echoes.range) == np.count_nonzero(np.array(off) < 12.0) > 1
