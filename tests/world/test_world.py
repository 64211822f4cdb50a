"""The short modules of world, each under its name."""

import math
import pickle
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest
from pyproj import Geod

import radar_service as rs
from radar_service.numerics.constants import KNOT
from radar_service.numerics.frames import map_from_body, map_from_deck, wrap_angle
from radar_service.numerics.types import Floats
from radar_service.scattering.physical_optics.mesh_quality import outward_side
from radar_service.scene_file.load import load_scene
from radar_service.world import body as body_module
from radar_service.world.body import (
    MATERIALS,
    SLICES,
    Mesh,
    mesh_sample,
    outward_winding,
    power_reflectivity,
    row_marks,
)
from radar_service.world.environment import Environment, gas_attenuation_db_per_km, oxygen_db_per_km, vapour_db_per_km
from radar_service.world.error import SceneError
from radar_service.world.geo import geographic_from_map, map_bearing, map_from_geographic, true_bearing
from radar_service.world.motion import Motion, Pose, segment_headings
from radar_service.world.poses import BodyPoses, map_from_bodies, merged_mesh, pose_at
from radar_service.world.presence import MAX_CHANGES, Fading, Presence, Presences, SteeredPresence
from radar_service.world.reporting import STATIC, TURNING, ErrorSettings, Reporting, StationClass, interval
from radar_service.world.scene import Platform, outline_of
from radar_service.world.seaway import Sway, SwayState, Waves, sea_state_of, significant_wave_height, wind_speed
from radar_service.world.shapes import sphere
from tests.ports.ais.test_messages import ship
from tests.scenes import point, scene


# reporting: when a transponder is off.
@pytest.mark.parametrize(("time", "silent"), [(0.9, False), (1.0, True), (2.4, True), (2.5, False), (7.0, True)])
def test_it_is_off_from_the_beginning_of_a_period_to_its_end(time: float, silent: bool) -> None:
    assert ship(silent=((1.0, 2.5), (6.0, 8.0))).is_silent(time) == silent
    assert not ship().is_silent(time)


# environment: gas attenuation against the line-by-line sum of ITU-R P.676-12, Annex 1.
# Frequency [GHz], oxygen and water vapour [dB/km] by P.676-12 Annex 1 at 15 C, 1013.25 hPa, 7.5 g/m3: itur 0.4.0,
# gamma0_exact and gammaw_exact.
LINE_BY_LINE = [(3.0, 0.0070760, 0.00046279), (9.41, 0.0081032, 0.0051694), (16.0, 0.0099908, 0.025325),
                (22.235, 0.0132927, 0.178977), (35.0, 0.0318430, 0.0696143), (50.0, 0.2772686, 0.1111585)]  # fmt: skip


@pytest.mark.parametrize("f_ghz, oxygen, vapour", LINE_BY_LINE)
def test_against_the_sum_over_lines(f_ghz: float, oxygen: float, vapour: float) -> None:
    # oxygen 6 %, vapour 12 %: how far the two annexes lie apart between the lines; 10 % of the sum is what is promised
    assert oxygen_db_per_km(f_ghz) == pytest.approx(oxygen, rel=0.06)
    assert vapour_db_per_km(f_ghz) == pytest.approx(vapour, rel=0.12)
    assert gas_attenuation_db_per_km(f_ghz * 1e9) == pytest.approx(oxygen + vapour, rel=0.1)


def test_oxygen_band_is_refused() -> None:
    with pytest.raises(SceneError, match=r'environment.gas_db_per_km: "itu" covers 1 to 54 GHz, not 60 GHz'):
        gas_attenuation_db_per_km(60e9)


# body: the plan view of a body, for any origin of its mesh.
CORNERS = [[90.0, 40.0, -1.0], [110.0, 40.0, 3.0], [110.0, 80.0, 7.0], [90.0, 80.0, 5.0]]

FACES = np.array([[0, 1, 2], [0, 2, 3]])


def test_plan_of_a_mesh_far_from_its_origin() -> None:
    """A rectangle of 20 x 40 m about (100, 60): half its diagonal, and its far corner's distance; vertices that no triangle
    uses do not count. Heading east turns its north side to the east: (100, 60) goes to (60, -100)."""
    made = scene([point("b", 1000, 2000, heading_deg=90)])
    mesh = Mesh(np.array([*CORNERS, [1e6, 0.0, 0.0]]), FACES)
    body = replace(made.bodies[0], mesh=mesh)
    np.testing.assert_array_equal(body.middle, [100.0, 60.0, 0.0])
    assert body.radius == pytest.approx(np.hypot(10, 20)) and body.arm == pytest.approx(np.hypot(110, 80))
    assert body.middle_at(7.0)[:2] == pytest.approx([1060.0, 1900.0])


def test_plan_of_a_point() -> None:
    body = scene([point("b", 1, 2, course_deg=90, speed_kn=10)]).bodies[0]
    assert body.radius == body.arm == 0.0 and not body.middle.any()
    assert body.middle_at(10.0)[:2] == pytest.approx([1 + 10 * 10 * 1852 / 3600, 2.0])


# The environment of an empty scene: the standard earth, and no other effect.
def test_all_effects_are_off_by_default() -> None:
    assert scene().environment == Environment(
        earth_factor=4 / 3, noise=False, multipath=False, gas_db_per_km=0.0, rain_mm_h=0.0, sea_state=0,
        effect_keys={"sea_texture_shape": None}, wind_from=0.0, ground_plane=False,
    )  # fmt: skip
    assert scene().effects == {}


# error: the error of a scene.
def test_the_text_has_a_line_for_each_problem() -> None:
    error = SceneError("radar.rpm: too low", "body[0]: no name")
    assert error.problems == ("radar.rpm: too low", "body[0]: no name")
    assert str(error) == "radar.rpm: too low\nbody[0]: no name"
    assert isinstance(error, ValueError)


