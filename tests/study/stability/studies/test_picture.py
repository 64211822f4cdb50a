"""Studies of the picture, against what each method promises."""

from tests.study.stability.run import finding_of


def test_peak_interpolation_keeps_every_cell() -> None:
    """A picture by peak shows single cells at full brightness at every size of pixels."""
    assert (finding_of("pixel_size").curve("peak") == 1.0).all()


def test_the_share_of_old_rows_is_that_of_the_lost_spokes() -> None:
    """180 rows: within 4 standard deviations of the binomial law, at most 4 sqrt(0.25 / 180) = 0.15."""
    finding = finding_of("spokes_lost")
    assert abs(finding.curve("of the scan before") - finding.values).max() < 0.15
