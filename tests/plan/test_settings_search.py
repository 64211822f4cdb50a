"""Errors of kernels and beams predicted, against what the chart and the closed form measured; what a budget chooses."""

import math
from dataclasses import replace

import pytest

import radar_service as rs
from radar_service.plan.budget import STEPS_DB, ErrorBudget
from radar_service.plan.settings_search import (
    MULTIPATH_DB,
    beam_kernel_db,
    extent_db,
    fidelity_for,
    kernel_db,
    moving_db,
    multipath_db,
    relative_cost,
    resting_db,
)
from radar_service.records.fidelity import PRESETS
from tests.scenes import point, radar, scene

BALANCED = PRESETS["balanced"]


@pytest.mark.parametrize(("width", "measured"), [(2, -24.5), (4, -61.4)])
def test_kernels_err_as_the_chart_of_the_harbour_says(width: int, measured: float) -> None:
    """Within 1 dB: the chart judges 400 echoes, whose sum of squares scatters by about 0.2 dB. Wider kernels are beyond its
    single precision."""
    assert kernel_db(radar(window="hamming"), width) == pytest.approx(measured, abs=1.0)


@pytest.mark.parametrize(("beamwidth", "azimuths", "measured"), [(3.9, 720, -83.0), (0.9, 2048, -85.0)])
def test_beam_kernels_err_as_was_measured(beamwidth: float, azimuths: int, measured: float) -> None:
    """-83 dB at 4.4 grid rows to the beam's band (docs/engine.md#errors); twice the rows where a beam has 2.9 of them."""
    assert beam_kernel_db(radar(beamwidth_deg=beamwidth, azimuths=azimuths), 4) == pytest.approx(measured, abs=1.0)


@pytest.mark.parametrize(("extent", "measured"), [(3.0, -38.0), (9.0, -51.0), (12.0, -55.0)])
def test_a_cut_beam_errs_as_was_measured(extent: float, measured: float) -> None:
    """The table of docs/engine.md#errors, whole dB."""
    assert extent_db(radar(), extent) == pytest.approx(measured, abs=0.5)


def test_a_beam_over_the_whole_turn_has_no_error_and_a_gaussian_needs_little() -> None:
    assert extent_db(radar(beamwidth_deg=20, azimuths=60), 9.0) == -math.inf
    assert extent_db(radar(pattern="gaussian"), 1.5) < -60 < extent_db(radar(), 12.0)


def under_way(**settings: object) -> rs.Scene:
    return scene([point("t", 500, 500)], radar=settings, own_ship={"speed_kn": 10})


def test_auto_is_balanced_in_the_default_radar_and_cheaper_where_the_beam_allows() -> None:
    for made in (scene([point("t", 500, 500)]), under_way()):
        assert replace(fidelity_for(made, ErrorBudget()), name="balanced", error_db=0.0) == BALANCED
    tapered = under_way(pattern="taylor")
    chosen = fidelity_for(tapered, ErrorBudget())
    assert relative_cost(tapered.radar, chosen) < 0.4 * relative_cost(tapered.radar, BALANCED)
    assert moving_db(tapered.radar, chosen) < -54 > moving_db(tapered.radar, replace(BALANCED, beam_extent=12.0)) - 10


def test_looser_budgets_are_never_dearer_and_each_is_kept_if_it_can_be() -> None:
    made = under_way()
    chosen = [fidelity_for(made, ErrorBudget(step)) for step in STEPS_DB]
    costs = [relative_cost(made.radar, fidelity) * fidelity.scatterers_per_cell for fidelity in chosen]
    assert costs == sorted(costs, reverse=True) and costs[0] > 10 * costs[-1]
    for step, fidelity in zip(STEPS_DB, chosen, strict=True):
        assert moving_db(made.radar, fidelity) <= ErrorBudget(step).method_db


def test_a_kernel_is_widened_where_sampling_is_coarse_and_no_more_than_helps() -> None:
    """At 1.0 x bandwidth 8 bins reach -60 dB, 6 -52. A chirp of 15 cycles folds so much that 6 bins are as good as any."""
    chosen = fidelity_for(under_way(sample_rate_hz=50e6), ErrorBudget())
    assert (chosen.kernel_width, chosen.azimuths_per_block, chosen.beam_extent) == (8, 16, 18.0)
    short = under_way(sample_rate_hz=50e6, pulse_s=3e-7)
    assert fidelity_for(short, ErrorBudget()).kernel_width == 6
    text = str(rs.Simulator(short).plan)
    assert "! the error budget cannot be kept" in text and "raise sample_rate_hz" in text


def test_the_error_of_a_short_chirp_holds_what_its_samples_fold() -> None:
    """-26 dB, as tests/radar/test_folding.py measures; it is in the errors of echoes at rest and of moving ones."""
    short = radar(pulse_s=8e-8, sample_rate_hz=50e6)
    assert kernel_db(short, 6) == pytest.approx(-26.6, abs=0.5)
    assert resting_db(short, BALANCED) == pytest.approx(-26.6, abs=0.5) == moving_db(short, BALANCED)


def test_a_long_plain_pulse_has_the_error_of_its_sampled_spectrum() -> None:
    """Beyond 64 samples a plain pulse is gridded like a chirp: it fills little of the band. A short one is its own kernel."""
    assert -150.0 < kernel_db(radar(modulation="none", pulse_s=2e-6, sample_rate_hz=75e6), 6) < -60.0
    assert kernel_db(radar(modulation="none", pulse_s=1e-7), 6) == -math.inf


def test_sea_reflection_errs_only_where_blocks_meet_motion() -> None:
    """Each azimuth by itself, without multipath or without motion there is no error; a long block costs none of the budget."""
    sea = {"multipath": True}
    moving = scene([point("t", 0, 300, speed_kn=40, course_deg=180)], environment=sea)
    peak = extent_db(moving.radar, 12.0) + 10 * math.log10(16 / 6)
    by_hand = 10 * math.log10(10 ** (MULTIPATH_DB / 10) + 10 ** (peak / 10))
    assert multipath_db(moving, BALANCED) == pytest.approx(by_hand, abs=0.05)
    assert fidelity_for(moving, ErrorBudget()).azimuths_per_block == 16
    assert multipath_db(moving, PRESETS["reference"]) == -math.inf
    assert multipath_db(scene([point("t", 0, 300)], environment=sea), BALANCED) == -math.inf
    assert multipath_db(under_way(), BALANCED) == -math.inf
