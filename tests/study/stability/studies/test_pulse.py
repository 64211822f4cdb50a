"""Studies of pulse compression, against theory."""

import numpy as np

from tests.study.stability.run import finding_of


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
