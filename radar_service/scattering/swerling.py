"""Fluctuation of declared cross-sections."""

import numpy as np


def swerling_factor(case: int, rng: np.random.Generator) -> float:
    """A power factor of mean 1 for Swerling cases 0 to 4 (Swerling 1960).

    Exponential for cases 1 and 2, chi-square with four degrees of freedom for 3 and 4, always 1 for case 0 (steady).
    """
    if case == 0:
        return 1.0
    return float(rng.exponential(1.0) if case in (1, 2) else rng.gamma(2.0, 0.5))


def per_azimuth(case: int) -> bool:
    """Whether the cross-section is drawn anew for every azimuth (cases 2 and 4) rather than for every scan (1 and 3)."""
    return case in (2, 4)
