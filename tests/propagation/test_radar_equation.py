"""Levels through the whole engine: the radar equation from minimum range to horizon, what each setting changes, R^-4."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import radar_service as rs
from radar_service.numerics.frames import Polar, polar_from_map
from radar_service.propagation.radar_equation import (
    radar_two_rays,
    received_amplitude,
)
from tests.reference.point_scene import error_db, exact_field, scattered
from tests.scenes import point, scene

WIDE = {"azimuths": 90, "beamwidth_deg": 10}
LONG = {**WIDE, "bandwidth_hz": 5e6, "range_max_m": 30_000}


def db(power: Any) -> Any:
    return 10 * np.log10(power)


def energy(bodies: list[dict[str, Any]], radar: dict[str, Any], seed: int = 0, **sections: Any) -> float:
    """Energy along range of the azimuth that looks north: it does not depend on where between two samples an echo stands."""
    made = scene(bodies, radar=radar, **sections)
    return float(np.sum(np.abs(rs.Simulator(made, seed=seed).scan().field[0].astype(complex)) ** 2))


@pytest.mark.parametrize("distance", [3.0, 20.0, 150.0, 1000.0, 4321.0, 15_000.0, 28_900.0])
def test_the_radar_equation_from_the_minimum_range_to_the_horizon(distance: float) -> None:
    """Our field projected on the exact one: 0.1 dB (required) of the absolute level, from near the foot of the mast to just
    before the horizon of 28 998 m (15 and 10 m high)."""
    settings = LONG if distance > 5000 else {**WIDE, "range_max_m": 5000}
    made = scene([point("t", 0, distance, 15.0 if distance < 100 else 10.0)], radar=settings)
    scan = rs.Simulator(made).scan()
    exact = exact_field(made, scan)
    assert np.abs(exact).max() > 0
    level = np.vdot(exact, scan.field) / np.vdot(exact, exact)
    assert abs(2 * db(np.abs(level))) < 0.1
    assert abs(np.rad2deg(np.angle(level))) < 1.0


@pytest.mark.parametrize(
    ("radar", "environment", "change_db", "tolerance_db"),
    [
        ({"power_w": 50e3}, {}, 3.0103, 1e-4),
        ({"gain_dbi": 33.0}, {}, 6.0, 1e-4),
        ({"loss_db": 2.5}, {}, -2.5, 1e-4),
        ({"frequency_hz": 3.05e9}, {}, 20 * np.log10(9.41 / 3.05), 1e-4),
        ({}, {"gas_db_per_km": 0.1}, -2.0, 1e-4),
        ({}, {"gas_db_per_km": "itu"}, -2 * 10 * 0.01327, 0.006),  # P.676-12 line sum; the older annex errs by 2 %
        ({}, {"rain_mm_h": 16}, -2 * 10 * 0.332, 0.011),  # half the table's last digit, twice 10 km
        ({"polarization": "v"}, {"rain_mm_h": 16}, -2 * 10 * 0.274, 0.011),
        ({}, {"rain_mm_h": 50}, -2 * 10 * 1.443, 0.011),
        ({"tilt_deg": 12.5}, {}, 2 * -3.0103, 0.03),  # the point lies 0.057 degrees under the horizontal: 0.02 dB
    ],
)  # fmt: skip
def test_each_setting_moves_the_power_by_what_it_should(
    radar: dict[str, Any], environment: dict[str, Any], change_db: float, tolerance_db: float
) -> None:
    """One point at 10 km, so loud that rain's own echo lies 70 dB under it; 1e-4 dB is the float32 of the field."""
    bodies, flat = [point("t", 0, 10_000.0, rcs_dbsm=100)], {"earth": "flat"}
    settings = {**WIDE, "bandwidth_hz": 5e6, "range_max_m": 11_000}
    powers = []
    for more, surroundings in (({}, flat), (radar, flat | environment)):
        scan = rs.Simulator(scene(bodies, radar=settings | more, environment=surroundings)).scan()
        cell = int(10_000.0 / scan.range_step)
        powers.append(float(scan.power[0, cell - 3 : cell + 4].max()))
    before, after = powers
    assert db(after / before) == pytest.approx(change_db, abs=tolerance_db)


def test_noise_figure_moves_the_noise() -> None:
    """3 dB more noise figure, 3 dB more noise: the same draws, so to float32."""
    levels = []
    for figure in (4.0, 7.0):
        made = scene(radar={**WIDE, "range_max_m": 500, "noise_figure_db": figure}, environment={"noise": True})
        levels.append(rs.Simulator(made).scan().power.astype(float).mean())
    assert db(levels[1] / levels[0]) == pytest.approx(3.0, abs=1e-4)


