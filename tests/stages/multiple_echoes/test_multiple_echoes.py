"""Multiple echoes: in a scene file, and in spokes."""

import numpy as np
import pytest

import radar_service as rs
from radar_service.echo.beam_paths import Beam, Sights
from radar_service.echo.echoes import BeamWeightedEchoes
from radar_service.propagation.radar_equation import received_amplitude
from radar_service.stages.multiple_echoes.effect import MultipleEchoes
from radar_service.stages.multiple_echoes.stage import MultiplePaths, MultipleTruth
from tests.scenes import point, radar, scene


# effect: multiple echoes in scene files: what they become, and what is refused.
def test_multiple_echoes_in_si_units() -> None:
    table = {"own_rcs_dbsm": 40, "range_m": 600, "orders": 3}
    assert radar(multiple_echoes=table).effects == {"multiple": MultipleEchoes(10_000.0, 600.0, 3)}
    assert radar().effects == {}


def test_orders_and_cross_section_have_limits() -> None:
    with pytest.raises(rs.SceneError, match="radar.multiple_echoes.orders: 5 is not allowed.*1 to 4"):
        radar(multiple_echoes={"own_rcs_dbsm": 40, "orders": 5})
    with pytest.raises(rs.SceneError, match="radar.multiple_echoes.own_rcs_dbsm: missing"):
        radar(multiple_echoes={})


# stage: multiple echoes: what own ship throws back to ships near by, against the radar equation.
MULTIPLE = radar(multiple_echoes={"own_rcs_dbsm": 30, "range_m": 300, "orders": 2}, pattern="gaussian")
SHIPS = np.array([True, False, True])


def multiple(distance: list[float], body: list[int], rcs: list[float], migration: float = 0.0) -> BeamWeightedEchoes:
    """What MULTIPLE makes of echoes (E,) on boresight at three azimuths, that move by `migration` [m] from one to the next."""
    count, ranges = len(distance), np.array(distance)
    moved = np.broadcast_to(migration * np.array([-1.0, 0.0, 1.0]), (count, 3)).astype(np.float32)
    amplitude = np.sqrt(rcs)[:, None] * received_amplitude(MULTIPLE, ranges[:, None] + moved)
    phase = np.exp(-4j * np.pi / MULTIPLE.wavelength * (ranges[:, None] + moved))
    echoes = BeamWeightedEchoes(ranges, moved, (amplitude * phase).astype(np.complex64), np.array(body))
    sights = Sights(np.zeros((count, 3)), np.radians([-1.0, 0.0, 1.0]), np.zeros(3))
    return MultiplePaths(MULTIPLE, MULTIPLE.effects["multiple"], Beam(MULTIPLE, None), SHIPS, -3).received(echoes, sights)


def test_a_second_trace_has_twice_the_range_the_phase_and_the_level_of_its_way() -> None:
    """A ship of 50 m^2 at 200 m: at 400 and 600 m, weaker by root(50 x 1000) / (4 pi 200^2) each time, as the beam weights it."""
    traces = multiple([200.0], [0], [50.0], migration=0.004)
    np.testing.assert_allclose(traces.range, [400.0, 600.0])
    np.testing.assert_allclose(traces.range_migration, 0.004 * np.array([[-2, 0, 2], [-3, 0, 3]]), atol=1e-9)
    weaker = np.sqrt(50.0 * 1000.0) / (4.0 * np.pi * 200.0**2)
    first = np.sqrt(50.0) * received_amplitude(MULTIPLE, np.array([200.0]))[0]
    gain = MULTIPLE.azimuth_gain(np.radians([1.0, 0.0, -1.0]))
    for n, trace in enumerate(traces.amplitude, start=1):
        np.testing.assert_allclose(np.abs(trace), first * weaker**n * gain, rtol=3e-4)  # R changes by 4 mm of 200 m
        phase = np.angle(trace * np.exp(4j * np.pi / MULTIPLE.wavelength * (200.0 + 0.004 * np.array([-1, 0, 1])) * (n + 1)))
        np.testing.assert_allclose(phase, 0.0, atol=0.02)  # 1e-5 m of range in float32, and 3e-5 m of migration
    assert set(traces.body.tolist()) == {-3}


def test_the_truth_is_that_of_the_radar_equation() -> None:
    """A ship of 60 dBsm at 500 m and 40 dBsm of own ship: 10^10 / (4 pi 500^2)^2 is -29.9 dB, once for each order."""
    table = {"own_rcs_dbsm": 40, "range_m": 600, "orders": 2}
    truth = MultipleTruth(scene([point("t", 0, 500, rcs_dbsm=60.0)], radar={"multiple_echoes": table}))
    assert [(echo.range, echo.level_db) for echo in truth.false_echoes(0, 500.0, 0.0, 0.0)] == [
        (1000.0, pytest.approx(-29.94, abs=0.01)), (1500.0, pytest.approx(-59.89, abs=0.02)),
    ]  # fmt: skip
    assert truth.false_echoes(0, 700.0, 0.0, 0.0) == []


def test_all_echoes_of_a_ship_make_one_field() -> None:
    """Two points of a ship in phase throw back twice the field of one, else nothing. Land and far ships have no such echoes."""
    half = MULTIPLE.wavelength / 2.0
    both = multiple([200.0, 200.0 + 20.0 * half], [0, 0], [50.0, 50.0])
    one = multiple([200.0], [0], [50.0])
    assert np.isclose(np.abs(both.amplitude[0, 1]), 2.0 * np.abs(one.amplitude[0, 1]), rtol=0.01)
    against = multiple([200.0, 200.0 + 20.5 * half], [0, 0], [50.0, 50.0])
    assert np.abs(against.amplitude[0, 1]) < 0.02 * np.abs(one.amplitude[0, 1])
    two_ships = multiple([200.0, 200.0 + 20.5 * half], [0, 2], [50.0, 50.0])
    np.testing.assert_allclose(two_ships.amplitude[0], one.amplitude[0], rtol=1e-5)
    assert len(multiple([200.0], [1], [50.0]).range) == 0 and len(multiple([301.0], [0], [50.0]).range) == 0
    assert len(multiple([200.0], [-1], [50.0]).range) == 0
