"""Targets of known cross-section, against textbook values."""

import numpy as np
import pytest

from radar_service.study.chart.canonical_targets import canonical_targets, coherent_cross_sections
from tests.scenes import radar
from tests.study.chart.settings import SMALL


def test_cross_sections_of_the_canonical_targets() -> None:
    """Textbook values in wavelengths, r = 4, a = 20: pi r^2; 2 pi r a^2; 4 pi a^4; 8 pi a^4; 4 pi a^4 / 3, of lambda^2."""
    facing = {target.name: float(target.cross_section(np.zeros(1))[0]) for target in canonical_targets(0.03)}
    textbook = {"sphere": np.pi * 16, "cylinder": np.pi * 3200, "plate": 4 * np.pi * 160_000, "dihedral": 8 * np.pi * 160_000,
                "trihedral": 4 * np.pi * 160_000 / 3}  # fmt: skip
    assert facing == {name: pytest.approx(value * 0.0009, rel=1e-9) for name, value in textbook.items()}


def test_echoes_add_with_the_phase_of_their_range() -> None:
    """Two echoes of 1 m^2, the second 0.3 wavelengths behind. A phase that compensates it gives 4 m^2, no phase
    4 cos^2(0.6 pi)."""
    small, body = radar(**SMALL), np.zeros(2, dtype=np.int64)
    position = np.array([[0.0, 1000.0, 0.0], [0.0, 1000.0 + 0.3 * small.wavelength, 0.0]])
    for phase, expected in ((1.2j * np.pi, 4.0), (0j, 4.0 * np.cos(0.6 * np.pi) ** 2)):
        amplitude = np.array([1.0, np.exp(phase)])
        assert coherent_cross_sections(small, np.zeros(3), position, amplitude, body, 1) == pytest.approx(expected, rel=1e-6)