# Errors on purpose in SI units.
EVERY: dict[str, dict[str, Any]] = {
    "gyro": {"bias_deg": 0.5, "calibration_deg": 0.3, "calibration_phase_deg": 40.0, "noise_deg": 0.12, "noise_time_s": 7.0,
             "latency_s": 0.2},
    "log": {"bias_kn": -0.5, "scale_percent": 3.0, "least_kn": 0.1, "noise_kn": 0.1, "noise_time_s": 5.0, "latency_s": 1.0},
    "position": {"bias_m": [3.0, -4.0], "noise_m": 2.5, "noise_time_s": 90.0, "latency_s": 0.5},
    "antenna": {"misalignment_deg": -1.1, "backlash_deg": 0.05, "encoder_noise_deg": 0.03, "encoder_step_deg": 0.2},
    "feed": {"drop_rate": 0.1, "burst_rate": 0.01, "burst_spokes": 12, "repeat_rate": 0.05, "late_rate": 0.04, "late_s": 0.3,
             "swap_rate": 0.02, "stuck_sector_deg": [10.0, 20.0], "heading_lost_s": [[1.0, 2.0], [5.0, 6.0]],
             "bytes_per_s": 5000.0, "cut_after_s": 30.0},
}  # fmt: skip


def settings(errors: Any) -> ErrorSettings:
    """The errors of a scene with these tables."""
    made = rs.load_scene({"errors": errors}).errors
    assert made is not None
    return made


def test_values_become_si_and_radians() -> None:
    its = settings(EVERY)
    assert its.gyro and its.log and its.position and its.antenna and its.feed
    assert its.gyro.calibration_phase == pytest.approx(math.radians(40), rel=1e-12)
    assert (its.log.bias, its.log.scale) == pytest.approx((-0.5 * 1852 / 3600, 0.03), rel=1e-12)
    assert its.position.bias == (3.0, -4.0) and its.antenna.misalignment == pytest.approx(math.radians(-1.1), rel=1e-12)
    assert its.feed.stuck_sector == pytest.approx((math.radians(10), math.radians(20)), rel=1e-12)
    assert (its.feed.bytes, its.feed.cut_after, its.feed.late) == (5000.0, 30.0, 0.3)


# Materials by name.
def test_gammas_are_power_ratios_in_the_ladder_of_land() -> None:
    assert MATERIALS["sand"].gamma == pytest.approx(0.01)  # -20 dB, flat ground
    assert MATERIALS["sand"].gamma < MATERIALS["land"].gamma < MATERIALS["urban"].gamma < MATERIALS["rock"].gamma
    assert all(name == material.name and 0.0 < material.gamma <= 1.0 for name, material in MATERIALS.items())


def test_only_metals_scatter_by_optics() -> None:
    assert {name for name, material in MATERIALS.items() if material.scattering == "optics"} == {"steel", "aluminium"}


def test_every_material_has_its_reflectivity() -> None:
    """Metals all of it, nothing else half; concrete as its permittivity says: ((sqrt 5.24 - 1) / (sqrt 5.24 + 1))^2, to the
    digit its decibels are given with."""
    shares = {name: power_reflectivity(name) for name in MATERIALS}
    assert shares["steel"] == shares["aluminium"] == 1.0
    assert all(0.0 < share < 0.5 for name, share in shares.items() if MATERIALS[name].scattering != "optics")
    assert shares["concrete"] == pytest.approx(((5.24**0.5 - 1) / (5.24**0.5 + 1)) ** 2, rel=0.012)


# scene: what a service knows of a scene.
BUOY = {"name": "buoy", "shape": "point", "rcs_dbsm": 0, "position_m": [0, 100, 5], "steerable": {}}


def test_an_outline_says_what_may_be_steered_and_holds_no_bodies() -> None:
    scene = load_scene({"name": "harbour", "origin": {"latitude_deg": 50, "longitude_deg": 1}, "body": [BUOY] * 1})
    outline = outline_of(scene)
    assert (outline.name, outline.origin, outline.body_count) == ("harbour", (50, 1), 1)
    assert outline.radar is scene.radar and outline.steerable.names == {"buoy"} and outline.has_sensors
    assert pickle.loads(pickle.dumps(outline)) == outline


# The platform: positions and directions of an antenna on a moving, swaying ship.
ROLL = Sway(np.array([np.pi / 6, 0.0, 0.0, 0.0]), np.array([4.0, 1.0, 1.0, 1.0]))  # 30 degrees to starboard at 1 s
HEAVE = Sway(np.array([0.0, 0.0, 0.0, 0.5]), np.full(4, 4.0))
ROUNDING = 1e-12  # of float64 at some 10 m


def platform(heading: float, sway: Sway | None = None) -> Platform:
    """A platform that passes east 100 m, north 50 m at t = 0 with 2 m/s to the east."""
    return Platform(
        Motion(np.zeros(1), np.array([[100.0, 50.0, 0.0]]), np.array([heading]), np.array([2.0, 0.0, 0.0]), sway=sway)
    )


def test_an_upright_mast_stands_above_the_motion() -> None:
    steady = platform(0.3)
    np.testing.assert_allclose(
        steady.antenna(np.array([0.0, 3.0]), 15.0), [[100, 50, 15], [106, 50, 15]], rtol=0, atol=ROUNDING
    )
    np.testing.assert_allclose(steady.heading(np.array([0.0, 9.0])), 0.3, rtol=0, atol=ROUNDING)
    assert steady.upright_from_map(np.zeros(2)) is None and steady.text == "at east 100.0, north 50.0 m"


