"""Reflectors in scenes: their echoes follow the aspect as the body turns and leans, in every path through the engine."""

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import radar_service as rs
from radar_service.scattering.models import scattering_model
from radar_service.scattering.reflector_patterns import peak_rcs, reflector_area
from radar_service.scattering.reflectors import ReflectorScattering
from tests.scenes import point, scene

RADAR = {"azimuths": 180, "beamwidth_deg": 4, "range_max_m": 1200, "rpm": 60, "pulse_s": 1e-6}
OCTAHEDRAL = {"name": "r", "shape": "reflector", "reflector": "octahedral", "edge_m": 0.3, "position_m": [0, 1000, 15]}


def peak_dbsm(body: dict[str, Any], scans: int = 1, **radar: Any) -> list[float]:
    """The peak of each scan over that of a square metre at the same place [dBsm]."""
    settings = {"radar": RADAR | radar, "environment": {"earth": "flat"}}
    reference = rs.Simulator(scene([point("p", 0, 1000, rcs_dbsm=0.0)], **settings)).scan().power.max()
    simulator = rs.Simulator(scene([body], **settings))
    return [float(10 * np.log10(scan.power.max() / reference)) for scan in (simulator.scan() for _ in range(scans))]


def expected(of: rs.Scene, direction: Any, up: Any = (0.0, 0.0, 1.0)) -> float:
    """From a unit direction and the zenith in the body's frame [dBsm]."""
    reflector, wavelength = of.bodies[0].reflector, of.radar.wavelength
    assert reflector is not None
    level: NDArray[np.float64] = np.cross(up, direction)
    level /= np.linalg.norm(level)
    area = reflector_area(reflector, np.array([direction]), level[None], wavelength)[0]
    return float(10 * np.log10(4 * np.pi * area**2 / wavelength**2))


@pytest.mark.parametrize("heading", [180.0, 197.0, 230.0])
@pytest.mark.parametrize("moving", [False, True])
def test_the_echo_follows_the_heading(heading: float, moving: bool) -> None:
    """At rest, and under way by a millimetre a second, which takes the other path through the engine: 0.02 dB, as the peak
    of a point at the same place straddles cells alike."""
    body = OCTAHEDRAL | {"heading_deg": heading} | ({"speed_kn": 0.002, "course_deg": 90} if moving else {})
    off = np.deg2rad(180.0 - heading)
    direction = np.array([np.sin(off), np.cos(off), 0.0])
    assert peak_dbsm(body)[0] == pytest.approx(expected(scene([body], radar=RADAR), direction), abs=0.02)


def test_the_echo_follows_the_roll() -> None:
    """Rolling by 20 degrees in 7 s, beam on, scan by scan: the pattern at the roll of the moment that the beam passes. A
    visibility step is 1/32 of the period, in half of which the ship rolls 2 degrees at most."""
    body = OCTAHEDRAL | {"heading_deg": 90, "roll_deg": 20, "roll_period_s": 7.0}
    of = scene([body], radar=RADAR, environment={"earth": "flat"})
    levels, law = peak_dbsm(body, 6), of.bodies[0].motion
    for scan, level in enumerate(levels):
        rotations = law.pose(np.linspace(scan - 0.12, scan + 0.12, 9)).rotation
        assert rotations is not None
        around = [expected(of, np.array([0.0, -1.0, 0.0]) @ rotation, rotation[2]) for rotation in rotations]
        assert min(around) - 0.05 <= level <= max(around) + 0.05
    assert np.ptp(levels) > 3.0


def test_the_field_tells_flashes_of_two_plates_from_lobes_of_three() -> None:
    """32 degrees off the opening a dihedral and a trihedral meet: 0.50 dBsm of a level field, 6.63 dBsm of an upright one."""
    body = OCTAHEDRAL | {"heading_deg": 212}
    assert peak_dbsm(body)[0] == pytest.approx(0.50, abs=0.02)
    assert peak_dbsm(body, polarization="v")[0] == pytest.approx(6.63, abs=0.02)