@pytest.mark.parametrize("seeds", [1, pytest.param(3, marks=pytest.mark.study)])
@pytest.mark.parametrize(
    "body",
    [
        {"shape": "box", "length_m": 2, "width_m": 2, "height_m": 2, "material": "concrete", "scattering": "diffuse"},
        {"shape": "hull", "length_m": 60, "beam_m": 12, "height_m": 12, "rcs_dbsm": 20},
    ],
    ids=["diffuse box", "declared hull"],
)
def test_mean_power_of_a_compact_mesh_falls_as_r_to_the_fourth(body: dict[str, Any], seeds: int) -> None:
    """60 of them round the antenna: energy along range x R^4 is the same from 500 m to 20 km. The mean of 60 draws of one
    speckle (exponential, or narrower) errs by 1 / sqrt(60); between two distances 5 sigma sqrt(2): 91 %, which is 2.8 dB
    (1.8 dB of 180 draws), where an error of one power of R over 500 m to 20 km would be 16 dB. The level is that of a point of
    its size."""
    draws = 60 * seeds
    radar = {"azimuths": 60, "coarse_azimuths": True, "beamwidth_deg": 1.5, "beamwidth_el_deg": 90, "pattern": "gaussian",
             "bandwidth_hz": 5e6, "pulse_s": 2e-6, "height_m": 15}  # fmt: skip
    means = []
    for distance in (500.0, 5000.0, 20_000.0):
        angles = np.deg2rad(np.arange(0, 360, 6))
        bodies = [
            {
                **body,
                "name": f"b{i}",
                "position_m": [distance * np.sin(a), distance * np.cos(a), 14.0],
                "heading_deg": 6.0 * i,
            }
            for i, a in enumerate(angles)
        ]
        made = scene(bodies, radar={**radar, "range_max_m": distance + 500}, environment={"earth": "flat"})
        fields = [rs.Simulator(made, seed=s).scan().field for s in range(seeds)]
        means.append(np.mean([np.sum(np.abs(f) ** 2, axis=1, dtype=float) for f in fields]) * distance**4)
    assert np.ptp(db(np.array(means))) < db(1 + 5 * np.sqrt(2 / draws))
    made = scene([point("t", 0, 5000, 15, 0)], radar={**radar, "range_max_m": 5500}, environment={"earth": "flat"})
    unit = np.sum(np.abs(rs.Simulator(made).scan().field[0].astype(complex)) ** 2) * 5000.0**4
    gamma = scene([{**body, "name": "b"}]).bodies[0].material.gamma
    section = 100.0 if "rcs_dbsm" in body else gamma * 4.0  # gamma cos(i) A of the side that faces
    assert np.mean(means) / unit == pytest.approx(section, rel=5 / np.sqrt(3 * draws))


def aperture_beam(weights: dict[float, float]) -> Callable[[Any, float], Any]:
    """One-way power gain of an aperture with the taper sum of w cos(2 pi n x / a), from its own width by bisection."""

    def field(u: Any) -> Any:
        total = 0.0
        for n, w in weights.items():
            total = total + w * (np.sinc(u - n) + np.sinc(u + n)) / 2
        return total / sum(w * np.sinc(n) for n, w in weights.items())

    low, high = 0.1, 1.5
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if field(middle) ** 2 > 0.5 else (low, middle)

    def beam(offset: Any, beamwidth: float) -> Any:
        wrapped = np.angle(np.exp(1j * offset))
        return field(2 * low * wrapped / beamwidth) ** 2

    return beam


BEAMS = {
    "cosine": aperture_beam({0.5: 1.0}),
    "cosine2": aperture_beam({0: 0.5, 1: 0.5}),
    "gaussian": lambda offset, width: 16.0 ** (-((np.angle(np.exp(1j * offset)) / width) ** 2)),
}


@pytest.mark.parametrize("pattern", BEAMS)
@pytest.mark.parametrize("radar", [WIDE, {"azimuths": 360, "beamwidth_deg": 1.2}], ids=["wide", "a step wide"])
def test_every_aperture_round_the_full_circle(pattern: str, radar: dict[str, Any]) -> None:
    """Points at rest, sidelobes all round, elevation pattern and tilt: -70 dB (the azimuth kernel errs by -78 for a uniform
    aperture; the grid is as much finer as these are longer)."""
    settings = {
        **radar,
        "pattern": pattern,
        "range_max_m": 1500,
        "bandwidth_hz": 20e6,
        "tilt_deg": 3,
        "beamwidth_el_deg": 15,
    }
    made = scene(scattered(6, 60, 1400, 4), radar=settings)
    assert error_db(made, rs.Simulator(made).scan(), BEAMS[pattern]) < -70


