"""The short modules of world, each under its name."""

import math
import pickle
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import radar_service as rs
from radar_service.scene_file.load import load_scene
from radar_service.world.atmosphere import gas_attenuation_db_per_km, oxygen_db_per_km, vapour_db_per_km
from radar_service.world.body import Mesh
from radar_service.world.environment import Environment
from radar_service.world.error import SceneError
from radar_service.world.error_settings import ErrorSettings
from radar_service.world.materials import MATERIALS, material_from_name, power_reflectivity
from radar_service.world.outline import outline_of
from tests.ports.ais.test_messages import ship
from tests.scenes import point, scene


# ais: when a transponder is off.
@pytest.mark.parametrize(("time", "silent"), [(0.9, False), (1.0, True), (2.4, True), (2.5, False), (7.0, True)])
def test_it_is_off_from_the_beginning_of_a_period_to_its_end(time: float, silent: bool) -> None:
    assert ship(silent=((1.0, 2.5), (6.0, 8.0))).is_silent(time) == silent
    assert not ship().is_silent(time)


# atmosphere: gas attenuation against the line-by-line sum of ITU-R P.676-12, Annex 1.
# Frequency [GHz], oxygen and water vapour [dB/km] by P.676-12 Annex 1 at 15 C, 1013.25 hPa, 7.5 g/m3: itur 0.4.0,
# gamma0_exact and gammaw_exact.
LINE_BY_LINE = [
    (3.0, 0.0070760, 0.00046279),
    (9.41, 0.0081032, 0.0051694),
    (16.0, 0.0099908, 0.025325),
    (22.235, 0.0132927, 0.178977),
    (35.0, 0.0318430, 0.0696143),
    (50.0, 0.2772686, 0.1111585),
]


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


# environment: the environment of an empty scene: the standard earth, and no other effect.
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


# error_settings: errors in SI units.
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


# materials: materials by name.
def test_gammas_are_power_ratios_in_the_ladder_of_land() -> None:
    assert MATERIALS["sand"].gamma == pytest.approx(0.01)  # -20 dB, flat ground
    assert MATERIALS["sand"].gamma < MATERIALS["land"].gamma < MATERIALS["urban"].gamma < MATERIALS["rock"].gamma
    assert all(name == material.name and 0.0 < material.gamma <= 1.0 for name, material in MATERIALS.items())


def test_only_metals_scatter_by_optics() -> None:
    assert {name for name, material in MATERIALS.items() if material.scattering == "optics"} == {"steel", "aluminium"}


def test_unknown_material_lists_all() -> None:
    with pytest.raises(SceneError) as caught:
        material_from_name("steal", "body[2].material")
    text = str(caught.value)
    assert text.startswith('body[2].material: "steal" is not a known material; one of ')
    assert all(name in text for name in MATERIALS)


def test_every_material_has_its_reflectivity() -> None:
    """Metals all of it, nothing else half; concrete as its permittivity says: ((sqrt 5.24 - 1) / (sqrt 5.24 + 1))^2, to the
    digit its decibels are given with."""
    shares = {name: power_reflectivity(name) for name in MATERIALS}
    assert shares["steel"] == shares["aluminium"] == 1.0
    assert all(0.0 < share < 0.5 for name, share in shares.items() if MATERIALS[name].scattering != "optics")
    assert shares["concrete"] == pytest.approx(((5.24**0.5 - 1) / (5.24**0.5 + 1)) ** 2, rel=0.012)


# outline: what a service knows of a scene.
BUOY = {"name": "buoy", "shape": "point", "rcs_dbsm": 0, "position_m": [0, 100, 5], "steerable": {}}


def test_an_outline_says_what_may_be_steered_and_holds_no_bodies() -> None:
    scene = load_scene({"name": "harbour", "origin": {"latitude_deg": 50, "longitude_deg": 1}, "body": [BUOY] * 1})
    outline = outline_of(scene)
    assert (outline.name, outline.origin, outline.body_count) == ("harbour", (50, 1), 1)
    assert outline.radar is scene.radar and outline.steerable.names == {"buoy"} and outline.has_sensors
    assert pickle.loads(pickle.dumps(outline)) == outline
