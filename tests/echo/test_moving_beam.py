"""The table of the beam against the pattern itself, and received fields against complex128."""

import numpy as np
import pytest

from radar_service.echo.moving_beam import BeamTable, received_field
from tests.reference.compressed_pulse import sinc2_beam

WIDTH = np.deg2rad(2.0)


def table(extent: float, oversampling: int = 1) -> BeamTable:
    return BeamTable(lambda offset: sinc2_beam(offset, WIDTH), WIDTH, extent, 0.05, oversampling)


@pytest.mark.parametrize("oversampling", [1, 8])
def test_the_table_errs_by_half_an_entry(oversampling: int) -> None:
    """Half an entry of 4096 to a beamwidth on the steepest slope, -74.8 dB of boresight; oversampled by eight, 18 dB less.
    A tenth more for float32, which places an offset to 0.03 entries. Both sides alike."""
    slope = np.abs(np.gradient(sinc2_beam(np.linspace(0, WIDTH, 10_001), WIDTH), WIDTH / 10_000)).max() * WIDTH
    offset = np.random.default_rng(1).uniform(-0.3, 0.3, 20_000).astype(np.float32)
    beam = table(0.4, oversampling)
    error = np.abs(beam(offset) - sinc2_beam(offset.astype(np.float64), WIDTH)).max()
    assert 0.9 < error / (slope / 2 / 4096 / oversampling) < 1.1
    np.testing.assert_array_equal(beam(offset), beam(-offset))


def test_boresight_is_one_and_beyond_the_reach_the_gain_stays() -> None:
    beam = table(0.1)
    assert beam(np.zeros(1, np.float32))[0] == 1.0
    far = beam(np.array([0.1 + 2 * 0.05 + 0.01, 1.0, -2.0], np.float32))
    assert (far == far[0]).all()


def test_an_extent_of_half_a_turn_wraps() -> None:
    """Beyond half a turn the offset is the shorter one the other way round."""
    beam = table(np.pi)
    offset = np.array([np.pi + 0.02, 2 * np.pi - 0.01], np.float32)[:1]
    assert beam(offset)[0] == pytest.approx(beam(np.float32([np.pi - 0.02]))[0], abs=10 ** (-75 / 20))


def test_fields_turn_with_range_and_its_change() -> None:
    """20 km, 8e6 rad, and up to 3 m of migration, 1200 rad: float32 phases leave 1e-4 rad; the weight multiplies."""
    rng = np.random.default_rng(2)
    middle = rng.normal(size=50) + 1j * rng.normal(size=50)
    weight, migration = rng.uniform(size=(50, 16)).astype(np.float32), rng.uniform(-3, 3, (50, 16)).astype(np.float32)
    distance = rng.uniform(10.0, 20_000.0, 50)
    way = distance[:, None] + migration.astype(np.float64)
    result = received_field(middle, distance, weight, migration, 0.0319)
    exact = middle[:, None] * weight * np.exp(-4j * np.pi / 0.0319 * way)
    assert result.dtype == np.complex64
    assert (np.abs(result - exact) <= 3e-4 * np.abs(middle)[:, None]).all()
