"""What the studies measure, against theory: the numbers behind the boundaries."""

import json
from pathlib import Path

import numpy as np
import pytest

from radar_service.__main__ import main
from radar_service.study import stability
from radar_service.study.stability.finding import bisected, crossing
from radar_service.study.stability.path import least_grazing, two_ray_db
from radar_service.study.stability.report import page, write_report
from radar_service.study.stability.running import moving_error
from radar_service.study.stability.turning import straddling_loss_db
from radar_service.study.stability.twin import pulse_response
from tests.reference import compressed_pulse
from tests.study.stability.test_boundaries import EARTH, WAVELENGTH, found


def test_single_precision_of_a_range_is_half_a_unit_in_its_last_place() -> None:
    """2^k m to 2^(k+1) m: units of 2^(k-23) m, so the phase errs by up to 360 x 2^(k-23) / lambda degrees; 2000 draws
    come within 1 % of it."""
    finding = found("float32_range")
    bound = 360.0 * np.array(finding.places) * 2.0**-23 / WAVELENGTH
    assert (finding.curve("single precision") <= bound).all()
    assert (finding.curve("single precision") >= 0.99 * bound).all()
    assert (finding.curve("the engine") < 1e-6).all()


@pytest.mark.parametrize("name", ["missed_targets", "missed_sizes"])
def test_missed_targets_follow_the_binomial_law(name: str) -> None:
    """200 azimuths each: within 4 standard deviations of the law at all eight ranges, ten sizes (one wrong alarm in 2000)."""
    finding = found(name)
    law = finding.curve("binomial law")
    spread = np.sqrt(np.maximum(law * (1.0 - law), 1e-4) / 200)
    assert (np.abs(finding.curve("measured") - law) < 4.0 * spread).all()


def test_watertight_and_embree_do_not_lose_what_they_can_aim_at() -> None:
    """The scale-free test meets every triangle from 1 um to 100 km; Embree all from 1 mm, seen from 1 km."""
    for name in ("triangle_size", "sliver_width"):
        assert (found(name).curve("watertight") == 0.0).all()
    sizes = np.array(found("triangle_size").places)
    assert (found("triangle_size").curve("Embree")[sizes >= 1e-3] == 0.0).all()


def test_numbers_are_told_apart_where_a_browser_no_longer_can() -> None:
    """In Python to 2^63; at 2.5e18, the last place driven, doubles stand 512 apart."""
    finding = found("sequence_numbers")
    assert (finding.curve("the accumulator") == 0.0).all() and finding.curve("a browser's doubles")[-1] == 1.0


def test_a_transform_of_the_bins_alone_brings_targets_back_at_the_near_end() -> None:
    """601 m away of 600: the whole peak comes back (0 dB within half a bin); the engine keeps -60 dB throughout."""
    finding = found("far_end")
    beyond = np.array(finding.places) > 602.0
    assert (finding.curve("transform of the bins alone")[beyond] > -1.0).all()
    assert (finding.curve("the engine") < -60.0).all()


def test_the_engine_adds_less_than_a_buoy_sixty_decibels_down() -> None:
    """Against the closed form, greatest error in any cell: rest below -70 dB of the peak, moving below -60 (DESIGN 4)."""
    finding = found("dynamic_range")
    assert finding.curve("error of the engine, ship at rest")[0] < -10.0
    assert finding.curve("error of the engine, ship moving")[0] < 0.0


def test_loss_between_spokes_is_that_of_the_pattern() -> None:
    """Measured by the engine within 0.1 dB (kernel) of 40 log10 sinc(0.4429 step / beam), where the loss is below 14 dB."""
    finding = found("narrow_beam")
    pairs = list(zip(finding.places, finding.curve("loss of the loudest spoke"), strict=True))
    for ratio, loss in pairs:
        if loss < 14.0:
            by_hand = -40.0 * np.log10(np.sinc(0.442946470689452 / ratio))
            assert loss == pytest.approx(by_hand, abs=0.1) and straddling_loss_db(ratio) == pytest.approx(by_hand)
    assert straddling_loss_db(1.0) == pytest.approx(6.02, abs=0.01)  # half power each way


def test_flat_and_curved_two_ray_meet_the_worked_table() -> None:
    """values-9.41-ghz.md, h 15 and 10 m, rho = -1: at 20 km -5.35 dB over 4/3 earth and 11.97 over a flat one. The sea
    here has its own coefficient (|Gamma| 0.998 at half a degree), which moves F^4 by 0.03 dB there."""
    flat, curved = two_ray_db(np.array([20_000.0]))
    assert flat[0] == pytest.approx(11.97, abs=0.05)
    assert curved[0] == pytest.approx(-5.35, abs=0.05)


