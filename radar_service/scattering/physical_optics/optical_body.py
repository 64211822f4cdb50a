"""A body prepared for physical optics: cut once for each half octave of range, then asked what it sends back."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from radar_service.radar.parameters import Radar
from radar_service.scattering.diffuse import triangle_frames
from radar_service.scattering.physical_optics.facets import MOST, Facets, cut_facets, far_field_edge
from radar_service.scattering.physical_optics.patches import faces_something, outward_side, patch_sizes
from radar_service.scattering.physical_optics.ray_tubes import Planes, Seen, Wave, hits, illuminated_facets, scattered_field
from radar_service.scattering.physical_optics.scattering_centres import scattering_centres
from radar_service.scene.materials import power_reflectivity
from radar_service.scene.world import Body, Mesh
from radar_service.trace.embree import TriangleScene

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]

NEAREST = 16.0  # m; nearer than this the far field of a piece is that of 16 m: no marine antenna looks at less
TUBES_ACROSS = 24  # tubes across a flat patch that bounces: their ragged edge is then some 1 % of its area
SHORTEST = 1.0 / 6.0  # of a wavelength: finer tubes than this gain nothing (DESIGN section 4)


@dataclass(frozen=True)
class OpticalBody:
    """A mesh that scatters by physical optics with up to `bounces` surfaces in a row.

    edge: longest edge of a piece [m] wherever it is seen from; reflectivity: power ratio at every surface.
    """

    mesh: Mesh
    planes: Planes
    radio: Wave
    edge: float
    bounces: int
    reflectivity: float
    scene: TriangleScene
    may_rebounce: NDArray[np.bool_]
    patch: Floats
    outside: NDArray[np.int8]
    cuts: dict[float, Facets] = field(default_factory=dict)  # by longest edge

    def echoes(self, antenna: Floats, seen: Seen) -> tuple[Floats, Complexes]:
        """Points (C, 3) [m] and scattering amplitudes (C,) [m] for an antenna (3,), all in the body's own frame.

        seen: which points (M, 3) on triangles (M,) of the mesh the antenna sees.
        """
        nearest = float(np.linalg.norm(antenna - self.scene.centre)) - self.scene.radius
        limit = self.limit(nearest)
        tubes = illuminated_facets(self.pieces(limit), self.planes, self.outside, antenna, self.radio, seen)
        points, amplitudes = [np.zeros((0, 3))], [np.zeros(0, dtype=np.complex128)]
        for bounce, arrived in enumerate(hits(tubes, self.planes, self.scene, self.may_rebounce, self.bounces)):
            back = arrived if bounce == 0 else arrived.chosen(np.flatnonzero(seen(arrived.centre, arrived.triangle)))
            point, amplitude = scattered_field(back, antenna, self.radio)
            points.append(point)
            amplitudes.append(amplitude * self.reflectivity ** ((bounce + 1) / 2.0))
        return scattering_centres(np.concatenate(points), np.concatenate(amplitudes), antenna, limit, self.radio.wavenumber)

    def limit(self, distance: float) -> float:
        """Longest edge of a piece [m] for antennas from `distance` [m] on."""
        return longest_edge(distance, self.edge, self.radio.wavelength)

    def pieces(self, limit: float) -> Facets:
        """The mesh cut to this longest edge [m], finer where its flat patches mirror into other parts of it."""
        if limit not in self.cuts:
            tube = np.clip(self.patch / TUBES_ACROSS, SHORTEST * self.radio.wavelength, limit)
            mirrors = self.may_rebounce.any(axis=1) & (self.bounces > 1)
            self.cuts[limit] = cut_facets(self.mesh, np.where(mirrors, tube, limit), limit)
        return self.cuts[limit]


def coarsening(body: Body, radar: Radar, distance: float) -> float:
    """How many times longer than asked the pieces of a body are, seen from `distance` [m], because it is so large; 1 where
    they are not."""
    assert body.mesh is not None
    limit = longest_edge(distance, radar.range_resolution, radar.wavelength)
    _, _, area = triangle_frames(body.mesh)
    if len(area) + 16.0 * area.sum() / limit**2 <= MOST:  # halving leaves some limit^2 / 8 a piece, slivers less
        return 1.0
    return cut_facets(body.mesh, np.full(len(area), limit), limit, tubes=0).coarser


def longest_edge(distance: float, edge: float, wavelength: float) -> float:
    """`edge` [m], or the far field's limit where that is shorter, the same throughout half an octave of distance [m]."""
    octave = np.floor(2.0 * np.log2(max(distance, NEAREST))) / 2.0
    return min(edge, far_field_edge(float(2.0**octave), wavelength))


def optical_body(body: Body, radar: Radar, bounces: int) -> OpticalBody:
    """A body with a mesh made ready for this radar: no piece is longer than what it resolves in range."""
    assert body.mesh is not None
    mesh = body.mesh
    return OpticalBody(
        mesh,
        Planes(*triangle_frames(mesh)[:2]),
        Wave(radar.wavelength, radar.polarization),
        radar.range_resolution,
        bounces,
        power_reflectivity(body.material.name),
        TriangleScene(mesh.vertices, mesh.faces),
        faces_something(mesh),
        patch_sizes(mesh),
        outward_side(mesh),
    )