def test_roll_moves_the_antenna_to_starboard_and_down() -> None:
    """h sin 30 to starboard, which is south on an eastern heading, and h cos 30 above the sea."""
    antenna = platform(np.pi / 2, ROLL).antenna(1.0, 20.0)
    np.testing.assert_allclose(antenna, [[102.0, 40.0, 20.0 * np.sqrt(0.75)]], rtol=0, atol=ROUNDING)


def test_heave_alone_lifts_the_antenna_over_the_sea() -> None:
    """Half a metre at a quarter of its period; where the motion itself lies does not count."""
    heaving = Platform(Motion(np.zeros(1), np.array([[0.0, 0.0, 7.0]]), np.zeros(1), sway=HEAVE))
    np.testing.assert_allclose(heaving.antenna(np.array([0.0, 1.0]), 20.0)[:, 2], [20.0, 20.5], rtol=0, atol=ROUNDING)


def test_directions_along_the_swaying_mast_become_vertical() -> None:
    rolling, time = platform(np.pi / 2, ROLL), np.array([0.0, 1.0])
    matrix = rolling.upright_from_map(time)
    assert matrix is not None
    mast = rolling.antenna(time, 1.0) - rolling.motion.pose(time).position
    np.testing.assert_allclose(np.einsum("kij,kj->ki", matrix, mast), [[0, 0, 1], [0, 0, 1]], rtol=0, atol=ROUNDING)
    np.testing.assert_allclose(matrix[1] @ [1.0, 0.0, 0.0], [1, 0, 0], rtol=0, atol=ROUNDING)  # the axis of roll stays


# seaway: sway: angles, heave and their rates.
SWAY = Sway(np.array([0.2, 0.1, 0.05, 0.6]), np.array([6.0, 5.0, 9.0, 4.0]), np.array([0.4, -1.0, 2.0, 0.7]))
TIME = np.linspace(0.0, 30.0, 61)
STEP = 1e-5  # s; a central difference over it errs by some 1e-10


def along(law: Sway, time: Floats) -> SwayState:
    return Motion(np.zeros(1), np.zeros((1, 3)), np.zeros(1), sway=law).sway_state(time)


def test_each_motion_is_a_sine_of_its_period_and_phase() -> None:
    expected = SWAY.amplitude * np.sin(2 * np.pi * TIME[:, None] / SWAY.period + SWAY.phase)
    np.testing.assert_allclose(along(SWAY, TIME).values, expected, atol=1e-14)
    assert SWAY.max_heave == 0.6 and SWAY.max_tilt == pytest.approx(0.3) and SWAY.tilts and SWAY.shortest_period == 4.0
    assert not Sway(np.array([0.0, 0.0, 0.1, 1.0]), np.ones(4)).tilts


def test_list_and_trim_are_added_to_roll_and_pitch() -> None:
    leaning = replace(SWAY, lean=(0.03, -0.02))
    added = along(leaning, TIME).values - along(SWAY, TIME).values
    np.testing.assert_allclose(added, np.tile([0.03, -0.02, 0.0, 0.0], (len(TIME), 1)), atol=1e-15)
    np.testing.assert_array_equal(along(leaning, TIME).rates, along(SWAY, TIME).rates)
    np.testing.assert_allclose(leaning.max_values, [0.23, 0.12, 0.05, 0.6])
    assert Sway(np.zeros(4), np.ones(4), lean=(0.1, 0.0)).tilts


def test_rates_are_derivatives_and_have_their_maxima() -> None:
    before, after = (along(SWAY, t).values for t in (TIME - STEP, TIME + STEP))
    np.testing.assert_allclose(along(SWAY, TIME).rates, (after - before) / (2 * STEP), atol=1e-8)
    every = along(SWAY, np.linspace(0, 200, 200001)).rates
    np.testing.assert_allclose(np.abs(every).max(axis=0), SWAY.max_rates, rtol=1e-6)
    motion = Motion(np.zeros(1), np.zeros((1, 3)), np.zeros(1), sway=SWAY)
    about = np.hypot(along(SWAY, TIME).rates, SWAY.max_rates / 2.0)
    np.testing.assert_allclose(motion.sway_rates(TIME), about, rtol=1e-12)


def test_the_rotation_changes_at_its_rate() -> None:
    heading, turn_rate = 1.0 + 0.03 * TIME, np.full(len(TIME), 0.03)
    state = along(SWAY, TIME)
    np.testing.assert_array_equal(state.rotation(heading), map_from_deck(heading, *state.values.T[:2]))
    ends = [along(SWAY, TIME + sign * STEP).rotation(heading + sign * STEP * 0.03) for sign in (-1, 1)]
    rate = state.rotation_rate(heading, turn_rate)
    np.testing.assert_allclose(rate, (ends[1] - ends[0]) / (2 * STEP), atol=1e-8)


# motion: properties of a motion.
def test_the_top_speed_is_that_along_the_arcs() -> None:
    """A square whose corners' arcs meet is a circle: no leg is straight, and a chord of a quarter is 0.9 of its arc."""
    corners = [{"position_m": list(p), "speed_kn": 15.6} for p in [(0, 200), (200, 200), (200, 0)]]
    circle = point("t", 0, 0, waypoints=corners, turn_radius_m=100, loop=True)
    made = scene([circle], radar={"pulse_s": 1e-3})
    assert made.bodies[0].motion.top_speed == pytest.approx(15.6 * KNOT, rel=1e-12)  # rounding
    assert any("Doppler" in warning for warning in made.warnings)  # from 15.48 kn on: lambda / (4 T)


def test_the_course_of_a_body_at_rest_is_its_heading() -> None:
    pose = Pose(np.zeros((2, 3)), np.array([[0.0, 0, 0], [0, -3.0, 0]]), np.array([1.0, 1.0]))
    np.testing.assert_allclose(pose.course, [1.0, np.pi])
    np.testing.assert_array_equal(pose.speed, [0.0, 3.0])


