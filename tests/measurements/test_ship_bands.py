"""Echoes of ships: what the table is made of, and that hull types lie in their bands."""

import numpy as np
import pytest
from scipy.special import polygamma

from tests.measurements.ship_bands import (
    AWAY,
    BANDS,
    BROADSIDE,
    LOOKS,
    SHIPS,
    Echoes,
    aspects,
    band,
    bow_and_quarter,
    echoes,
    row,
    together,
)  # fmt: skip


@pytest.mark.parametrize("name", ["pilot, 9 m", "fishing, 52 m", "cargo, 103 m"])
def test_a_hull_type_lies_in_its_band(name: str) -> None:
    """The median of twelve aspects between bow, beam and stern, in sea state 3, within 3 dB more: it scatters by 2 dB."""
    aspect = aspects(1, 0)[1::2]
    seen = echoes(SHIPS[name], "3", aspect)
    limits = band(seen.length)
    assert limits is not None and limits[0] - 3.0 < seen.quartiles[1] < limits[1] + 3.0


def test_aspects_lie_all_round_and_about_broadside() -> None:
    aspect = aspects(2, 10)
    off = np.abs(aspect % 180.0 - 90.0)
    assert len(aspect) == 68 and (np.abs(aspect[:48] % 15.0 - 7.5) > 5.0).all()
    assert (off[48:] <= BROADSIDE).all() and (off[:48] > AWAY).sum() == 44


def drawn(seed: int, median: float, sigma: float, broadside: float) -> Echoes:
    """Normal draws about a median, higher at broadside."""
    aspect = aspects(40, 40)
    section = median + sigma * np.random.default_rng(seed).standard_normal(len(aspect))
    return Echoes(aspect, section + broadside * (np.abs(aspect % 180.0 - 90.0) <= BROADSIDE), 52.0)


def test_quartiles_broadside_and_spread_of_normal_draws() -> None:
    """Within four standard errors of 880 draws off broadside, and of 80 or more at broadside, whose mean power is that of a
    lognormal law: 5^2 ln 10 / 20 = 2.9 dB over its median."""
    each = drawn(1, 30.0, 5.0, 20.0)
    np.testing.assert_allclose(each.quartiles, [30.0 - 3.37, 30.0, 30.0 + 3.37], atol=0.9)
    assert each.broadside == pytest.approx(22.9, abs=2.5) and each.spread == pytest.approx(5.0, rel=0.1)


def test_a_row_tells_whether_the_waves_lie_in_the_band() -> None:
    seas = {sea: drawn(n, level, 1.0, 15.0) for n, (sea, level) in enumerate({"1": 33.0, "3": 30.0, "5": 27.0}.items())}
    assert together(seas).quartiles[1] == pytest.approx(30.0, abs=0.3)
    assert "| 20 to 36 | yes |" in row("a", seas, seas["3"])
    assert "| 20 to 36 | no |" in row(
        "a", {sea: each._replace(section=each.section + 8.0) for sea, each in seas.items()}, seas["3"]
    )


def test_bands_do_not_overlap_in_length() -> None:
    edges = [edge for limits in sorted(BANDS) for edge in limits]
    assert edges == sorted(edges) and band(85.0) is None


@pytest.mark.parametrize(("looks", "expected"), [(1, 5.570), (2, 3.488), (4, 2.314)])
def test_the_spread_of_many_scatterers_is_that_of_the_logarithm_of_a_gamma_law(looks: int, expected: float) -> None:
    """10 / ln 10 x sqrt(trigamma(n)) for means of n looks. A spread scatters by 8 %, the mean of 100 by 1 %."""
    assert 10.0 / np.log(10.0) * np.sqrt(polygamma(1, looks)) == pytest.approx(expected, abs=5e-4)
    aspect, rng = bow_and_quarter(LOOKS), np.random.default_rng(3)
    spreads = []
    for _ in range(100):
        power = rng.exponential(size=(looks, len(aspect))).mean(axis=0)
        spreads.append(Echoes(aspect, 10.0 * np.log10(power), 9.0).spread)
    assert np.sqrt(np.mean(np.square(spreads))) == pytest.approx(expected, abs=0.1)
    assert np.std(spreads) < 0.1 * expected


def test_looks_lie_in_windows_of_bow_and_quarter_alone() -> None:
    aspect = bow_and_quarter(LOOKS)
    window, count = np.unique(np.round(aspect / 15.0), return_counts=True)
    assert len(window) == 22 and (count == LOOKS).all() and not {6.0, 18.0} & set(window.tolist())
