"""The correlation of the Gaussian field from which sea texture is made: an ellipse on the map, and what a beam makes of it.

The field has the correlation exp(-(x / along)^2 - (y / across)^2), x along the wind and y across it.
"""

from dataclasses import dataclass

import numpy as np

from radar_service.numerics.types import Floats, Singles

NEAR, FAR = 1.0, 1.6  # row spacing over correlation length: up to the first rows sample the map, from the second on they are
# independent; between them both are blended
TAP_REACH = 1.2  # of a cell's length: the weight of the pulse is 1 % there
NEGLIGIBLE_CELL = 0.2  # of the length across the wind: a shorter cell lengthens the correlation by less than 2 %
DIRECTIONS, DISTANCES = 33, 65  # of the table of gains: neighbours differ by less than 2 %


@dataclass(frozen=True)
class TextureLaw:
    """Correlation of the Gaussian field of a sea, and the cell that averages it along range.

    along, across: distance along and across the wind over which it falls to 1/e [m].
    wind_from: direction of the wind's origin [rad].
    cell: 1/e length of the correlation that the pulse gives to a white field [m].
    """

    along: float
    across: float
    wind_from: float
    cell: float

    def form(self, bearing: Floats) -> tuple[Floats, Floats, Floats]:
        """Coefficients (a, b, c) of -log correlation = a r^2 + 2 b r s + c s^2, each (J,) [1/m^2].

        bearing: (J,) [rad]; r lies outward along it, s 90 degrees clockwise of it.
        """
        cos, sin = np.cos(bearing - self.wind_from), np.sin(bearing - self.wind_from)
        along, across = self.along**-2, self.across**-2
        mixed = sin * cos * (across - along)
        return cos**2 * along + sin**2 * across, mixed, sin**2 * along + cos**2 * across

    def beam_averaged_length(self, bearing: Floats) -> Floats:
        """1/e length along range (J,) [m] where the beam is wider than the waves are long, without the pulse.

        The field itself has 1 / sqrt(a) of `form`. Its average over a line across has sqrt(along^2 cos^2 + across^2 sin^2),
        which is Watts' law. A beam's width lies between, so the geometric mean is taken: within 12 % of both.
        """
        cos, sin = np.cos(bearing - self.wind_from), np.sin(bearing - self.wind_from)
        average = np.hypot(self.along * cos, self.across * sin)
        return np.sqrt(average / np.sqrt(self.form(bearing)[0]))

    def taps(self, step: float) -> Floats:
        """Weights (odd count,) of the pulse on neighbours `step` [m] apart; their correlation is that of `cell`."""
        if self.cell < NEGLIGIBLE_CELL * self.across:
            return np.ones(1)
        length = self.cell * np.sqrt(np.pi / 2.0)  # of exp(-pi r^2 / length^2), whose correlation has the 1/e length `cell`
        reach = int(np.ceil(TAP_REACH * length / step))
        return np.asarray(np.exp(-np.pi * (np.arange(-reach, reach + 1) * step / length) ** 2))


class TextureGains:
    """Factors on rows sampled from the map and on independent rows that give their beam-weighted sum unit variance."""

    def __init__(self, law: TextureLaw, rows_per_scan: int, step: float, columns: int, overlap: Floats) -> None:
        """step: between columns [m]; overlap: (2 M + 1,) mean of the sum of products of beam weights that lie -M to M rows
        apart, 1 in the middle."""
        self._law, self._step = law, step
        self._spacing = 2.0 * np.pi / rows_per_scan
        widest = max(law.along, law.across)
        self.columns = min(columns, int(np.ceil(FAR * widest / self._spacing / step)))  # beyond, rows are independent
        off_wind = np.linspace(0.0, np.pi, DIRECTIONS)
        node = np.linspace(0.0, self.columns, DISTANCES)
        near, far = self._at_nodes(law.wind_from + off_wind, node * step, overlap)
        between = interpolation(np.arange(self.columns, dtype=np.float64) + 0.5, node)
        self._near, self._far = (near @ between).astype(np.float32), (far @ between).astype(np.float32)
        bearing = np.arange(rows_per_scan, dtype=np.float64) * self._spacing
        turned = interpolation((bearing - law.wind_from) % np.pi, np.linspace(0.0, np.pi, DIRECTIONS))
        self._direction = turned.T.astype(np.float32)
        self._across = law.form(bearing)[2] ** -0.5 / self._spacing / step  # columns within which rows correlate

    def rows(self, start: int, stop: int, columns: int) -> tuple[Singles, Singles]:
        """Factors (stop - start, columns) on rows from the map and on independent ones; 0 and 1 in all columns beyond."""
        weights = self._direction[start:stop]
        return weights @ self._near[:, :columns], weights @ self._far[:, :columns]

    def zone(self, start: int, stop: int) -> tuple[int, int]:
        """Where rows start to stop of the map give way to independent ones, farther off: from which column to before which."""
        across = self._across[start:stop]
        margin = 2.0 * self.columns / DISTANCES + 1.0  # the table's step along range, and as much for that in direction
        first = max(0, int(NEAR * across.min() - margin))
        return min(self.columns, first), min(self.columns, int(np.ceil(FAR * across.max() + margin)))

    def _at_nodes(self, bearing: Floats, distance: Floats, overlap: Floats) -> tuple[Floats, Floats]:
        """Both factors (directions, distances) at the nodes of the table."""
        a, b, c = (part[:, None] for part in self._law.form(bearing))
        ratio = distance * self._spacing * np.sqrt(c)
        blend = 0.5 * np.pi * np.clip((ratio - NEAR) / (FAR - NEAR), 0.0, 1.0)
        taps = self._law.taps(self._step)
        pulse, reach = np.correlate(taps, taps, "full"), len(taps) - 1
        variance, lags = np.sin(blend) ** 2, len(overlap) // 2
        own = np.zeros_like(variance)  # variance of one row after the pulse
        summed = np.zeros_like(variance)  # of the rows summed by the beam
        for t, share in enumerate(pulse, start=-reach):
            r = t * self._step
            own += share * np.exp(-a * r**2)
            for m, weight in enumerate(overlap, start=-lags):
                s = m * distance * self._spacing
                summed += share * weight * np.exp(-(a * r**2 + 2.0 * b * r * s + c * s**2))
        total = np.sqrt(np.cos(blend) ** 2 * summed / own + variance)
        return np.cos(blend) / np.sqrt(own) / total, np.sin(blend) / total


def interpolation(at: Floats, node: Floats) -> Floats:
    """Weights (nodes, N) of linear interpolation between evenly spaced nodes at N positions."""
    place = (at - node[0]) / (node[1] - node[0]) if node[1] > node[0] else np.zeros_like(at)
    return np.asarray(np.maximum(1.0 - np.abs(place - np.arange(len(node))[:, None]), 0.0))
