"""Two-ray multipath through the whole engine: levels and phase against a reference that finds the reflection point by search."""

from types import MappingProxyType
from typing import Any

import numpy as np
import pytest
from scipy.special import i0e

import radar_service as rs
from tests.reference.reflecting_ground import WAVELENGTH, angles, factor, reflection, water
from tests.scenes import point, scene

EARTH = 4 / 3 * 6_371_000.0
RADAR = {"azimuths": 8, "beamwidth_deg": 60, "beamwidth_el_deg": 180, "bandwidth_hz": 5e6, "height_m": 15.0}


def measured_factor(
    distance: float, rcs_dbsm: float = 10.0, sea_state: int = 0, radar: Any = MappingProxyType({})
) -> complex:
    """F^2 of a point 10 m high: the engine's field with the sea over that without, at the loudest sample."""
    fields = []
    for multipath in (True, False):
        environment = {"multipath": multipath, "sea_state": sea_state if multipath else 0}
        settings = {**RADAR, "range_max_m": distance + 400, **radar}
        made = scene([point("t", 0, distance, 10.0, rcs_dbsm)], radar=settings, environment=environment)
        fields.append(rs.Simulator(made).scan().field[0].astype(complex))
    loudest = np.argmax(np.abs(fields[1]))
    return complex(fields[0][loudest] / fields[1][loudest])


def reference_factor(distance: float, polarization: str, wave_height: float) -> complex:
    """F^2, the reflected ray of the plain reference reduced by Miller-Brown roughness."""
    path: Any = distance, 10.0, 15.0, [water(distance)], EARTH
    place = reflection(*path)
    assert place is not None
    g = 4 * np.pi * wave_height * np.sin(angles(place[0], distance, 10.0, 15.0, 0.0, EARTH)[0]) / WAVELENGTH
    return (1 + (factor(*path, polarization) - 1) * float(i0e(g**2 / 2))) ** 2


def db(factor: complex) -> float:
    return float(20 * np.log10(abs(factor)))


@pytest.mark.sample(3)
@pytest.mark.parametrize(
    ("polarization", "sea_state", "distances"),
    [
        ("h", 0, (1000.0, 2500.0, 6000.0, 12_000.0, 20_000.0)),
        ("v", 0, (1000.0, 2500.0, 6000.0, 12_000.0, 20_000.0)),
        ("h", 3, (1000.0, 2500.0)),
        ("v", 3, (1000.0,)),
        ("h", 5, (1500.0,)),
    ],
)
def test_both_polarizations_and_every_sea(polarization: str, sea_state: int, distances: tuple[float, ...]) -> None:
    """Level to 0.1 dB and phase to 1 degree of the reference, away from deep nulls; the permittivity's three digits move F by
    0.2 %. Wave heights: a quarter of 0, 1.0445 and 2.9765 m, 0.04 + 0.1 s^2.1."""
    rms = {0: 0.0, 3: 1.0445 / 4, 5: 2.9765 / 4}[sea_state]
    for distance in distances:
        computed = measured_factor(distance, 100.0, sea_state, radar={"polarization": polarization})
        exact = reference_factor(distance, polarization, rms)
        assert db(computed) == pytest.approx(db(exact), abs=0.1), distance
        assert abs(np.rad2deg(np.angle(computed / exact))) < 1.0, distance


def test_the_first_null() -> None:
    """At 8037.0 m, and not at the 9416.5 m of a flat sea: F^4 there below -35 dB (required), the least within a metre of
    it."""
    positions = 8037.0 + np.array([-200.0, -1.0, 0.0, 1.0, 200.0])
    levels = [db(measured_factor(p)) for p in positions]
    assert levels[2] < -35.0
    assert levels[0] > levels[2] + 3 and levels[4] > levels[2] + 3
    assert db(measured_factor(9416.5)) > 0.0


def test_a_narrow_beam_tilted_up_receives_less_of_the_reflected_ray() -> None:
    """A vertical beam of 2 degrees tilted up by 1.5: at 1 km the direct ray leaves 0.29 degrees down, the reflected one 1.43,
    and |F - 1| is the root of the ratio of their one-way power gains."""
    radar = {"beamwidth_el_deg": 2.0, "tilt_deg": 1.5, "pattern": "gaussian"}
    factor = measured_factor(1000.0, radar=radar)
    down = np.rad2deg(np.arctan2(25.0, 1000.0))
    level = np.rad2deg(np.arctan2(5.0 + 1000.0**2 / (2 * EARTH), 1000.0))
    share = 2.0 ** (-2 * ((down + 1.5) ** 2 - (level + 1.5) ** 2) / 4.0)  # root of ratios of 16^(-(t / 2)^2)
    assert abs(np.sqrt(factor) - 1) == pytest.approx(share, rel=0.03)  # |Gamma| 0.99, D 0.99
