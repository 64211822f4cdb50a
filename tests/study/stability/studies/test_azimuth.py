"""Studies of azimuth, against theory."""

import numpy as np
import pytest

from tests.study.stability.run import finding_of


def test_loss_between_spokes_is_that_of_the_pattern() -> None:
    """The engine is within 0.1 dB (its kernel) of 40 log10 sinc(0.4429 step / beam), where the loss is below 14 dB."""
    finding = finding_of("narrow_beam")
    pairs = list(zip(finding.values, finding.curve("loss of the strongest spoke"), strict=True))
    for ratio, loss in pairs:
        if loss < 14.0:
            expected = -40.0 * np.log10(np.sinc(0.442946470689452 / ratio))
            assert loss == pytest.approx(expected, abs=0.1)
