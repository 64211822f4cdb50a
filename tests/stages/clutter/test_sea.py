"""Sea clutter's physics against printed values and by hand."""

import numpy as np
import pytest

from radar_service.stages.clutter.sea import (
    SHAPE_LIMITS,
    beyond_measured_shapes,
    mean_sigma0,
    peak_wave_period,
    swell_factor,
    texture_length,
    texture_shape,
    wind_factor,
)  # fmt: skip

# Reference values of the NRL 2012 model at 9.41 GHz by sea state 0 to 6 [dB], printed to two places (origin: computed from
# the report's coefficients by an independent program and confirmed against a public implementation).
TABLE = {
    ("h", 1.0): (-66.48, -56.55, -49.38, -43.74, -39.12, -35.25, -31.98),
    ("h", 0.3): (-72.24, -61.97, -54.52, -48.63, -43.81, -39.77, -36.35),
    ("v", 1.0): (-60.71, -52.36, -46.33, -41.58, -37.69, -34.44, -31.68),
}


@pytest.mark.parametrize(("polarization", "grazing_deg"), TABLE)
def test_sigma0_is_the_table_to_the_printed_digit(polarization: str, grazing_deg: float) -> None:
    grazing = np.deg2rad(np.array([grazing_deg]))
    for sea_state, printed in enumerate(TABLE[polarization, grazing_deg]):
        level_db = 10 * np.log10(mean_sigma0(grazing, 9.41e9, sea_state, polarization)[0])
        assert round(float(level_db), 2) == printed


def test_sigma0_ends_at_the_horizon_and_holds_beyond_its_fit() -> None:
    """No sea at or below the horizon; steeper than 60 degrees as 60, higher than sea state 6 as 6."""
    at = np.deg2rad([-1.0, 0.0, 60.0, 90.0])
    sigma0 = mean_sigma0(at, 9.41e9, 6, "v")
    assert sigma0[0] == sigma0[1] == 0.0
    assert sigma0[2] == pytest.approx(sigma0[3], rel=1e-12)
    np.testing.assert_array_equal(mean_sigma0(at, 9.41e9, 9, "v"), sigma0)
    assert np.all(np.isfinite(mean_sigma0(np.array([1e-9, 1e-300]), 9.41e9, 3, "h")))


def test_unknown_polarization_is_refused() -> None:
    with pytest.raises(ValueError, match='polarization: "x" is not one of h, v'):
        mean_sigma0(np.ones(1), 9.41e9, 3, "x")


@pytest.mark.parametrize("frequency", [3.05e9, 9.41e9, 16e9])
def test_wind_factor_is_a_mean_of_one_strongest_upwind(frequency: float) -> None:
    """Mean over directions 1 to rounding (a periodic mean is exact); X band by hand at grazing 0: a = 0.2 x
    (0.03186 + 0.015)^-0.4 = 0.6802, I0(a) = 1.1191, so upwind +2.465 dB and downwind 20 a log10(e) = 5.908 dB below that."""
    angle = np.arange(64, dtype=np.float64) * (2 * np.pi / 64)
    factor = wind_factor(angle, np.deg2rad(np.array(0.5)), 299_792_458 / frequency)
    assert factor.mean() == pytest.approx(1.0, abs=1e-12)
    assert np.argmax(factor) == 0 and np.argmin(factor) == 32
    if frequency == 9.41e9:
        up, down = 10 * np.log10(wind_factor(np.array([0.0, np.pi]), np.array(0.0), 0.0318589))
        assert up == pytest.approx(2.465, abs=5e-3) and up - down == pytest.approx(
            5.908, abs=5e-3
        )  # half a printed digit x 10


def test_texture_shape_by_hand() -> None:
    """1 degree, 100 m^2: log10 nu = 5/8 x 2 - 2.09 = -0.84 (H) or -0.14 (V); 8 degrees add 2/3 log10 8 = 0.602."""
    one, eight = np.deg2rad([1.0]), np.deg2rad([8.0])
    area = np.array([100.0])
    assert np.log10(texture_shape(one, area, "h")[0]) == pytest.approx(-0.84, abs=1e-12)
    assert np.log10(texture_shape(one, area, "v")[0]) == pytest.approx(-0.14, abs=1e-12)
    assert np.log10(texture_shape(eight, area, "v")[0]) == pytest.approx(0.462060, abs=1e-6)
    assert texture_shape(np.array([-0.1, 1.5]), np.array([0.0, 1e9]), "h").tolist() == list(SHAPE_LIMITS)


def test_waves_along_the_line_of_sight_make_spikes() -> None:
    """Ward's swell term: log10 nu - 1/3 along the waves, either way, and + 1/3 across them."""
    assert np.log10(swell_factor(np.array([0.0, np.pi / 2, np.pi]))) == pytest.approx([-1 / 3, 1 / 3, -1 / 3], abs=1e-12)


def test_shapes_beyond_their_measured_cells_are_told() -> None:
    """Ward's cells are 4.2 m long, and 100 to 800 m across."""
    assert beyond_measured_shapes(4.2, (100.0, 800.0)) == ""
    told = beyond_measured_shapes(12.0, (0.2, 131.0))
    assert told == ", extrapolated to cells 12 m long (measured: 4.2 m), 0.2 to 131 m across (measured: 100 to 800 m)"


def test_texture_length_and_life_by_hand() -> None:
    """Sea state 3, wind 3.16 x 3^0.8 = 7.610 m/s: (pi/2) 57.91/9.80665 = 9.276 m across the wind and twice that along it; waves
    of 48 m and 5.56 s: 7.610/0.877 = 8.677 m/s, 2 pi 8.677/9.80665."""
    assert texture_length(np.array([0.0, np.pi / 2, np.pi]), 3) == pytest.approx([18.552, 9.276, 18.552], abs=1e-3)
    assert peak_wave_period(3) == pytest.approx(5.560, abs=1e-3)