def test_a_dihedral_that_leans_turns_the_field() -> None:
    """Point-up, seen from ahead as it rolls by 20 degrees about that very line: two plates with an upright fold leave
    cos 2 psi of the field, so 20 log10 cos 2 psi. In half a visibility step, 1/64 of the period, psi changes by 2 degrees."""
    body = OCTAHEDRAL | {"hung": "point-up", "heading_deg": 180, "roll_deg": 20, "roll_period_s": 7.0}
    of = scene([body], radar=RADAR, environment={"earth": "flat"})
    upright = peak_dbsm(OCTAHEDRAL | {"hung": "point-up", "heading_deg": 180})[0]
    lost = [upright - level for level in peak_dbsm(body, 6)]
    for scan, loss in enumerate(lost):
        rotations = of.bodies[0].motion.pose(np.linspace(scan - 0.12, scan + 0.12, 9)).rotation
        assert rotations is not None
        psi = np.arcsin(np.abs(rotations[:, 2, 0]))
        around = -20 * np.log10(np.cos(2 * psi))
        assert around.min() - 0.05 <= loss <= around.max() + 0.05
    assert max(lost) > 1.0


def test_cross_sections_are_those_of_x_band_and_fall_by_the_square() -> None:
    """10 dBsm stated at 9.41 GHz, 1000 m ahead on the axis of a lens: 10 - 9.785 dB at 3.05 GHz."""
    lens = {**OCTAHEDRAL, "reflector": "lens", "rcs_dbsm": 10.0, "heading_deg": 180}
    del lens["edge_m"]
    assert peak_dbsm(lens)[0] == pytest.approx(10.0, abs=0.01)
    assert peak_dbsm(lens, frequency_hz=3.05e9)[0] == pytest.approx(10 + 20 * np.log10(3.05 / 9.41), abs=0.01)


def test_multipath_acts_as_on_a_point() -> None:
    """A lens and a point of its peak at one place have the same spokes, sea reflection, gas and rain included."""
    lens = {**OCTAHEDRAL, "reflector": "lens", "rcs_dbsm": 10.0, "heading_deg": 180, "position_m": [0, 1000, 15]}
    del lens["edge_m"]
    settings = {"radar": RADAR, "environment": {"earth": "flat", "multipath": True, "rain_mm_h": 5.0}}
    one, other = (
        rs.Simulator(scene([body], **settings)).scan().field for body in (lens, point("r", 0, 1000, rcs_dbsm=10.0))
    )
    strong = np.abs(other) > 0.3 * np.abs(other).max()
    np.testing.assert_allclose(np.abs(one)[strong], np.abs(other)[strong], rtol=1e-3)


def test_the_plan_and_the_model() -> None:
    of = scene([OCTAHEDRAL], radar=RADAR)
    assert scattering_model(of.bodies[0]) is ReflectorScattering and of.bodies[0].rcs is None
    text = str(rs.Simulator(of).plan)
    assert "octahedral reflector, legs 0.3 m, hung catch-rain, lobes of 33.4 m2 at 9.41 GHz" in text
    reflector = of.bodies[0].reflector
    assert reflector is not None and peak_rcs(reflector, of.radar.wavelength) == pytest.approx(33.4, abs=0.05)


@pytest.mark.parametrize(
    "change, message",
    [
        ({"reflector": None}, "reflector: missing"),
        ({"edge_m": None}, "edge_m: missing"),
        ({"radius_m": 0.1}, "radius_m: shape"),
        ({"rcs_dbsm": 10.0}, "edge_m: shape"),
        ({"reflector": "lens", "edge_m": None, "radius_m": 0.1, "hung": "point-up"}, "hung: a lens"),
        ({"scattering": "optics"}, "scattering: a reflector"),
        ({"swerling": 1}, "swerling: the pattern"),
        ({"shape": "trihedral"}, 'reflector: shape = "trihedral"'),
        ({"reflector": "cube"}, "reflector"),
    ],
)
def test_keys_that_do_not_fit(change: dict[str, Any], message: str) -> None:
    body = {key: value for key, value in (OCTAHEDRAL | change).items() if value is not None}
    with pytest.raises(rs.SceneError, match=message):
        scene([body], radar=RADAR)
