"""Diffraction over a smooth sea: against a contour integral and P.526, joined to the two rays, and through the whole engine."""

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import radar_service as rs
from radar_service.bench.detection.detection import Target, signal_to_noise
from radar_service.echo.sea_paths import Paths, sea_paths
from radar_service.propagation.diffraction import diffraction_height, series_field
from radar_service.propagation.multipath import specular_geometry
from radar_service.propagation.radar_equation import radar_two_rays, received_amplitude
from radar_service.propagation.sea_surface import sea_water_permittivity
from radar_service.receive.compression import receiver_noise_power
from radar_service.scattering.model import ALL_PATHS
from radar_service.scattering.models import height_over_horizon
from radar_service.truth.truth_file import scene_hash
from radar_service.world.error import SceneError
from tests.reference.smooth_sea import EARTH, LIGHT, contour_field, recommended_loss_db
from tests.scenes import point, scene

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]

SEA = {"multipath": True, "diffraction": True}
RADAR = {  # 200 bins of 150 m, 64 spokes
    "azimuths": 64, "beamwidth_deg": 12, "beamwidth_el_deg": 20, "height_m": 15, "range_max_m": 30_000,
    "modulation": "none", "pulse_s": 4e-6, "sample_rate_hz": 1e6, "rpm": 60,
}  # fmt: skip
PLACES = [
    (3.0, 2.0, 0.4),
    (2.1, 2.0, 0.4),
    (1.8, 2.0, 0.4),
    (5.0, 2.0, 2.0),
    (5.0, 8.0, 8.0),
    (9.0, 20.0, 20.0),
    (3.0, 0.0, 1.0),
]


def field(made: rs.Scene, distance: Floats, height: Floats | float, antenna_height: Floats | float) -> Complexes:
    """One-way field over the direct ray's, as the engine has it, without the elevation pattern."""
    heights, antennas = (np.broadcast_to(np.asarray(each, dtype=float), distance.shape) for each in (height, antenna_height))
    rays = radar_two_rays(made.radar, made.environment, distance, heights, antennas)
    phase = np.exp(-2j * np.pi / made.radar.wavelength * rays.geometry.excess)
    return np.where(rays.arrives, 1.0 + rays.ratio * phase, 0.0)


def over_sea(frequency: float = 9.41e9, polarization: str = "h", **environment: Any) -> rs.Scene:
    """A radar with a beam so wide that it weighs both rays alike."""
    beam = {"beamwidth_el_deg": 90, "frequency_hz": frequency, "polarization": polarization}
    return scene([], radar={**RADAR, **beam}, environment={**SEA, **environment})


def units(frequency: float) -> tuple[float, float, float]:
    """Natural units of distance and height [m], and m, by their definition."""
    k = 2.0 * np.pi * frequency / LIGHT
    m = (k * EARTH / 2.0) ** (1.0 / 3.0)
    return EARTH / m, m / k, m


def horizon_of(*heights: float) -> float:
    return float(sum(np.sqrt(2.0 * EARTH * np.array(heights))))


@pytest.mark.sample(3)
@pytest.mark.parametrize("polarization", ["h", "v"])
@pytest.mark.parametrize("frequency", [9.41e9, 3.05e9])
def test_the_series_is_the_contour_integral(frequency: float, polarization: str) -> None:
    """In the shadow, at the horizon and in front of it, to what both round: 1e-6."""
    along, up, m = units(frequency)
    permittivity = np.conj(sea_water_permittivity(frequency))
    q = 1j * m * np.sqrt(permittivity - 1.0) / (permittivity if polarization == "v" else 1.0)
    x, first, second = np.array(PLACES).T
    found = series_field(x * along, second * up, first * up, LIGHT / frequency, EARTH, polarization)
    np.testing.assert_allclose(found, [contour_field(*place, q) for place in PLACES], rtol=1e-6)