def test_yaw_adds_to_the_heading_and_is_no_rest() -> None:
    sway = Sway(np.array([0.0, 0.0, 0.1, 0.0]), np.array([1.0, 1.0, 8.0, 1.0]))
    motion = Motion(np.zeros(1), np.zeros((1, 3)), np.array([1.0]), sway=sway)
    np.testing.assert_allclose(motion.pose(np.array([0.0, 2.0, 6.0])).heading, [1.0, 1.1, 0.9])
    assert not motion.at_rest and Motion(np.zeros(1), np.zeros((1, 3)), np.zeros(1)).at_rest


def test_a_motion_is_even_where_a_straight_line_over_time_fits_it() -> None:
    """One that starts at 5 s is so from then on; a sway never is; one at rest always."""
    around, after = np.array([4.0, 6.0, 8.0]), np.array([5.0, 6.0, 8.0])
    straight = Motion(np.array([5.0]), np.zeros((1, 3)), np.zeros(1), np.array([3.0, 4.0, 0.0]))
    swaying = Motion(np.zeros(1), np.zeros((1, 3)), np.zeros(1), sway=Sway(np.full(4, 0.1), np.full(4, 8.0)))
    assert not straight.is_even(around) and straight.is_even(after)
    assert not swaying.is_even(after) and Motion(np.full(1, 5.0), np.zeros((1, 3)), np.zeros(1)).is_even(around)


def test_corners_lie_between_legs_and_laps() -> None:
    """A loop of 10, 10 and 20 s; before the start a lap ends. At rest and on one leg there are none."""
    knots = np.array([(0.0, 0, 0), (0, 10, 0), (10, 10, 0), (0, 0, 0)])
    loop = Motion(np.array([0.0, 10.0, 20.0, 40.0]), knots, segment_headings(knots, None), period=40.0)
    times = np.array([-1.0, 0.0, 5.0, 10.0, 15.0, 19.9, 20.1, 39.0, 40.0, 41.0, 55.0, 79.9, 80.0])
    assert np.flatnonzero(loop.corners(times)).tolist() == [0, 2, 5, 7, 9, 10, 11]
    once = replace(loop, period=None)
    assert np.flatnonzero(once.corners(times)).tolist() == [0, 2, 5, 7]
    straight = Motion(np.zeros(1), np.zeros((1, 3)), np.zeros(1), np.ones(3))
    assert np.flatnonzero(straight.corners(times)).tolist() == [0]
    assert not replace(straight, final_velocity=np.zeros(3)).corners(times).any()


def test_corners_are_where_the_pose_jumps_to_the_last_digit() -> None:
    """Laps of 0.1 s, which no time holds exactly: each jump of the heading has a corner, and no other step."""
    knots = np.array([(0.0, 0, 0), (0, 1, 0), (0, 0, 0)])
    loop = Motion(np.array([0.0, 0.05, 0.1]), knots, segment_headings(knots, None), period=0.1)
    times = np.arange(4000) * 0.05 / 7.0 + 1e5
    np.testing.assert_array_equal(loop.corners(times), np.diff(loop.pose(times).heading) != 0.0)


# Records of a seaway: waves travel at their phase velocity, and add up; wave heights and periods by sea state.
G = 9.80665
FREQUENCY = np.array([0.5, 0.9, 1.7])
DIRECTION = np.array([[0.6, 0.8], [-1.0, 0.0], [0.28, -0.96]])
WAVES = Waves(
    np.array([1.0, 0.5, 0.2]), FREQUENCY, (FREQUENCY**2 / G)[:, None] * DIRECTION, FREQUENCY, np.array([0.1, 2.0, 4.0])
)
PLACE = np.array([[300.0, -800.0]])


def test_a_crest_goes_on_at_its_phase_velocity() -> None:
    """The sea is one for all places: what a wave has here, it has at c t farther on."""
    time = np.array([50.0])
    for n in range(3):
        moved = PLACE + G / FREQUENCY[n] * time * DIRECTION[n]
        here, there = WAVES.phases(PLACE, np.zeros(1))[0, n], WAVES.phases(moved, time)[0, n]
        np.testing.assert_allclose(there, here, atol=1e-9)


def test_the_elevation_is_the_sum_of_the_waves() -> None:
    east, north, time = 300.0, -800.0, 123.4
    k = FREQUENCY**2 / G
    expected = sum(
        a * np.cos(k[n] * (east * DIRECTION[n, 0] + north * DIRECTION[n, 1]) - FREQUENCY[n] * time + WAVES.phase[n])
        for n, a in enumerate([1.0, 0.5, 0.2])
    )
    np.testing.assert_allclose(WAVES.elevation(PLACE, np.array([time])), expected, atol=1e-12)


@pytest.mark.parametrize(
    ("state", "height", "wind"), [(1, 0.14, 3.16), (3, 1.04, 7.61), (5, 2.98, 11.45), (2.5, 0.72, 6.58)]
)
def test_one_table_of_sea_states_by_hand(state: float, height: float, wind: float) -> None:
    """0.04 + 0.1 s^2.1 m, as the NRL report prints them: 0.14, 0.47, 1.04, 1.88, 2.98, 4.35; 3.16 s^0.8 m/s; and back."""
    assert significant_wave_height(state) == pytest.approx(height, abs=5e-3)
    assert wind_speed(state) == pytest.approx(wind, abs=5e-3)
    assert sea_state_of(significant_wave_height(state)) == pytest.approx(state, rel=1e-12)


def test_sea_states_beyond_the_table_are_refused() -> None:
    for state in (-0.1, 9.1):
        with pytest.raises(ValueError, match=f"sea_state: {state} is not allowed; 0 to 9"):
            significant_wave_height(state)
    assert significant_wave_height(0) == 0.0
    with pytest.raises(ValueError, match="sea_state: 0 has no wind"):
        wind_speed(0)


