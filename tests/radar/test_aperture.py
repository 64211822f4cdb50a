"""Apertures against the patterns that they make, and patterns less what is taken from them."""

import numpy as np
import pytest

from radar_service.numerics.types import Complexes, Flags, Floats
from radar_service.radar.antenna import AntennaPattern
from radar_service.radar.aperture import ChangedPattern, aperture_of
from radar_service.radar.patterns import PATTERNS, Table, Taylor, line_source

WAVELENGTH, BEAMWIDTH = 0.0319, np.radians(1.0)
LINE_SOURCES = [pattern for pattern in (*PATTERNS.values(), Taylor(25.0, 6)) if line_source(pattern) is not None]


@pytest.mark.parametrize("pattern", LINE_SOURCES, ids=lambda pattern: pattern.description)
def test_an_aperture_makes_its_pattern(pattern: AntennaPattern) -> None:
    """The square of its field is the gain, and so is that of elements with its illumination (to the rounding of 400 of them)."""
    aperture = aperture_of(pattern, BEAMWIDTH, WAVELENGTH)
    assert aperture is not None
    offset = np.linspace(0.0, 4.0, 41) * BEAMWIDTH
    cycles = aperture.length / WAVELENGTH * offset
    np.testing.assert_allclose(aperture.pattern(cycles) ** 2, pattern.gain(offset, BEAMWIDTH), rtol=1e-9, atol=1e-12)
    place = ((np.arange(400) + 0.5) / 400 - 0.5) * aperture.length
    field = aperture.illumination(place) / 400 @ np.exp(2j * np.pi * np.outer(place / aperture.length, cycles))
    np.testing.assert_allclose(
        field, aperture.pattern(cycles), atol=3e-4
    )  # midpoint rule at 7 cycles: (pi 7 / 400)^2 / 6 of 0.4


def test_patterns_without_an_aperture_have_none() -> None:
    table = Table(((0.0, 1.0), (0.1, 0.01)))
    assert [aperture_of(each, BEAMWIDTH, WAVELENGTH) for each in (PATTERNS["gaussian"], PATTERNS["printed"], table)] == [
        None
    ] * 3


class Pane:
    """Takes a share of the field on the starboard side."""

    def __init__(self, share: float, extent: float) -> None:
        self.share, self.extent = share, extent

    def subtract(self, field: Complexes, from_bow: Floats, offset: Floats) -> None:
        field -= np.where((np.sin(from_bow) > 0.0) & (np.abs(offset) < self.extent), self.share * field, 0.0)

    def reaches(self, from_bow: Floats) -> Flags:
        return np.sin(from_bow) > 0.0


def test_changes_take_from_the_field_one_after_the_other() -> None:
    """Two panes leave 0.9 x 0.8 of the field to starboard, two ways its square, and all of it to port; 1e-5: of the table."""
    aperture = aperture_of(PATTERNS["cosine"], BEAMWIDTH, WAVELENGTH)
    assert aperture is not None
    pattern = ChangedPattern(aperture, WAVELENGTH, [Pane(0.1, 0.01), Pane(0.2, 0.02)])
    from_bow, offset = np.array([1.0, 1.0, 4.0]), np.array([0.002, 0.015, 2.0 * np.pi - 0.002])
    plain = np.sqrt(PATTERNS["cosine"].gain(np.abs(np.array([0.002, 0.015, 0.002])), BEAMWIDTH))
    np.testing.assert_allclose(np.abs(pattern.one_way(from_bow, offset)), plain * [0.72, 0.8, 1.0], atol=1e-5)
    change = pattern.two_way_change(from_bow, offset)
    np.testing.assert_allclose(change, plain**2 * [0.72**2 - 1.0, 0.8**2 - 1.0, 0.0], atol=1e-5)
    assert pattern.reaches(from_bow).tolist() == [True, True, False] and pattern.extent == 0.02
    assert pattern.loss_db(1.0) == pytest.approx(-40.0 * np.log10(0.72)) and pattern.loss_db(4.0) == pytest.approx(0.0)