def test_a_table_is_the_vertical_pattern_where_it_is_given() -> None:
    """3 dB down at 7.5 degrees either side of the tilt: a point that far above it loses 2 x 3 dB."""
    height = 1000 * np.tan(np.deg2rad(10))
    bodies = [point("t", 0, 1000, 15 + height)]
    radar = {**WIDE, "range_max_m": 1500, "tilt_deg": 2.5}
    flat = {"earth": "flat"}
    isotropic = energy(bodies, radar | {"pattern_el": [[0, 0], [180, 0]]}, environment=flat)
    shaped = energy(bodies, radar | {"pattern_el": [[0, 0], [7.5, -3], [20, -30]]}, environment=flat)
    assert db(shaped / isotropic) == pytest.approx(-2 * 3.0, abs=1e-3)


LAMBDA = 299_792_458.0 / 9.41e9
FLAT = {"earth": "flat"}
GAUSSIAN = {"pattern_el": "gaussian", "beamwidth_el_deg": 4.0, "tilt_deg": 1.0, "height_m": 15}


def toward(distance: float, height: float) -> tuple[Polar, Any]:
    """A position north of an antenna 15 m up over a flat earth, and its height (1,)."""
    position = np.array([[0.0, distance, height]])
    return polar_from_map(position, np.array([0.0, 0.0, 15.0]), np.inf), position[:, 2]


def gaussian_gain(elevation_deg: float) -> float:
    """One-way power gain of the Gaussian beam of 4 degrees tilted up by 1."""
    return float(16.0 ** (-(((elevation_deg - 1.0) / 4.0) ** 2)))


def test_the_received_amplitude_is_the_root_of_the_radar_equation() -> None:
    """25 kW, 30 dBi, 31.859 mm, 3 dB loss, 1 m^2 at 1 and 4 km; at ranges below range_min the level of range_min."""
    made = scene(radar={"power_w": 25e3, "gain_dbi": 30, "loss_db": 3, "range_min_m": 20}).radar
    power = received_amplitude(made, np.array([1000.0, 4000.0, 20.0, 5.0, 0.0])) ** 2
    by_hand = 25e3 * 1e6 * LAMBDA**2 / ((4 * np.pi) ** 3 * 10**0.3)
    np.testing.assert_allclose(power, by_hand / np.array([1000.0, 4000.0, 20.0, 20.0, 20.0]) ** 4, rtol=1e-12)


@pytest.mark.parametrize("polarization", ["h", "v"])
@pytest.mark.parametrize("tilt_error_deg", [0.0, 1.5])
def test_two_rays_have_the_gains_of_their_own_elevations(polarization: str, tilt_error_deg: float) -> None:
    """Fields of direct and reflected ray by hand over a flat smooth sea of 55.3 - j38.2, each with the root of its own one-way
    gain. 3e-3: three digits of the permittivity."""
    made = scene(radar=GAUSSIAN | {"polarization": polarization}, environment=FLAT | {"multipath": True})
    for distance in (700.0, 1234.5, 3000.0):
        direct, reflected = np.hypot(distance, 5.0), np.hypot(distance, 25.0)
        grazing = np.arctan2(25.0, distance)
        sine, refracted = np.sin(grazing), np.sqrt(55.3 - 38.2j - np.cos(grazing) ** 2)
        weight = 1.0 if polarization == "h" else 55.3 - 38.2j
        gamma = (weight * sine - refracted) / (weight * sine + refracted)
        gains = [gaussian_gain(float(np.rad2deg(-np.arctan2(h, distance))) + tilt_error_deg) for h in (5.0, 25.0)]
        site = (np.array([distance]), np.array([10.0]), 15.0)
        rays = radar_two_rays(made.radar, made.environment, *site, np.deg2rad(tilt_error_deg))
        assert rays.gain[0] == pytest.approx(gains[0], abs=3e-6)
        assert rays.ratio[0] == pytest.approx(gamma * np.sqrt(gains[1] / gains[0]) * direct / reflected, abs=3e-3)
        assert rays.geometry.excess[0] == pytest.approx((25.0**2 - 5.0**2) / (direct + reflected), rel=1e-12)