# Slices of large meshes, and whether these are closed, against the search by sorted edges.
def test_a_small_mesh_is_judged_as_it_is_and_of_a_large_one_slices(monkeypatch: pytest.MonkeyPatch) -> None:
    ball = sphere(10.0, 0.004)
    assert mesh_sample(ball) is ball
    monkeypatch.setattr(body_module, "MAX_JUDGED", 40 * SLICES)
    part = mesh_sample(Mesh(ball.vertices * [1.0, 9.0, 1.0], ball.faces))
    assert len(part.faces) == 40 * SLICES and len(part.vertices) < 2 * len(part.faces)
    first = np.sort(part.vertices[part.faces[:, 0], 1])
    assert first[0] < -85.0 and first[-1] > 85.0
    assert (np.diff(first) > 0.5).sum() >= SLICES - 1  # gaps between the slices
    assert {tuple(row) for row in part.vertices} <= {tuple(row) for row in ball.vertices * [1.0, 9.0, 1.0]}


@pytest.mark.parametrize("welded", [True, False])
def test_a_closed_mesh_is_found_without_a_sort(welded: bool) -> None:
    """As it is, turned inside out, with a hole, with one triangle wound the other way; corners shared or not."""
    ball = sphere(3.0)
    flipped = ball.faces.copy()
    flipped[7] = flipped[7, ::-1]
    for faces, expected in ((ball.faces, 1), (ball.faces[:, ::-1], -1), (ball.faces[1:], 0), (flipped, 0)):
        mesh = Mesh(ball.vertices, faces)
        if not welded:
            mesh = Mesh(ball.vertices[faces].reshape(-1, 3), np.arange(faces.size).reshape(-1, 3))
        assert outward_winding(mesh) == expected
        assert set(outward_side(mesh).tolist()) == {expected}


def test_equal_rows_have_equal_marks() -> None:
    rows = np.random.default_rng(1).integers(-9, 9, (5000, 3)) / 8.0
    rows[::7] *= -1.0  # some zeros are negative
    marks = row_marks(rows)
    number = np.unique(rows + 0.0, axis=0, return_inverse=True)[1].ravel()
    assert len(np.unique(marks)) == number.max() + 1 == len(np.unique(np.stack([marks, number.astype(np.uint64)]), axis=1).T)


# presence: when a body is present.
@dataclass(frozen=True)
class Guest:
    """Something with a presence alone."""

    presence: Presence


VISIT = Presence(np.array([0.0, 3.0, 7.0]), np.array([False, True, False]))


def test_a_change_holds_from_its_instant_on() -> None:
    times = np.array([-1.0, 0.0, 2.999, 3.0, 6.999, 7.0, 1e6])
    assert VISIT.at(times).tolist() == [False, False, False, True, True, False, False]
    assert Presence.always.at(times).all() and Presence.always.constant and not VISIT.constant


def test_a_time_that_misses_an_instant_by_rounding_is_at_it() -> None:
    assert VISIT.at(np.array([3.0 - 1e-12])).all()


def test_fading_repeats_its_pattern() -> None:
    fading = Presence(np.zeros(1), np.ones(1, dtype=np.bool_), Fading(np.array([True, True, False]), 2.5, 1.0))
    assert fading.at(np.arange(1.0, 17.0, 2.5)).tolist() == [True, True, False, True, True, False, True]
    assert fading.at(np.array([0.9]))[0] == np.False_  # the unit before the first is the last of the pattern
    assert not fading.constant


def test_fading_applies_while_the_body_is_there_at_all() -> None:
    both = Presence(VISIT.time, VISIT.present, Fading(np.array([True, False]), 1.0))
    assert both.at(np.arange(10.0)).tolist() == [False, False, False, False, True, False, True, False, False, False]


def test_a_later_change_replaces_what_was_planned_after_it() -> None:
    changed = VISIT.changed(5.0, False).changed(6.0, True)
    assert changed.at(np.array([2.0, 4.0, 5.5, 6.5, 8.0])).tolist() == [False, True, False, True, True]
    assert Presence.always.changed(0.0, False).at(np.array([-0.5, 0.0])).tolist() == [True, False]


def test_spans_end_where_any_presence_changes() -> None:
    late = Presence(np.array([0.0, 5.0]), np.array([False, True]))
    bodies = [Guest(Presence.always), Guest(VISIT), Guest(late)]
    presences = Presences(bodies)
    assert presences.changing.tolist() == [1, 2]
    assert list(presences.spans(np.arange(10.0))) == [(0, 3), (3, 5), (5, 7), (7, 10)]
    assert list(Presences(bodies[:1]).spans(np.arange(10.0))) == [(0, 10)]
    assert [presences.at(time).tolist() for time in (1.0, 6.0, 8.0)] == [
        [True, False, False], [True, True, True], [True, False, True],
    ]  # fmt: skip


TIMES = np.array([0.0, 4.9, 5.0, 8.0, 20.0])


def test_it_begins_as_the_presence_of_the_scene_and_is_never_constant() -> None:
    presence = SteeredPresence.under(Presence.always)
    assert presence.at(TIMES).all() and not presence.constant and not presence.past.constant
    hidden = SteeredPresence.under(Presence(np.zeros(1), np.zeros(1, dtype=np.bool_)))
    assert not hidden.at(TIMES).any() and not hidden.past.at(TIMES).any()


