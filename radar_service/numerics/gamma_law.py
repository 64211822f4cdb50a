"""Thresholds of power that is averaged over pulses, whose noise has a gamma law: of noise alone, and of noise with clutter."""

import numpy as np


def known_level_factor(pfa: float, pulses: int = 1) -> float:
    """Returns the factor on a known mean of the power of noise, averaged over so many pulses: of one -ln(pfa)."""
    if pulses == 1:
        return float(-np.log(pfa))
    from scipy.special import gammainccinv  # here: scipy would slow the start of the service

    return float(gammainccinv(pulses, pfa) / pulses)


def clutter_level_factor(pfa: float, clutter: float, pulses: int) -> float:
    """Returns the factor on the mean of noise and of exponential clutter, which is the same in all pulses.

    clutter: to noise. The power is |c + mean n|^2, exponential, and the variance of n, of a gamma law.
    """
    if pulses == 1 or clutter <= 0.0:
        return known_level_factor(pfa, pulses)
    from scipy.optimize import brentq  # here: scipy would slow the start of the service
    from scipy.special import gammainc, gammaincc

    mean = clutter + 1.0 / pulses  # of the exponential part, over that of the noise
    rate = pulses - 1.0 / mean

    def log_tail(level: float) -> float:
        grown = np.log(gammainc(pulses - 1, rate * level)) - level / mean - (pulses - 1) * np.log(rate / pulses)
        return float(np.logaddexp(grown, np.log(gammaincc(pulses - 1, pulses * level) + 1e-300)) - np.log(pfa))

    least, most = (1.0 + clutter) * known_level_factor(pfa, pulses), -(1.0 + clutter) * np.log(pfa)
    return float(brentq(log_tail, 0.99 * least, 1.01 * most, xtol=1e-6) / (1.0 + clutter))
