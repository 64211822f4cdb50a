"""How fine the field of a body has to be: edges over which it is linear, and cells in which it is summed."""

import math
from typing import NamedTuple

import numpy as np

from radar_service.numerics.types import Floats
from radar_service.radar.parameters import Radar
from radar_service.scattering.physical_optics.plane_echoes import Longest
from radar_service.scattering.predictions import NEAREST
from radar_service.world.body import Mesh

MAX_BEND = 0.3  # rad, two-way, over half an edge (docs/engine.md#errors)
# Of the beam's width and of the range cell that an edge and a cell may take: what weighs them is linear in between
BEAM_SHARE, RANGE_SHARE = 1.0 / 6.0, 1.0 / 4.0
EXTENT_SHARE = 1.0 / 9.0  # of the body, likewise: its sidelobes are what is left of many cells
EDGE_SHARE = 3.0 / 5.0  # of the range cell, of an edge: few lie along the line of sight


class EdgeLimits(NamedTuple):
    """What bounds edges and the cells in which they are summed: range resolution [m], beamwidth [rad], wavelength [m], and the
    extent of the body [m]."""

    range_cell: float
    beamwidth: float
    wavelength: float
    extent: float

    @classmethod
    def of(cls, radar: Radar, mesh: Mesh) -> "EdgeLimits":
        """Of a mesh for this radar."""
        extent = float(np.ptp(mesh.used_vertices, axis=0).max(initial=0.0))
        return cls(radar.range_resolution, radar.beamwidth, radar.wavelength, extent)

    def cell(self, distance: Floats) -> Floats:
        """Sizes [m] of the cells at distances (M,) [m], the same throughout half an octave."""
        if distance.size > 2:
            ends = self.cell(np.array([distance.min(), distance.max()]))
            if ends[0] == ends[1]:
                return np.broadcast_to(ends[:1], distance.shape)
        half_octave = 2.0 ** (np.floor(2.0 * np.log2(np.maximum(distance, NEAREST))) / 2.0)
        widest = min(RANGE_SHARE * self.range_cell, EXTENT_SHARE * self.extent)
        return np.minimum(widest, BEAM_SHARE * self.beamwidth * half_octave)

    @property
    def longest(self) -> Longest:
        """The longest edges: their phase bends by MAX_BEND over half of one, by k (e/2)^2 / R."""
        bend = float(np.sqrt(2.0 * MAX_BEND * self.wavelength / np.pi))
        return Longest(min(EDGE_SHARE * self.range_cell, EXTENT_SHARE * self.extent), BEAM_SHARE * self.beamwidth, bend)

    def coherence(self, nearest: float) -> float:
        """The longer of cell and edge [m] of a body whose nearest part is so far away [m]."""
        return self.highest(nearest, 1.0)

    def highest(self, nearest: float, upright: float, flattest: float = np.inf) -> float:
        """The longer of edge and height of a cell [m], which is `upright` times its length, at most `flattest`."""
        nearest = max(nearest, NEAREST)
        edge, wide, bend = self.longest
        cell = min(upright * float(self.cell(np.array(nearest))), flattest)
        return max(cell, min(edge, wide * nearest, bend * math.sqrt(nearest)))