@pytest.mark.parametrize("polarization", ["h", "v"])
def test_the_recommendation_agrees_beyond_the_horizon(polarization: str) -> None:
    """P.526 has the first mode with fitted height gains: within 0.8 dB one way from a natural distance beyond the horizon on (400
    draws had 0.78 dB at most; 2.6 dB at the horizon itself)."""
    along, up, _ = units(9.41e9)
    permittivity = sea_water_permittivity(9.41e9)
    conductivity = -permittivity.imag * 9.41e9 * 2.0 * np.pi * 8.854e-12
    for first, second in ((2.0, 0.4), (2.0, 2.0), (8.0, 8.0), (3.0, 25.0)):
        x = np.sqrt(first) + np.sqrt(second) + np.array([1.0, 2.0, 3.0])
        heights = np.full(3, first * up), np.full(3, second * up)
        found = series_field(x * along, heights[1], heights[0], LIGHT / 9.41e9, EARTH, polarization)
        for distance, value in zip(x * along, found, strict=True):
            loss = recommended_loss_db(
                distance, first * up, second * up, 9.41e9, permittivity.real, conductivity, polarization
            )
            assert loss == pytest.approx(-20.0 * np.log10(abs(value)), abs=0.8)


@pytest.mark.sample(2)
@pytest.mark.parametrize("polarization", ["h", "v"])
@pytest.mark.parametrize("frequency", [3.05e9, 9.41e9, 24e9])
def test_neither_the_field_nor_its_slope_has_a_step(frequency: float, polarization: str) -> None:
    """From before the joint to past the horizon: on a grid twice as fine the largest difference halves and the largest second
    difference falls to a quarter. A step would leave the first as it is, a kink would halve the second."""
    made = over_sea(frequency, polarization)
    for antenna, target in ((15.0, 2.0), (4.0, 0.3), (30.0, 30.0), (2.0, 60.0), (15.0, 0.05)):
        start, end = (antenna + target) * units(frequency)[2] / 5.0, 1.6 * horizon_of(antenna, target)  # m sin(grazing) < 5
        fields = [field(made, np.linspace(start, end, n), target, antenna) for n in (2_001, 4_001)]
        first, second = ([np.abs(np.diff(each, order)).max() for each in fields] for order in (1, 2))
        assert first[0] / first[1] == pytest.approx(2.0, abs=0.1)
        assert second[0] / second[1] > 3.0


def test_where_they_are_joined_the_two_rays_are_nearly_right() -> None:
    """m sin(grazing) from 1.5 to 2: the series is exact, and the joined field errs by 0.03 at most, and fields reach 2."""
    made = over_sea()
    _, _, m = units(9.41e9)
    for antenna, target in ((15.0, 2.0), (5.0, 5.0), (20.0, 60.0), (100.0, 100.0)):
        distance = np.linspace(0.05, 1.0, 4000) * horizon_of(antenna, target)
        grazing = m * np.sin(specular_geometry(distance, target, antenna, EARTH).grazing)
        distance = distance[(grazing > 1.5) & (grazing < 2.0)]
        exact = series_field(
            distance, np.full(len(distance), target), np.full(len(distance), antenna), made.radar.wavelength, EARTH, "h"
        )
        assert len(distance) > 20
        assert np.abs(field(made, distance, target, antenna) - exact).max() < 0.03


def test_antenna_and_target_can_be_exchanged() -> None:
    """Also where both methods are mixed, to the rounding of the reflection point (its error enters in second order)."""
    made, distance = over_sea(), np.linspace(5e3, 60e3, 500)
    np.testing.assert_allclose(field(made, distance, 3.0, 20.0), field(made, distance, 20.0, 3.0), rtol=0, atol=1e-3)


def test_higher_targets_have_a_horizon() -> None:
    """30 natural units: 143 m in X band. Below the sea, nothing is visible either way."""
    made = over_sea()
    limit = diffraction_height(made.radar, made.environment)
    assert limit == pytest.approx(30.0 * units(9.41e9)[1], rel=1e-6)
    distance = np.full(2, 1.05 * horizon_of(15.0, limit))
    low, high = np.abs(field(made, distance, np.array([0.999, 1.001]) * limit, 15.0))
    assert low > 0.05 and high == 0.0
    assert diffraction_height(made.radar, scene([]).environment) == 0.0


def peak(made: rs.Scene) -> tuple[float, float]:
    """The highest power of the first scan, and the time of its spoke."""
    scan = rs.Simulator(made, fidelity="reference").scan()
    spoke, _ = np.unravel_index(np.argmax(scan.power), scan.power.shape)
    return float(scan.power[spoke].max()), float(scan.time[spoke])


