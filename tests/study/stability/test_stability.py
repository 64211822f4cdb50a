"""The boundaries of all studies: each lies where the study expects it. A new study needs no change here."""

from pathlib import Path

import numpy as np
import pytest

from radar_service.study import stability
from radar_service.study.stability import studies
from radar_service.study.stability.finding import bisect, crossing, echo_amplitude, error_db, point, point_fields, scene_of
from tests.reference.compressed_pulse import point_field
from tests.study.stability.run import finding_of

NAMES = [study.__name__ for study in stability.STUDIES]
MIN_TOLERANCE = 1e-9  # of 64-bit arithmetic


@pytest.mark.parametrize("name", NAMES)
def test_a_boundary_lies_where_it_is_expected(name: str) -> None:
    finding = finding_of(name)
    if finding.expected.boundary is None:
        assert finding.boundary is None
    else:
        assert finding.boundary == pytest.approx(
            finding.expected.boundary, rel=max(finding.expected.tolerance, MIN_TOLERANCE)
        )


@pytest.mark.parametrize("name", NAMES)
def test_a_finding_names_the_method_and_what_the_service_uses_instead(name: str) -> None:
    """A study where nothing fails has no boundary, and an expected boundary has an origin."""
    finding = finding_of(name)
    assert finding.method and finding.setup and finding.limit_reason and finding.instead and finding.details.endswith(".")
    assert (finding.boundary is None) == (finding.response == "no failure")
    assert finding.expected.boundary is None or finding.expected.origin


def test_names_of_studies_and_regions_are_unique() -> None:
    assert len(set(NAMES)) == len({finding_of(name).name for name in NAMES}) == len(NAMES) >= 30


def test_one_new_file_adds_a_study(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A module in the folder `studies` is found without any other change."""
    (tmp_path / "zzz_new.py").write_text("def new(fine=1):\n    return fine\n\nSTUDIES = (new,)\n")
    monkeypatch.setattr(studies, "__path__", [*studies.__path__, str(tmp_path)])
    assert [study.__name__ for study in stability.discover()] == [*NAMES, "new"]


@pytest.mark.study
def test_three_times_finer_the_boundaries_stay(request: pytest.FixtureRequest) -> None:
    """With three times the values no boundary moves by more than a quarter."""
    if request.config.getoption("-m") != "study":
        pytest.skip("a minute and a half; run with -m study")
    for study in stability.STUDIES:
        coarse, fine = finding_of(study.__name__).boundary, study(3).boundary
        assert (coarse is None) == (fine is None), study.__name__
        if coarse is not None:
            assert fine == pytest.approx(coarse, rel=0.25), study.__name__


# finding: fields of points in closed form, against those of the tests.
def test_the_field_of_a_point_agrees_with_that_of_the_tests() -> None:
    """Two derivations agree to 1e-8 of the peak: their constants of the beam have nine digits."""
    scene = scene_of(point(211.1, 111.7), environment={"earth": "flat"})
    radar, time = scene.radar, np.zeros(24)
    sample_range = (np.arange(radar.bins) + 0.5) * radar.range_step
    azimuth = np.arange(24) * radar.azimuth_step
    distance, bearing = np.full((24, 1), np.hypot(211.1, 111.7)), np.full((24, 1), np.arctan2(211.1, 111.7))
    expected = point_field(
        sample_range, azimuth, distance, bearing, echo_amplitude(radar, distance, 10.0), radar.wavelength, radar.bandwidth,
        radar.pulse, (0.54, 0.46), radar.beamwidth,
    )  # fmt: skip
    field = point_fields(scene, time, azimuth, sample_range)
    assert np.abs(field - expected).max() < 1e-8 * np.abs(expected).max()


def test_an_error_of_a_hundredth_is_minus_forty_decibels() -> None:
    """20 log10(0.01), to the rounding of 32 bits."""
    exact = np.array([3.0 + 4.0j])
    assert error_db((1.01 * exact).astype(np.complex64), exact) == pytest.approx(-40.0, abs=1e-3)


# finding: crossings and bisections, by which the studies find their boundaries.
def test_crossings_and_bisections() -> None:
    parameter = np.array([1.0, 10.0, 100.0])
    assert crossing(parameter, np.array([0.0, 1.0, 2.0]), 0.5) == pytest.approx(5.5)
    assert crossing(parameter, np.array([0.0, 1.0, 2.0]), 0.5, log=True) == pytest.approx(np.sqrt(10.0))
    assert crossing(parameter, np.array([0.0, 1.0, 2.0]), 5.0) is None
    assert crossing(parameter, np.array([3.0, 1.0, 2.0]), 2.5) == 1.0
    assert bisect(lambda x: x < 0.01, 1.0, 1e-9) == pytest.approx(0.01, rel=1e-9)
