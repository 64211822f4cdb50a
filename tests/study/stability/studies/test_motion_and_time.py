"""Studies of motion and time, against theory."""

from radar_service.study.stability.studies.motion_and_time import moving_error
from tests.study.stability.run import finding_of


def test_the_accumulator_distinguishes_numbers_that_a_browser_does_not() -> None:
    """Python distinguishes numbers up to 2^63; at 2.5e18, the last value, doubles are 512 apart."""
    finding = finding_of("sequence_numbers")
    assert (finding.curve("the accumulator") == 0.0).all() and finding.curve("float64 of a browser")[-1] == 1.0


def test_a_target_may_move_far_between_spokes() -> None:
    """24 spokes for each scan at 24 rpm and 1400 kn: 75 m from spoke to spoke, 1.2 km in sixteen. The error stays below -50
    dB, as for all moving echoes."""
    assert moving_error(720.0, azimuths=24) < -50.0
