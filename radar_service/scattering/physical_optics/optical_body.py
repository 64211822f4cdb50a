"""A body prepared for physical optics. Its mesh is cut into facets once for each half octave of range."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from radar_service.block_cache import BlockCache
from radar_service.radar.parameters import Radar
from radar_service.scattering.physical_optics.facets import MAX_FACETS, Facets, cut_facets, far_field_edge
from radar_service.scattering.physical_optics.patches import concave_sides, outward_side, patch_sizes
from radar_service.scattering.physical_optics.ray_tubes import (
    Planes,
    Visible,
    Wave,
    hits,
    illuminated_facets,
    scattered_field,
)
from radar_service.scattering.physical_optics.scattering_centres import WIDER, scattering_centres
from radar_service.scattering.surface_sampling import triangle_frames
from radar_service.scene.body import Body, Mesh
from radar_service.scene.materials import power_reflectivity
from radar_service.trace.embree import RayCount, TriangleScene
from radar_service.types import Complexes, Flags, Floats

NEAREST = 16.0  # m; nearer than this the far field of a facet is that of 16 m: no marine antenna observes nearer bodies
FACET_SETS = 4  # kept: a body passes from one half octave of range to the next
TUBES_ACROSS = 24  # tubes across a flat patch that bounces: their ragged edge is then some 1 % of its area
SHORTEST = 1.0 / 6.0  # of a wavelength: finer tubes than this gain nothing (docs/engine.md#errors)


@dataclass(frozen=True)
class OpticalBody:
    """A mesh that scatters by physical optics.

    mesh, planes, scene: the triangles, their planes, and their ray tests.
    wave: wavelength and polarization.
    max_edge: longest edge of a facet [m], wherever it is observed from.
    bounces: surfaces in a row that a ray tube follows.
    reflectivity: power ratio at each surface.
    may_rebounce: (F, 2) whether there is anything to hit before the front and the back of each triangle.
    patch: (F,) size of the flat patch of each triangle [m].
    outside: (F,) as from `outward_side`.
    facets: by their longest edge; the ranges of a few half octaves are kept.
    """

    mesh: Mesh
    planes: Planes
    wave: Wave
    max_edge: float
    bounces: int
    reflectivity: float
    scene: TriangleScene
    may_rebounce: Flags
    patch: Floats
    outside: NDArray[np.int8]
    facets: BlockCache[float, Facets]

    def echoes(self, launch: Floats, receive: Floats, lit: Visible, visible: Visible) -> tuple[Floats, Complexes]:
        """Phase centres (C, 3) [m] and scattering amplitudes (C,) [m] between two points (3,), in the body's own frame.

        lit, visible: which points (M, 3) on triangles (M,) of the mesh have a line of sight to launch, and to receive.
        """
        nearest = float(np.linalg.norm(receive - self.scene.centre)) - self.scene.radius
        edge = longest_edge(nearest, self.max_edge, self.wave.wavelength)
        tubes = illuminated_facets(self.facets_of(edge), self.planes, self.outside, launch, self.wave, lit)
        points, amplitudes = [np.zeros((0, 3))], [np.zeros(0, dtype=np.complex128)]
        for bounce, arrived in enumerate(hits(tubes, self.planes, self.scene, self.may_rebounce, self.bounces)):
            back = arrived
            if bounce > 0 or receive is not launch:
                back = arrived.chosen(np.flatnonzero(visible(arrived.centre, arrived.triangle)))
            point, amplitude = scattered_field(back, launch, receive, self.wave)
            points.append(point)
            amplitudes.append(amplitude * self.reflectivity ** ((bounce + 1) / 2.0))
        merged = np.concatenate(points), np.concatenate(amplitudes)
        return scattering_centres(*merged, launch, receive, edge, self.wave.wavenumber)

    def coherence(self, distance: float) -> float:
        """As `PhysicalOptics.coherence`."""
        edge = longest_edge(distance - self.scene.radius, self.max_edge, self.wave.wavelength)
        return WIDER * edge

    def facets_of(self, edge: float) -> Facets:
        """The mesh cut to this longest edge [m], finer where its flat patches reflect onto other parts of it."""
        return self.facets.get(edge, lambda: self._cut(edge))

    def _cut(self, edge: float) -> Facets:
        tube = np.clip(self.patch / TUBES_ACROSS, SHORTEST * self.wave.wavelength, edge)
        reflects = self.may_rebounce.any(axis=1) & (self.bounces > 1)
        return cut_facets(self.mesh, np.where(reflects, tube, edge), edge)


def facet_enlargement(body: Body, radar: Radar, distance: float) -> float:
    """How many times longer than requested the facets of a large body are at `distance` [m]; 1 where they are not."""
    assert body.mesh is not None
    limit = longest_edge(distance, radar.range_resolution, radar.wavelength)
    _, _, area = triangle_frames(body.mesh)
    if len(area) + 16.0 * area.sum() / limit**2 <= MAX_FACETS:  # halving leaves some limit^2 / 8 a piece, slivers less
        return 1.0
    return cut_facets(body.mesh, np.full(len(area), limit), limit, max_tubes=0).enlargement


def longest_edge(distance: float, edge: float, wavelength: float) -> float:
    """`edge` [m], or the far field's limit where that is shorter, the same throughout half an octave of distance [m]."""
    octave = np.floor(2.0 * np.log2(max(distance, NEAREST))) / 2.0
    return min(edge, far_field_edge(float(2.0**octave), wavelength))


def optical_body(body: Body, radar: Radar, bounces: int, rays: RayCount | None = None) -> OpticalBody:
    """A body with a mesh, prepared for this radar: no facet is longer than the range resolution. rays: counts rays."""
    assert body.mesh is not None
    mesh = body.mesh
    return OpticalBody(
        mesh,
        Planes(*triangle_frames(mesh)[:2]),
        Wave(radar.wavelength, radar.polarization),
        radar.range_resolution,
        bounces,
        power_reflectivity(body.material.name),
        TriangleScene(mesh.vertices, mesh.faces, rays),
        concave_sides(mesh),
        patch_sizes(mesh),
        outward_side(mesh),
        BlockCache(FACET_SETS),
    )
