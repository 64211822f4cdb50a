"""The wave that bodies scatter, and phasors of paths."""

from dataclasses import dataclass

import numpy as np

from radar_service.kernels.library import KERNELS
from radar_service.numerics.types import Complexes, Floats


@dataclass(frozen=True)
class Wave:
    """The wave: wavelength [m] and the radar's polarization, "h" or "v"."""

    wavelength: float
    polarization: str

    @property
    def wavenumber(self) -> float:
        """[rad/m]"""
        return 2.0 * np.pi / self.wavelength

    def phasor(self, length: Floats) -> Complexes:
        """exp(-j k length) (M,) of paths [m]."""
        result = np.empty(len(length), dtype=np.complex128)
        KERNELS.phasors(len(length), np.ascontiguousarray(-self.wavenumber * length), result)
        return result