def test_last_quarter_wavelength() -> None:
    """Path difference over 4/3 earth by plain search of the shortest way by the sea, extended precision: a quarter
    wavelength at the boundary found (25 cm of distance are a thousandth of it: the grid of 250 m errs by less than 1 %)."""
    ground = found("horizon").boundary
    assert ground is not None
    x = np.linspace(0.0, ground, 2_000_001).astype(np.longdouble)
    drop = x**2 / (2 * np.longdouble(EARTH))
    foot, far = np.hypot(x, 15.0 + drop), ground - x
    total = np.longdouble(ground) ** 2 / (2 * np.longdouble(EARTH))
    excess = (foot + np.hypot(far, 10.0 - total + drop)).min() - np.hypot(ground, 10.0 - total - 15.0)
    assert float(excess) == pytest.approx(WAVELENGTH / 4.0, rel=0.01)


def test_least_grazing_angle() -> None:
    """(0.031859 / (2 pi 8 494 667))^(1/3) by hand: 5.969e-10^(1/3) = 8.42e-4 rad."""
    assert least_grazing(WAVELENGTH, EARTH) == pytest.approx(8.42e-4, abs=5e-7)


@pytest.mark.parametrize("window", ["none", "hamming", "blackman"])
def test_the_twin_of_the_studies_is_the_twin_of_the_tests(window: str) -> None:
    """Two closed forms written apart agree to rounding, 1e-12 of the peak."""
    delay = np.linspace(-2.1e-6, 2.1e-6, 1001)
    mine = pulse_response(delay, 50e6, 2e-6, window)
    coefficients = {"none": (1.0,), "hamming": (0.54, 0.46), "blackman": (0.42, 0.5, 0.08)}[window]
    assert np.abs(mine - compressed_pulse.compressed_pulse(delay, 50e6, 2e-6, coefficients)).max() < 1e-12


def test_a_target_far_from_its_last_spoke_is_found_again() -> None:
    """24 spokes a turn at 24 rpm and 1400 kn: 75 m from spoke to spoke, 1.2 km in sixteen; below -50 dB, as all moving."""
    assert moving_error(720.0, azimuths=24) < -50.0


def test_crossings_and_halvings() -> None:
    driven = np.array([1.0, 10.0, 100.0])
    assert crossing(driven, np.array([0.0, 1.0, 2.0]), 0.5) == pytest.approx(5.5)
    assert crossing(driven, np.array([0.0, 1.0, 2.0]), 0.5, log=True) == pytest.approx(np.sqrt(10.0))
    assert crossing(driven, np.array([0.0, 1.0, 2.0]), 5.0) is None
    assert crossing(driven, np.array([3.0, 1.0, 2.0]), 2.5) == 1.0
    assert bisected(lambda x: x < 0.01, 1.0, 1e-9) == pytest.approx(0.01, rel=1e-9)


def test_the_report_holds_every_region(tmp_path: Path) -> None:
    findings = [found(study.__name__) for study in stability.STUDIES]
    write_report(tmp_path / "new", findings)
    stored = json.loads((tmp_path / "new" / "stability.json").read_text())
    assert [one["name"] for one in stored] == [finding.name for finding in findings]
    text = page(findings)
    assert text.count("<section") == text.count("role='img'") == len(findings)
    assert "nan" not in text.lower().replace("nanoseconds", "") and "PENDING" not in text


def test_the_command_writes_its_report(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(stability, "STUDIES", stability.STUDIES[:1])
    assert main(["stability", "-o", str(tmp_path / "out")]) == 0
    assert "float32 range" in (tmp_path / "out" / "stability.html").read_text()


@pytest.mark.study
def test_three_times_finer_the_boundaries_stay(request: pytest.FixtureRequest) -> None:
    """All studies with three times the places: no boundary moves by more than a quarter."""
    if request.config.getoption("-m") != "study":
        pytest.skip("a minute and a half; run with -m study")
    for study in stability.STUDIES:
        coarse, fine = found(study.__name__).boundary, study(3).boundary
        assert (coarse is None) == (fine is None), study.__name__
        if coarse is not None:
            assert fine == pytest.approx(coarse, rel=0.25), study.__name__