def test_the_past_takes_changes_at_once_and_the_rest_follows() -> None:
    presence = SteeredPresence.under(Presence.always)
    presence.steer(5.0, False)
    assert presence.at(TIMES).all()
    np.testing.assert_array_equal(presence.past.at(TIMES), [True, True, False, False, False])
    presence.follow()
    np.testing.assert_array_equal(presence.at(TIMES), [True, True, False, False, False])
    presence.steer(8.0, True)
    presence.follow()
    np.testing.assert_array_equal(presence.at(TIMES), [True, True, False, True, True])
    presence.forget()
    assert presence.past.at(TIMES).all() and not presence.at(TIMES).all()
    presence.follow()
    assert presence.at(TIMES).all()


def test_fading_goes_on() -> None:
    presence = SteeredPresence.under(Presence(np.zeros(1), np.ones(1, dtype=np.bool_), Fading(np.array([True, False]), 4.0)))
    presence.steer(5.0, True)
    presence.follow()
    np.testing.assert_array_equal(presence.at(np.array([1.0, 5.0, 9.0, 13.0])), [True, False, True, False])


def test_it_remembers_so_many_changes_and_travels() -> None:
    presence = SteeredPresence.under(Presence.always)
    for second in range(MAX_CHANGES + 5):
        presence.steer(float(second), second % 2 == 0)
    presence.follow()
    times = np.arange(10.0, MAX_CHANGES + 5.0)
    np.testing.assert_array_equal(presence.at(times), times % 2 == 0)
    np.testing.assert_array_equal(pickle.loads(pickle.dumps(presence)).at(times), times % 2 == 0)


# Reporting intervals of ITU-R M.1371-5.


@pytest.mark.parametrize(
    ("station", "knots", "turns", "expected"),
    [
        ("A", 0, False, 180), ("A", 0.1, False, 10), ("A", 14, False, 10), ("A", 14, True, 10 / 3), ("A", 14.1, False, 6),
        ("A", 23, True, 2), ("A", 23, False, 6), ("A", 23.1, False, 2), ("A", 23.1, True, 2), ("B-SO", 2, False, 180),
        ("B-SO", 2.1, True, 30), ("B-SO", 14.1, False, 15), ("B-SO", 23.1, False, 5), ("B-CS", 2, False, 180),
        ("B-CS", 2.1, False, 30), ("B-CS", 40, True, 30),
    ],
)  # fmt: skip
def test_intervals(station: StationClass, knots: float, turns: bool, expected: float) -> None:
    rate = 1.01 * TURNING if turns else 0.99 * TURNING
    assert interval(ship(station_class=station), knots * KNOT, rate) == interval(
        ship(station_class=station), knots * KNOT, -rate
    )
    assert interval(ship(station_class=station), knots * KNOT, rate) == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize(
    ("knots", "turns", "every"), [(10, False, 10.0), (10, True, 10 / 3), (20, False, 6.0), (30, False, 2.0)]
)
def test_reports_keep_their_interval_on_whole_seconds(knots: float, turns: bool, every: float) -> None:
    reporting = Reporting(ship(), 5)
    times = [second for second in range(600) if reporting.is_due(second, knots * KNOT, 2 * TURNING * turns)]
    assert len(times) == pytest.approx(600 / every, abs=1)
    assert {b - a for a, b in zip(times, times[1:], strict=False)} <= {math.floor(every), math.ceil(every)}
    assert times[0] < every


def test_an_aid_reports_each_three_minutes_however_it_moves() -> None:
    reporting = Reporting(ship(kind="aid"), 5)
    times = [second for second in range(1000) if reporting.is_due(second, 5 * KNOT * (second % 2), 0.1)]
    assert {b - a for a, b in zip(times, times[1:], strict=False)} == {180} and times[0] < 180
    assert not any(reporting.is_static_due(second) for second in range(1000))


def test_a_sart_sends_eight_messages_a_minute_two_of_them_its_text_in_each_fourth() -> None:
    reporting = Reporting(ship(kind="sart"), 5)
    first = next(second for second in range(60) if reporting.is_due(second, 0.0, 0.0))
    sent = {
        second - first: "text" if reporting.is_static_due(second) else "position"
        for second in range(first, first + 480)
        if reporting.is_due(second, 0.0, 0.0) or reporting.is_static_due(second)
    }
    assert list(sent) == [60 * minute + 2 * k for minute in range(8) for k in range(8)]
    assert [second for second, what in sent.items() if what == "text"] == [8, 10, 248, 250]


def test_a_turn_is_reported_sooner() -> None:
    """At anchor each three minutes; the report that is due later comes within the new interval."""
    reporting = Reporting(ship(), 5)
    at_rest = [second for second in range(400) if reporting.is_due(second, 0.0, 0.0)]
    assert len(at_rest) in (2, 3) and at_rest[-1] - at_rest[0] in (180, 360)
    under_way = [second for second in range(400, 430) if reporting.is_due(second, 30 * KNOT, 0.0)]
    assert under_way[0] <= 402 and len(under_way) >= 14


def test_static_reports_come_every_six_minutes_and_ships_not_together() -> None:
    firsts = []
    for mmsi in range(100, 140):
        reporting = Reporting(ship(mmsi=mmsi), 1)
        times = [second for second in range(1000) if reporting.is_static_due(second)]
        assert {b - a for a, b in zip(times, times[1:], strict=False)} == {int(STATIC)}
        firsts.append(times[0])
        assert 1 <= reporting.slot < 10
    assert len(set(firsts)) > 10 and max(firsts) < 60


# poses: those of many bodies are those of each body.
def test_poses_are_those_of_each_motion() -> None:
    """At rest, on a straight course, on a polygon and on arcs, before and after its end; to rounding of 1 km."""
    corners = [{"position_m": list(p), "speed_kn": 12} for p in [(190, 230), (320, 230)]]
    made = scene(
        [
            point("rest", 1, 2, heading_deg=-30), point("straight", 3, 4, course_deg=50, speed_kn=9, heading_deg=-20),
            point("legs", 190, 160, waypoints=corners), point("arcs", 190, 160, waypoints=corners, turn_radius_m=40),
        ]
    )  # fmt: skip
    time = np.linspace(0, 60, 23)
    poses = BodyPoses(made.bodies).at(time)
    for b, body in enumerate(made.bodies):
        pose = body.motion.pose(time)
        np.testing.assert_allclose(poses.position[:, b], pose.position, atol=1e-12)
        np.testing.assert_allclose(poses.heading[:, b], pose.heading, atol=1e-15)


