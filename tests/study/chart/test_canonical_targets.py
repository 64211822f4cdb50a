"""Targets of known cross-section, against textbook values."""

import numpy as np
import pytest

from radar_service.study.chart.canonical_targets import canonical_targets


def test_cross_sections_of_the_canonical_targets() -> None:
    """Textbook values in wavelengths, r = 4, a = 20: pi r^2; 2 pi r a^2; 4 pi a^4; 8 pi a^4; 4 pi a^4 / 3, of lambda^2."""
    targets = canonical_targets(0.03)
    facing = {target.name: float(target.cross_section(np.zeros(1))[0]) for target in targets}
    textbook = {"sphere": np.pi * 16, "cylinder": np.pi * 3200, "plate": 4 * np.pi * 160_000, "dihedral": 8 * np.pi * 160_000,
                "trihedral": 4 * np.pi * 160_000 / 3}  # fmt: skip
    assert facing == {name: pytest.approx(value * 0.0009, rel=1e-9) for name, value in textbook.items()}
    assert facing == {target.name: target.facing for target in targets}