def expected_power(made: rs.Scene, distance: Floats, height: float) -> Floats:
    """The radar equation for 40 dBsm on boresight times |F|^4 (1,), from 15 m; elevations: within 0.2 of 20 degrees."""
    slant = np.hypot(distance, height - 15.0 - distance**2 / (2.0 * EARTH))
    one_way = np.abs(field(made, distance, height, 15.0))
    return np.asarray(received_amplitude(made.radar, slant) ** 2 * 1e4 * one_way**4)


def test_a_point_sails_over_the_horizon_without_a_step() -> None:
    """Before the joint, on both sides of the horizon of 21.8 km, and beyond: each run has the power of the radar equation.
    Spokes and samples lose 0.1 dB of it, for all alike to 0.02 dB."""
    lost = []
    for north in 14_960.0 + LIGHT / 2e6 * np.array([0, 45, 46, 73]):  # whole samples apart
        under_way = point("buoy", 0.0, float(north), 2.0, rcs_dbsm=40, course_deg=0, speed_kn=60)
        made = scene([under_way], radar=RADAR, environment=SEA)
        power, time = peak(made)
        distance = np.array([north + 60.0 * 1852.0 / 3600.0 * time])
        lost.append(10.0 * np.log10(power / expected_power(made, distance, 2.0)))
    np.testing.assert_allclose(lost, -0.085, atol=0.02)


def test_resting_and_moving_echoes_are_the_same() -> None:
    """A point at rest and one that creeps at 1 mm/s, 26 km off: 0.01 dB of single precision and of the beam's table."""
    powers = [
        peak(scene([point("buoy", 0.0, 25_960.0, 2.0, **motion)], radar=RADAR, environment=SEA))[0]
        for motion in ({}, {"course_deg": 0, "speed_kn": 0.002})
    ]
    assert powers[0] > 0.0
    assert 10.0 * np.log10(powers[1] / powers[0]) == pytest.approx(0.0, abs=0.01)


def test_land_casts_its_shadow_beyond_the_horizon_too() -> None:
    """A hill 60 m high at 10 km, across the line of sight of one of two points, at rest and moving."""
    hill = {
        "name": "hill",
        "shape": "box",
        "length_m": 100,
        "width_m": 2000,
        "height_m": 60,
        "position_m": [0, 10_000, 0],
        "rcs_dbsm": -60,
    }
    for motion in ({}, {"course_deg": 90, "speed_kn": 2}):
        bodies = [hill, point("behind", 0, 26_000, 2.0, **motion), point("clear", 26_000, 0, 2.0, **motion)]
        simulator = rs.Simulator(scene(bodies, radar=RADAR, environment=SEA), fidelity="reference")
        far = simulator.scan().power[:, 160:].max(axis=1)
        assert far[16] > 0.0 and far[0] < 1e-4 * far[16]  # sidelobes of the other
        assert [body.reason for body in simulator.truth(0.0).bodies] == ["", "shadowed", ""]


def test_truth_plan_and_engine_agree_on_what_is_visible() -> None:
    """28 km off: a point, a declared and a diffuse ship, and metal by physical optics."""
    ship = {"shape": "box", "length_m": 20, "width_m": 20, "height_m": 6}
    bodies = [
        point("point", 0, 28_000, 2.0, rcs_dbsm=40),
        {**ship, "name": "declared", "position_m": [28_000, 0, 0], "rcs_dbsm": 40},
        {**ship, "name": "wood", "position_m": [0, -28_000, 0], "material": "wood", "scattering": "diffuse"},
        {**ship, "name": "metal", "position_m": [-28_000, 0, 0], "scattering": "optics"},
    ]
    simulator = rs.Simulator(scene(bodies, radar=RADAR, environment=SEA))
    assert {body.reason for body in simulator.truth(0.0).bodies} == {""}
    assert min(peak(scene([body], radar=RADAR, environment=SEA))[0] for body in bodies) > 0.0
    plan = str(simulator.plan)
    assert "always beyond the radar horizon" not in plan and "smooth-sea diffraction" in plan
    hidden = rs.Simulator(scene(bodies, radar=RADAR, environment={"multipath": True}))
    assert {body.reason for body in hidden.truth(0.0).bodies} == {"below horizon"} and hidden.scan().power.max() == 0.0
    assert str(hidden.plan).count("always beyond the radar horizon") == 4


