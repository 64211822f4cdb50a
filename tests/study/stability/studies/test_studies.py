"""The short modules of study/stability/studies, each under its name."""

import numpy as np
import pytest

from radar_service.study.stability.studies.motion_and_time import moving_error
from radar_service.study.stability.studies.propagation_limits import min_grazing, two_ray_db
from tests.study.stability.run import EARTH, WAVELENGTH, finding_of


# azimuth: studies of azimuth, against theory.
def test_loss_between_spokes_is_that_of_the_pattern() -> None:
    """The engine is within 0.1 dB (its kernel) of 40 log10 sinc(0.4429 step / beam), where the loss is below 14 dB."""
    finding = finding_of("narrow_beam")
    pairs = list(zip(finding.values, finding.curve("loss of the strongest spoke"), strict=True))
    for ratio, loss in pairs:
        if loss < 14.0:
            expected = -40.0 * np.log10(np.sinc(0.442946470689452 / ratio))
            assert loss == pytest.approx(expected, abs=0.1)


# motion_and_time: studies of motion and time, against theory.
def test_a_target_may_move_far_between_spokes() -> None:
    """24 spokes for each scan at 24 rpm and 1400 kn: 75 m from spoke to spoke, 1.2 km in sixteen. The error stays below -50
    dB, as for all moving echoes."""
    assert moving_error(720.0, azimuths=24) < -50.0


# propagation_limits: studies of propagation, against worked values.
def test_flat_and_curved_two_ray_agree_with_worked_values() -> None:
    """Worked by hand at 9.41 GHz, heights 15 and 10 m, rho = -1: at 20 km -5.35 dB over 4/3 earth, 11.97 dB over a flat
    earth. The coefficient of the sea (0.998 at half a degree) changes F^4 by 0.03 dB."""
    flat, curved = two_ray_db(np.array([20_000.0]))
    assert flat[0] == pytest.approx(11.97, abs=0.05)
    assert curved[0] == pytest.approx(-5.35, abs=0.05)


def test_last_quarter_wavelength() -> None:
    """Path difference over 4/3 earth by a search of the shortest reflected path in extended precision: a quarter wavelength
    at the boundary. The tolerance of 1 % is that of linear interpolation in the grid of 250 m."""
    ground = finding_of("horizon").boundary
    assert ground is not None
    x = np.linspace(0.0, ground, 2_000_001).astype(np.longdouble)
    drop = x**2 / (2 * np.longdouble(EARTH))
    foot, far = np.hypot(x, 15.0 + drop), ground - x
    total = np.longdouble(ground) ** 2 / (2 * np.longdouble(EARTH))
    excess = (foot + np.hypot(far, 10.0 - total + drop)).min() - np.hypot(ground, 10.0 - total - 15.0)
    assert float(excess) == pytest.approx(WAVELENGTH / 4.0, rel=0.01)


def test_min_grazing_angle() -> None:
    """(0.031859 / (2 pi 8 494 667))^(1/3) by hand: 5.969e-10^(1/3) = 8.42e-4 rad."""
    assert min_grazing(WAVELENGTH, EARTH) == pytest.approx(8.42e-4, abs=5e-7)


# pulse: studies of pulse compression, against theory.
def test_a_transform_without_padding_wraps_targets_to_the_near_end() -> None:
    """A target at 602 m of 600 wraps whole (0 dB within half a bin); the engine stays below -60 dB throughout."""
    finding = finding_of("far_end")
    beyond = np.array(finding.values) > 602.0
    assert (finding.curve("transform without padding")[beyond] > -1.0).all()
    assert (finding.curve("the engine") < -60.0).all()


def test_errors_of_the_engine_stay_below_a_buoy_sixty_decibels_down() -> None:
    """Largest error in any cell, against the closed form: below -70 dB of the peak at rest, below -60 dB moving."""
    finding = finding_of("dynamic_range")
    assert finding.curve("error of the engine, ship at rest")[0] < -10.0
    assert finding.curve("error of the engine, ship moving")[0] < 0.0


# sampling: studies of sampling, against theory.
@pytest.mark.parametrize("name", ["missed_targets", "missed_sizes"])
def test_missed_targets_follow_the_binomial_law(name: str) -> None:
    """200 azimuths each: within 4 standard deviations of the law at eight ranges and ten sizes (one false alarm in 2000)."""
    finding = finding_of(name)
    law = finding.curve("binomial law")
    spread = np.sqrt(np.maximum(law * (1.0 - law), 1e-4) / 200)
    assert (np.abs(finding.curve("measured") - law) < 4.0 * spread).all()


# tracing: studies of ray tracing, against theory.
def test_single_precision_of_a_range_is_half_a_unit_in_its_last_place() -> None:
    """From 2^k m to 2^(k+1) m the unit is 2^(k-23) m, so the phase error is at most 360 x 2^(k-23) / lambda degrees. The
    largest of 2000 draws is within 1 % of it."""
    finding = finding_of("float32_range")
    bound = 360.0 * np.array(finding.values) * 2.0**-23 / WAVELENGTH
    assert (finding.curve("float32") <= bound).all()
    assert (finding.curve("float32") >= 0.99 * bound).all()
    assert (finding.curve("the engine, float64") < 1e-6).all()


def test_the_watertight_test_meets_every_triangle_and_embree_those_from_a_millimetre() -> None:
    """The watertight test meets every triangle from 1 um to 100 km; Embree meets all from 1 mm, at 1 km."""
    for name in ("triangle_size", "sliver_width"):
        assert (finding_of(name).curve("watertight") == 0.0).all()
    sizes = np.array(finding_of("triangle_size").values)
    assert (finding_of("triangle_size").curve("Embree")[sizes >= 1e-3] == 0.0).all()