def test_points_are_transformed_as_by_the_frame() -> None:
    rng = np.random.default_rng(1)
    points, body = rng.normal(size=(40, 3)), rng.integers(0, 3, 40)
    position, heading = rng.normal(size=(3, 3)) * 100, np.array([0.0, 1.2, 5.0])
    transformed = map_from_bodies(points, body, position, heading)
    for b in range(3):
        expected = map_from_body(points[body == b], position[b], float(heading[b]))
        assert transformed[body == b] == pytest.approx(expected, abs=1e-12)


def test_poses_of_leaning_bodies_are_those_of_each_motion() -> None:
    """Of many bodies at once, of one, and back into the frame; what does not lean has no rotation of its own."""
    keys = {"roll_deg": 20, "pitch_deg": 10, "pitch_phase_deg": 60, "heave_m": 1, "yaw_deg": 5}
    made = scene([point("a", 1, 2), point("b", 30, 40, course_deg=50, speed_kn=9, **keys), point("c", 5, 6, yaw_deg=5)])
    time, rng = np.array([0.5, 3.0, 7.7]), np.random.default_rng(2)
    poses, points, body = BodyPoses(made.bodies).at(time), rng.normal(size=(30, 3)) * 9, rng.integers(0, 3, 30)
    assert list(poses.rotation) == [1]
    for k in range(len(time)):
        placed = poses.map_from_bodies(k, points, body)
        for b, one in enumerate(made.bodies):
            pose, own = pose_at(one, float(time[k])), body == b
            np.testing.assert_allclose(placed[own], pose.map_from_frame(points[own]), atol=1e-12)
            np.testing.assert_allclose(pose.frame_from_map(placed[own], np.inf), points[own], atol=1e-12)
            assert (pose.lean is None) == (b != 1) and pose.upright.rotation is None
            if pose.lean is not None:
                upright = pose.upright.map_from_frame(points[own] @ pose.lean.T)
                np.testing.assert_allclose(placed[own], upright, atol=1e-12)


def test_poses_of_ships_in_a_seaway_are_those_of_each_motion_to_the_byte() -> None:
    """Under way, at anchor, on legs, one that appears late, one that eases; of all or some, at few or many instants."""
    hull = {"shape": "hull", "length_m": 30, "beam_m": 8, "height_m": 8, "rcs_dbsm": 10}
    keys: list[dict[str, object]] = [{"course_deg": 50, "speed_kn": 9}, {},
                                     {"waypoints": [{"position_m": [99, 9], "speed_kn": 8}]}]  # fmt: skip
    keys += [{"course_deg": 300, "speed_kn": 5, "start_s": 4.0}, {"speed_kn": 5}]
    ships = [{"name": str(k), **hull, "position_m": [150.0 * k, 400, 0], **more} for k, more in enumerate(keys)]
    made = scene(ships, environment={"sea_state": 4, "seaway": True, "current_kn": 2, "current_to_deg": 20})
    *bodies, eases = made.bodies
    assert eases.motion.sway is not None
    bodies.append(replace(eases, motion=replace(eases.motion, sway=eases.motion.sway.eased((2.0, 1.0), 0.0))))
    evaluated = BodyPoses(bodies)
    for time in (np.array([6.0]), np.linspace(4.5, 90.0, 40), np.linspace(-1.0, 9.0, 5), np.zeros(0)):
        for requested in (None, np.array([1]), np.array([4, 0])):
            poses = evaluated.at(time, requested)
            for b in range(5) if requested is None else requested.tolist():
                pose = bodies[b].motion.pose(time)
                np.testing.assert_array_equal(poses.position[:, b], pose.position)
                np.testing.assert_array_equal(poses.heading[:, b], pose.heading)
                np.testing.assert_array_equal(poses.rotation[b], pose.rotation)


def test_bodies_that_are_not_even_are_found_among_those_requested() -> None:
    """Of one at rest, one on a straight course, and two on legs, of which one is not requested."""
    corners = [{"position_m": list(p), "speed_kn": 12} for p in [(190, 230), (320, 230)]]
    legs = [point(name, 190, 160, waypoints=corners) for name in ("legs", "more")]
    made = scene([point("rest", 1, 2), legs[0], point("straight", 3, 4, course_deg=50, speed_kn=9), legs[1]])
    assert BodyPoses(made.bodies).uneven(np.array([0.0, 1.0]), np.array([0, 1, 2])).tolist() == [1]


def test_meshes_at_rest_are_merged_in_their_order_and_a_single_one_is_not_copied() -> None:
    box = {"shape": "box", "length_m": 4, "width_m": 2, "height_m": 3}
    made = scene(
        [
            {"name": "first", **box, "position_m": [10, 20, 0], "heading_deg": 90},
            point("buoy", 5, 5),
            {"name": "second", **box, "position_m": [-30, 5, 1]},
        ]
    )
    first, buoy, second = made.bodies
    merged, alone = merged_mesh(made.bodies), merged_mesh([first, buoy])
    assert merged is not None and alone is not None and first.mesh is not None and second.mesh is not None
    assert merged_mesh([buoy]) is None and alone.faces is first.mesh.faces
    expected = [pose_at(body, 0.0).map_from_frame(body.mesh.vertices[body.mesh.faces]) for body in (first, second)]
    assert np.array_equal(merged.vertices[merged.faces], np.concatenate(expected))
    assert np.array_equal(alone.vertices[alone.faces], expected[0])


