"""The field panel: its workload, and errors that are known beforehand."""

import numpy as np
import pytest

from radar_service.echo.echoes import Echoes
from radar_service.numerics.types import Indices, Profiles
from radar_service.radar.parameters import Radar
from radar_service.study.chart.field_panel import FLOOR_DB, field_points, relative_db, workload_of
from radar_service.study.chart.reference_surface import closed_form_field
from radar_service.study.chart.signal_chain import BLOCK, Method
from tests.scenes import radar
from tests.study.chart.settings import SMALL


def random_echoes(count: int, small: Radar) -> Echoes:
    """Returns echoes of random strength and phase."""
    rng = np.random.default_rng(5)
    amplitude = rng.standard_normal(count) + 1j * rng.standard_normal(count)
    return Echoes(rng.uniform(60.0, 1400.0, count), rng.uniform(-np.pi, np.pi, count), amplitude)


def test_the_subset_has_equal_strength_and_the_phases_of_the_echoes() -> None:
    """The strength is the root mean square of all echoes, to the rounding of 64 bits."""
    small = radar(**SMALL)
    echoes = random_echoes(30, small)
    workload = workload_of(small, echoes, 10, 2, 0)
    kept = np.flatnonzero(np.isin(echoes.range, workload.subset.range))
    assert len(workload.subset.range) == len(kept) == 10
    np.testing.assert_allclose(np.abs(workload.subset.amplitude), np.sqrt(np.mean(np.abs(echoes.amplitude) ** 2)))
    np.testing.assert_allclose(np.angle(workload.subset.amplitude), np.angle(echoes.amplitude[kept]))
    assert len(workload.timed) <= 2 * BLOCK and len(workload.scan) == small.azimuths


def test_a_field_that_is_one_per_cent_too_large_has_an_error_of_minus_forty_decibels() -> None:
    """20 log10(0.01); complex64 rounds to 1e-7. A method beside another sampling has a reference of its own."""
    small = radar(**SMALL)

    def method(factor: float, first: float, reach: float | None) -> Method:
        def run(echoes: Echoes, spokes: Indices) -> Profiles:
            field = closed_form_field(echoes, small, spokes * small.azimuth_step, made.sample_range)
            return (factor * field).astype(np.complex64)

        made = Method("family", f"{factor} {first}", run, small, first, reach)
        return made

    methods = [method(1.01, 0.5, None), method(1.1, 0.0, np.pi)]
    workload = workload_of(small, random_echoes(5, small), 5, 1, 0)
    points = field_points(workload, methods, 2)
    assert [p.error_db for p in points] == [pytest.approx(-40.0, abs=1e-3), pytest.approx(-20.0, abs=1e-3)]
    assert all(len(p.times) == 2 for p in points)


def test_errors_end_at_the_floor() -> None:
    field = np.ones(3, dtype=np.complex64)
    assert relative_db(field, np.ones(3, dtype=np.complex128)) == FLOOR_DB
