"""A body prepared for physical optics: planar pieces, and how finely their fields are summed."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from radar_service.numerics.types import Floats
from radar_service.radar.parameters import Radar
from radar_service.scattering.physical_optics.body_legs import BodyLeg
from radar_service.scattering.physical_optics.edge_limits import EdgeLimits
from radar_service.scattering.physical_optics.patches import is_concave, outward_side
from radar_service.scattering.physical_optics.path_centres import PATHS, PathCentres, flattest, over_nodes
from radar_service.scattering.physical_optics.planar_pieces import PlanarPieces
from radar_service.scattering.physical_optics.plane_echoes import PlaneOptics, Wave
from radar_service.scattering.physical_optics.plating import PlatedWalls
from radar_service.scattering.physical_optics.scattering_centres import Lattice, strongest
from radar_service.trace.tree_cache import content_key
from radar_service.world.body import Body, Mesh, Plating
from radar_service.world.materials import power_reflectivity

BOX_CORNERS = np.arange(8)[:, None] & [1, 2, 4] > 0  # (8, 3) at which end of each axis each lies


@dataclass(frozen=True)
class OpticalBody:
    """A mesh that scatters by physical optics.

    mesh: its triangles. optics: its pieces. limits: what bounds edges and cells. reflectivity: power ratio at each surface.
    """

    mesh: Mesh
    optics: PlaneOptics
    limits: EdgeLimits
    reflectivity: float

    @classmethod
    def of(cls, body: Body, radar: Radar, bounces: int) -> "OpticalBody":
        """A body with a mesh, prepared for this radar."""
        assert body.mesh is not None
        mesh, outside = body.mesh, outward_side(body.mesh)
        bounces = bounces if is_concave(mesh) else 1
        wave = Wave(radar.wavelength, radar.polarization)
        pieces = PlanarPieces.of(mesh, outside)
        walls = PlatedWalls.of(mesh, pieces.normal, pieces.spans, body.plating, radar.wavelength)
        optics = PlaneOptics.of(pieces, wave, bounces, radar.range_resolution, walls)
        return cls(mesh, optics, EdgeLimits.of(radar, mesh), power_reflectivity(body.material.name))

    def dry_box(self, height: float) -> Floats:
        """The corners (8, 3) of the box around what rises above the sea, where the origin is at a height over it [m]."""
        low, high = self.mesh.vertices.min(axis=0), self.mesh.vertices.max(axis=0)
        low[2] = max(low[2], min(-height, high[2]))
        return np.asarray(np.where(BOX_CORNERS, high, low))

    def leaning(self, lean: Floats) -> "OpticalBody":
        """The same body rotated by a matrix (3, 3), so that the sea is level in its frame."""
        mesh = Mesh(self.mesh.vertices @ lean.T, self.mesh.faces)
        return replace(self, mesh=mesh, optics=self.optics.rotated(lean))

    def echoes(self, legs: tuple[BodyLeg, ...], water: float = -np.inf) -> list[PathCentres]:
        """The centres of each path of one leg, or of two: the direct one and the one by the sea.

        water: height of the sea in the body's frame [m]; nothing below it scatters. Raises MemoryError.
        """
        sea, wave, longest = legs[0].sea, self.optics.wave, self.limits.longest
        if sea is not None:
            longest = longest._replace(edge=min(longest.edge, sea.longest))
        echoes = self.optics.echoes(legs, water, longest)
        cell = self.limits.cell(legs[0].length(echoes.place))
        lattice = Lattice.over(echoes.place, cell, flattest(legs), water)
        weights, received = over_nodes(legs, lattice, echoes), legs[0].weight(lattice.nodes) ** 2
        lengths, result = [leg.length(lattice.nodes) for leg in legs], []
        amplitude = (
            echoes.amplitude
            * self.reflectivity ** (echoes.surfaces / 2.0)
            * np.choose(echoes.ways, np.broadcast_arrays(echoes.ways, *weights)[1:])
        )
        for (out, back), fields in zip(PATHS, lattice.sums(amplitude, echoes.ways, len(weights)), strict=False):
            sums = fields * wave.phasor(-lengths[out] - lengths[back])
            kept = strongest(np.abs(sums * received))
            result.append(PathCentres(out + back, lattice.nodes[kept], sums[kept]))
        return result


def optical_bodies(bodies: Sequence[Body], radar: Radar, bounces: int) -> list[OpticalBody]:
    """`OpticalBody` of each body. Those of equal meshes, materials and plating are one object."""
    result: dict[tuple[bytes, str, Plating | None], OpticalBody] = {}
    keys = [_key(body) for body in bodies]
    for key, body in zip(keys, bodies, strict=True):
        if key not in result:
            result[key] = OpticalBody.of(body, radar, bounces)
    return [result[key] for key in keys]


def _key(body: Body) -> tuple[bytes, str, Plating | None]:
    assert body.mesh is not None
    return content_key(body.mesh.vertices, body.mesh.faces), body.material.name, body.plating