def test_an_antenna_above_all_diffraction_has_a_horizon() -> None:
    """At 200 m in X band: engine, truth and plan agree that nothing reaches beyond it."""
    made = scene([point("buoy", 0, 80_000, 2.0)], radar={**RADAR, "height_m": 200, "range_max_m": 90_000}, environment=SEA)
    simulator = rs.Simulator(made, fidelity="reference")
    assert simulator.truth(0.0).bodies[0].reason == "below horizon" and simulator.scan().power.max() == 0.0
    assert "nothing diffracts" in str(simulator.plan)


@pytest.mark.parametrize(("earth", "frequency"), [(0.1, 1e9), (100.0, 100e9)])
def test_other_earths_yield_numbers(earth: float, frequency: float) -> None:
    """The least and the most wavelengths that an earth may have: finite, and no more than both rays in phase."""
    made = over_sea(frequency, "v", earth=earth)
    found = np.abs(field(made, np.geomspace(1.0, 3e6, 100), np.geomspace(0.01, 100.0, 100), 0.5))
    assert np.isfinite(found).all() and found.max() < 2.1


def test_an_extent_has_no_step_where_the_two_rays_end() -> None:
    """A scatterer that stands for 3 m of height: the mean over its height fades out with the two rays. Differences halve on a
    grid twice as fine."""
    made = over_sea()
    steps = []
    for count in (4001, 8001):
        distance = np.linspace(4_000.0, 26_000.0, count)
        heights, span = np.full(count, 3.0), np.full(count, 3.0)
        paths = Paths(np.full(count, ALL_PATHS), span)
        factor = sea_paths(made.radar, made.environment, (distance, heights, np.full(count, 15.0)), paths).factor()
        steps.append(np.abs(np.diff(factor)).max())
    assert steps[0] / steps[1] == pytest.approx(2.0, abs=0.1)
    distance = np.array([26_000.0])
    paths = Paths(np.array([ALL_PATHS]), np.array([3.0]))
    factor = sea_paths(made.radar, made.environment, (distance, np.array([3.0]), np.array([15.0])), paths).factor()
    assert abs(factor[0]) == pytest.approx(np.abs(field(made, distance, 3.0, 15.0)[0]) ** 2, rel=1e-5)  # of the wide beam


def test_what_rays_sample_stays_behind_its_horizon() -> None:
    wood = {"name": "wood", "shape": "box", "length_m": 20, "width_m": 20, "height_m": 6, "material": "wood"}
    made = scene([{**wood, "position_m": [0, 28_000, 0], "scattering": "diffuse"}], radar=RADAR, environment=SEA)
    assert height_over_horizon(made.bodies[0], made, "sobol") == 0.0
    assert height_over_horizon(made.bodies[0], made) == diffraction_height(made.radar, made.environment)


def test_detection_is_predicted_across_the_horizon() -> None:
    """The ratio to the noise is that of the radar equation and the field on either side of 21.8 km (elevation: 0.01 dB)."""
    made = scene([], radar=RADAR, environment={**SEA, "noise": True})
    distance = np.array([21_000.0, 21_700.0, 22_000.0, 26_000.0])
    found = signal_to_noise(made.radar, made.environment, distance, Target("t", 2.0, 40.0, 0, None))
    expected = np.array([expected_power(made, np.array([each]), 2.0)[0] for each in distance])
    np.testing.assert_allclose(10.0 * np.log10(found / expected * receiver_noise_power(made.radar)), 0.0, atol=0.01)


@pytest.mark.parametrize(
    ("environment", "message"),
    [
        ({"diffraction": True}, "environment.diffraction: true needs the sea's reflection; give multipath = true, or"),
        (
            {**SEA, "earth": "flat"},
            "environment.diffraction: true needs a round earth, not earth = flat; give 4/3, or 0.1 to 100",
        ),
        ({**SEA, "earth": 0.01}, "needs a round earth, not earth = 0.01; give 4/3, or 0.1 to 100"),
        ({**SEA, "diffraction": "yes"}, "environment.diffraction: "),
    ],
)
def test_the_key_needs_the_sea_and_a_curved_earth(environment: dict[str, Any], message: str) -> None:
    with pytest.raises(SceneError) as error:
        scene([], environment=environment)
    assert message in str(error.value)


def test_scenes_without_it_keep_their_hash() -> None:
    """The record's new field adds nothing to it while it is off."""
    sea = [{"multipath": True}, {"multipath": True, "diffraction": False}, SEA]
    first, second, third = (scene_hash(scene([], environment=each)) for each in sea)
    assert first == second != third
