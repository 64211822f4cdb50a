"""Studies of sampling, against theory."""

import numpy as np
import pytest

from tests.study.stability.run import finding_of


@pytest.mark.parametrize("name", ["missed_targets", "missed_sizes"])
def test_missed_targets_follow_the_binomial_law(name: str) -> None:
    """200 azimuths each: within 4 standard deviations of the law at eight ranges and ten sizes (one false alarm in 2000)."""
    finding = finding_of(name)
    law = finding.curve("binomial law")
    spread = np.sqrt(np.maximum(law * (1.0 - law), 1e-4) / 200)
    assert (np.abs(finding.curve("measured") - law) < 4.0 * spread).all()