# geo: placement against published numbers and against spherical and series formulas of its own.
def test_flinders_peak_to_buninyong() -> None:
    """The worked example of the Geocentric Datum of Australia technical manual: 54 972.271 m at 306 52 05.37."""
    # The manual uses GRS80; its flattening differs from WGS 84 by 1.6e-11, under a micrometre here.
    flinders = (-(37 + 57 / 60 + 3.72030 / 3600), 144 + 25 / 60 + 29.52440 / 3600)
    buninyong = (-(37 + 39 / 60 + 10.15610 / 3600), 143 + 55 / 60 + 35.38390 / 3600)
    east, north = map_from_geographic(*buninyong, flinders)
    bearing_deg = math.degrees(math.atan2(east, north)) % 360
    assert abs(math.hypot(east, north) - 54972.271) < 1e-3  # m: last printed digit, and rounding of the printed places
    assert abs(bearing_deg - (306 + 52 / 60 + 5.37 / 3600)) < 0.01 / 3600  # last printed digit


def test_quarter_of_the_meridian() -> None:
    """From the equator to the pole is 10 001 965.729 m on WGS 84 (meridian quadrant, published to the millimetre)."""
    east, north = map_from_geographic(90.0, 7.0, (0.0, 7.0))
    assert abs(math.hypot(east, north) - 10_001_965.729) < 1e-3
    assert abs(east) < 1e-3


def test_short_distances_follow_the_radii_of_curvature() -> None:
    """One second of arc north and east at 50.9 N are M and N cos(latitude) times the angle (ellipsoidal geometry)."""
    a, f, latitude = 6_378_137.0, 1 / 298.257223563, math.radians(50.9)
    e2 = f * (2 - f)
    w = math.sqrt(1 - e2 * math.sin(latitude) ** 2)
    second = 1.0 / 3600.0
    positions = map_from_geographic(np.array([50.9 + second, 50.9]), np.array([1.4, 1.4 + second]), (50.9, 1.4))
    north = a * (1 - e2) / w**3 * math.radians(second)
    east = a / w * math.cos(latitude) * math.radians(second)
    # the next term of the series is tan(latitude)/(2 N) s^2 = 5e-5 m north for the place in the east
    np.testing.assert_allclose(positions, [[0.0, north], [east, 0.0]], atol=1e-4)


def test_both_conversions_cancel() -> None:
    rng = np.random.default_rng(1)
    positions = rng.uniform(-2e5, 2e5, (50, 4, 2))
    back = geographic_from_map(positions, (48.3, -122.5))
    again = map_from_geographic(back[..., 0], back[..., 1], (48.3, -122.5))
    np.testing.assert_allclose(again, positions, atol=1e-6)  # m: nanometres of the solver, 1e-14 of a longitude in degrees


def test_heights_are_ignored_and_the_origin_is_itself() -> None:
    np.testing.assert_allclose(geographic_from_map(np.array([0.0, 0.0, 99.0]), (10.0, 20.0)), [10.0, 20.0], atol=1e-12)


PLACES = [((50.0, -1.0), (0.0, 0.0)), ((50.0, -1.0), (150e3, -80e3)), ((89.0, 12.0), (9e3, 4e3)), ((-20.0, 180.0), (-300e3, 5e3)),
          ((60.0, 5.0), (1.2e6, 0.9e6)), ((0.0, 0.0), (0.0, 2e5))]  # fmt: skip


@pytest.mark.parametrize(("origin", "place"), PLACES)
def test_true_bearings_are_those_of_geodesics_to_positions_ahead(
    origin: tuple[float, float], place: tuple[float, float]
) -> None:
    """10 m ahead and astern on the map, by the inverse geodesic: 15 nm of its rounding are 1e-9 rad. The earth curves by up to
    0.9 % less than the sphere (at the poles), and so does c / sin(c) - 1 = c^2 / 6; half of that is the angle's error."""
    bearing = np.linspace(0.0, 2.0 * np.pi, 25)[:-1]
    step = 10.0 * np.stack([np.sin(bearing), np.cos(bearing)], axis=-1)
    here = np.broadcast_to(place, step.shape)
    behind, ahead = (geographic_from_map(here + each, origin) for each in (-step, step))
    middle = geographic_from_map(here, origin)
    to, _, _ = Geod(ellps="WGS84").inv(middle[:, 1], middle[:, 0], ahead[:, 1], ahead[:, 0])
    back, _, _ = Geod(ellps="WGS84").inv(middle[:, 1], middle[:, 0], behind[:, 1], behind[:, 0])
    expected = np.deg2rad(to) + wrap_angle(np.deg2rad(back) + np.pi - np.deg2rad(to)) / 2.0  # without what the way curves
    tolerance = 2e-9 + 0.009 * (np.hypot(*place) / 6.371e6) ** 2 / 12.0
    true = true_bearing(bearing, here, origin)
    assert np.abs(wrap_angle(true - expected)).max() < tolerance
    assert np.abs(wrap_angle(map_bearing(true, here, origin) - bearing)).max() < 1e-12


def test_true_north_turns_by_the_sine_of_the_latitude() -> None:
    """100 km to the east at 50 N: the first term of the series of the convergence, tan(latitude) s / N; the next one is below
    (s / N)^3."""
    n = 6_378_137.0 / math.sqrt(1.0 - 0.00669438 * math.sin(math.radians(50.0)) ** 2)
    turned = float(true_bearing(0.0, np.array([100e3, 0.0]), (50.0, -1.0)))
    assert turned == pytest.approx(math.tan(math.radians(50.0)) * 100e3 / n, abs=(100e3 / n) ** 3)
