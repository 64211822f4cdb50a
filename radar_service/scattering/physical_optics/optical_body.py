"""A body prepared for physical optics. Its columns are cut into facets once for each half octave of range."""

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from radar_service.numerics.result_cache import ResultCache
from radar_service.numerics.types import Flags, Floats, Indices
from radar_service.radar.parameters import Radar
from radar_service.scattering.physical_optics.body_columns import BodyColumn, body_columns
from radar_service.scattering.physical_optics.body_facets import BodyFacets, body_facets
from radar_service.scattering.physical_optics.body_legs import BodyLeg
from radar_service.scattering.physical_optics.convex_bodies import Centres, ConvexFacets
from radar_service.scattering.physical_optics.convex_sights import Casters, Sights
from radar_service.scattering.physical_optics.facets import MAX_FACETS, EdgeLimits, box_corners, cut_facets, edge_limits
from radar_service.scattering.physical_optics.illumination import Illumination, KeptTubes, lit_facets
from radar_service.scattering.physical_optics.lit_facets import LitFacets, Planes, Surface, lit_surface
from radar_service.scattering.physical_optics.patches import faces_itself, outward_side, patch_spans, ranks
from radar_service.scattering.physical_optics.path_centres import PATHS, PathCentres, flattest, over_nodes
from radar_service.scattering.physical_optics.path_fields import (
    PathFields,
    Wave,
    facet_fields,
    facet_phases,
    path_phasor,
    received_fields,
    tube_fields,
)
from radar_service.scattering.physical_optics.plating import PlatedWalls, plated_fields
from radar_service.scattering.physical_optics.ray_tubes import RayTubes, launched_tubes
from radar_service.scattering.physical_optics.scattering_centres import Lattice, strongest
from radar_service.scattering.physical_optics.triangle_cuts import above_water
from radar_service.scattering.physical_optics.tube_tracing import Ends, hits
from radar_service.scattering.surface_sampling import normals_and_areas
from radar_service.trace.embree import RayCount, TriangleScene
from radar_service.trace.tree_cache import content_key
from radar_service.world.body import Body, Mesh, Plating
from radar_service.world.materials import power_reflectivity

FACET_SETS = 4  # kept for each column: a body passes from one half octave of range to the next
MAX_SHARES = 8  # bodies that a cache of facets is enlarged for: others are at the same half octaves of range as these
TUBES_ACROSS = 24  # tubes across a flat patch, where they are divided: their ragged edge is then some 1 % of its area
SHORTEST = 1.0 / 6.0  # of a wavelength: finer tubes than this gain nothing (docs/engine.md#errors)
FAINT = 0.03  # power ratio of the way by the sea below which bounces that take it twice are left out: they err by far more


class _Bounces(NamedTuple):
    """What leaves by one leg and returns by another: how many of the two go by the sea, the number of the leg back, tubes where
    they end, those of them `which` (M,) count, how often each counts (M,), and their fields."""

    ways: int
    back: int
    tubes: RayTubes
    which: Indices
    factor: Floats
    fields: PathFields


@dataclass(frozen=True)
class OpticalBody:
    """A mesh that scatters by physical optics.

    mesh, planes: the triangles and their planes. scene: the ray tests of the upright body.
    columns: parts of the mesh that are cut by their own distance.
    wave: wavelength and polarization.
    limits: what bounds facets and cells.
    bounces: surfaces in a row that a ray tube follows.
    reflectivity: power ratio at each surface.
    patch: (F,) size of the flat patch of each triangle [m].
    rank: (F,) of triangles by the size of their patches.
    outside: (F,) as from `outward_side`.
    facets: by column, cell and longest edge, of the upright body; those of a few half octaves are kept.
    convex: of a convex one, by cell, longest edge, height of the sea and number of legs.
    joined: the same of all columns, by the keys of each.
    walls: those that are dented between frames; None: there are none.
    lean: (3, 3) by which all else is rotated from the frame of the upright body; None: it is upright.
    """

    mesh: Mesh
    planes: Planes
    columns: tuple[BodyColumn, ...]
    wave: Wave
    limits: EdgeLimits
    bounces: int
    reflectivity: float
    scene: TriangleScene
    patch: Floats
    rank: Indices
    outside: NDArray[np.int8]
    facets: ResultCache[tuple[int, float, float], BodyFacets]
    convex: ResultCache[tuple[float, float, float, int], ConvexFacets | None]
    joined: ResultCache[tuple[tuple[int, float, float], ...], BodyFacets]
    walls: PlatedWalls | None = None
    lean: Floats | None = None

    @property
    def is_concave(self) -> bool:
        """Whether parts of it may face each other, so that it has bounces and shadows of its own."""
        return faces_itself(self.planes.may_rebounce, self.outside)

    @property
    def is_small_and_convex(self) -> bool:
        """Whether it is closed and convex, not dented, and cut by one distance."""
        return self.walls is None and not self.is_concave and len(self.columns) == 1 and bool((self.outside != 0).all())

    def dry_box(self, height: float) -> Floats:
        """The corners (8, 3) of the box around what rises above the sea, where the origin is at a height over it [m]."""
        low, high = self.mesh.vertices.min(axis=0), self.mesh.vertices.max(axis=0)
        low[2] = max(low[2], min(-height, high[2]))
        return box_corners(low, high)

    def centres_at(self, sights: Sights, casters: Casters, most: int) -> Centres | None:
        """The centres of a small convex body at instants; None where they have to be computed one after the other.

        most: triangles that cast shadows exactly.
        """
        water, (column,) = -float(sights.position[0, 2]), self.columns
        limits = [self.limits.at(column.distance(antenna)) for antenna in sights.antenna_in_frame]
        parts, instants = [], []
        for cell, edge in dict.fromkeys(limits):
            which = np.flatnonzero([each == (cell, edge) for each in limits])
            key = (cell, edge, water, sights.legs)
            facets = self.convex.get(key, partial(self._convex_facets, *key))
            part = facets and facets.centres(sights.chosen(which), casters.chosen(which), self.wave, self.reflectivity, most)
            if part is None:
                return None
            parts.append(part)
            instants.append(which)
        return parts[0] if len(parts) == 1 else Centres.joined(parts, instants)

    def _convex_facets(self, cell: float, edge: float, water: float, legs: int) -> ConvexFacets | None:
        facets = self.facets.get((0, cell, edge), partial(self._cut, 0, cell, edge))
        triangles = self.mesh.vertices[self.mesh.faces]
        return ConvexFacets.of(
            facets, self.mesh.used_vertices, triangles, self.planes, self.outside, water, legs, self.dry_box(-water)
        )

    def leaning(self, lean: Floats) -> "OpticalBody":
        """The same body rotated by a matrix (3, 3), so that the sea is level in its frame."""
        mesh = Mesh(self.mesh.vertices @ lean.T, self.mesh.faces)
        return replace(self, mesh=mesh, planes=self.planes.rotated(lean), lean=lean)

    def echoes(self, legs: tuple[BodyLeg, ...], water: float = -np.inf) -> list[PathCentres]:
        """The centres of each path of one leg, or of two: the direct one and the one by the sea.

        water: height of the sea in the body's frame [m]; nothing below it scatters.
        """
        surface, lit = self.lit_facets(legs, water)
        fields = [(bounces.ways, bounces.fields) for bounces in self._bounces(surface, legs, water)]
        return self._summed(lit, fields, legs, water)

    def illuminated(self, legs: tuple[BodyLeg, ...], water: float) -> Illumination:
        """What legs reach, for `echoes_near` at poses near by; water: as of `echoes`."""
        surface, lit = self.lit_facets(legs, water)
        kept = [
            KeptTubes.of(tubes.chosen(which), self.planes, self.lean, ways, back, factor)
            for ways, back, tubes, which, factor, _ in self._bounces(surface, legs, water)
        ]
        return Illumination.of(lit, self.lean, kept)

    def echoes_near(self, kept: Illumination, legs: tuple[BodyLeg, ...], water: float) -> list[PathCentres]:
        """The centres of each path, of what was traced at a pose near by; legs, water: as of `echoes`."""
        lit = kept.facets(self.planes, self.lean, legs, water)
        fields = []
        for group in kept.tubes:
            tubes = group.traced(self.planes, self.lean, legs, self.wave.polarization, water)
            receive = legs[group.back]
            field = received_fields(tubes, receive.rays(tubes.centre.T), receive, self.wave)
            fields.append((group.ways, field._replace(amplitude=field.amplitude * group.factor)))
        return self._summed(lit, fields, legs, water)

    def _summed(
        self, lit: LitFacets, tubes: list[tuple[int, PathFields]], legs: tuple[BodyLeg, ...], water: float
    ) -> list[PathCentres]:
        """The centres of each path, of facets and of tubes by path."""
        paths = PATHS if len(legs) > 1 else PATHS[:1]
        if self.walls is None:
            phases = facet_phases(lit, self.wave)
            fields = [facet_fields(lit, phases, out, back, self.wave) for out, back in paths]
        else:
            fields = plated_fields(self.walls, lit, self.planes, legs, self.lean, self.wave, paths)
        parts = [[field for ways, field in tubes if ways == out + back] for out, back in paths]
        position = np.concatenate([lit.points, *(field.position for part in parts for field in part)])
        cell = np.concatenate([lit.point_cell, *(field.cell for part in parts for field in part)])
        lattice = Lattice.over(position, cell, flattest(legs), water)
        lengths = [leg.length(lattice.nodes) for leg in legs]
        weights, received = (
            over_nodes(legs, lattice, lit.points, [part.both_ends for part in parts[0]]),
            legs[0].weight(lattice.nodes) ** 2,
        )
        result, begin = [], len(lit.points)
        for (out, back), field, part in zip(paths, fields, parts, strict=True):
            facets, tubes_there = weights[out + back]
            amplitude = np.concatenate([np.zeros(0, dtype=np.complex128), *(field.amplitude for field in part)])
            sums = lattice.sums(slice(len(lit.points)), field * self.reflectivity**0.5 * facets)
            sums += lattice.sums(slice(begin, begin + len(amplitude)), amplitude * tubes_there)
            begin += len(amplitude)
            sums *= path_phasor(-lengths[out] - lengths[back], self.wave)
            kept = strongest(np.abs(sums * received))
            result.append(PathCentres(out + back, lattice.nodes[kept], sums[kept]))
        return result

    def lit_facets(self, legs: tuple[BodyLeg, ...], water: float) -> tuple[Surface, LitFacets]:
        """What a leg reaches, above the water and past all shadows, and the facets of it, cut as finely as the phase needs."""
        sea = legs[0].sea
        longest = np.inf if sea is None else sea.longest
        facets = self.facets_near(legs[0].pose.frame_from_map(legs[0].antenna, np.inf), longest)
        above, origin = above_water(facets.surface.corners, water)
        surface = facets.surface.chosen(origin)
        surface = replace(surface, corners=above, facet=np.where((above == surface.corners).all((1, 2)), surface.facet, -1))
        lit = lit_surface(surface, legs, self.planes, self.outside, facets.samples)
        origin, corner, points = facets.cut(lit)
        part = lit.chosen(origin)
        facets_of_legs = lit_facets(points, corner, part.triangle, part.cell, part.side, part.share, self.planes, legs)
        return lit, facets_of_legs

    def _bounces(self, surface: Surface, legs: tuple[BodyLeg, ...], water: float) -> Iterator[_Bounces]:
        """What bounces on the body.

        Without tubes by the faint leg of the sea, those of the direct one stand for both orders of a mixed path.
        """
        if not self.is_concave:
            return
        reached = self._reached(surface, len(legs))
        launches = legs if legs[-1].strength ** 2 >= FAINT else legs[:1]
        every = [len(launches) < len(legs), True][: len(launches)]
        tubes = launched_tubes(surface, launches, self.wave.polarization, self.planes, self.rank, every)
        smallest = np.maximum(self.patch / TUBES_ACROSS, SHORTEST * self.wave.wavelength)
        ends = Ends(self.mesh, np.asarray(reached.any(axis=0)), self.rank, smallest)
        scene = self.scene if self.lean is None else self.scene.rotated(self.lean)
        arrived = list(hits(tubes, self.planes, scene, self.bounces, ends))
        if not arrived:
            return
        tubes = RayTubes.joined(arrived)
        out = tubes.launch.leg.take(tubes.launched)
        for back, receive in enumerate(legs):
            weight = self._weights(tubes, out, back, len(launches) < len(legs))
            which = np.flatnonzero((weight > 0.0) & reached[back, tubes.triangle] & (tubes.centre[2] > water))
            seen, fields = tube_fields(tubes.chosen(which), receive, self.wave)
            which = which[seen]
            factor = weight[which] * self.reflectivity ** (tubes.bounces[which] / 2.0)
            if self.walls is not None:
                factor *= self.walls.of_tubes(tubes.chosen(which), self.planes.normal)
            fields = fields._replace(amplitude=fields.amplitude * factor)
            for number in range(len(launches)):
                some = np.flatnonzero(out[which] == number)
                path = PathFields._make(column[some] for column in fields)
                yield _Bounces(number + back, back, tubes, which[some], factor[some], path)

    def _reached(self, surface: Surface, legs: int) -> Flags:
        """Which triangles (L, F) each leg reaches in part."""
        reached = np.zeros((legs, len(self.patch)), dtype=np.bool_)
        for number in range(legs):
            reached[number, surface.triangle[surface.share[:, number] > 0.0]] = True
        return reached

    def _weights(self, tubes: RayTubes, out: Indices, back: int, one_order: bool) -> Floats:
        """How often tubes (M,) count that leave by legs `out` (M,) and return by leg `back`.

        By reciprocity a path is alike the other way round. Tubes from the smaller of two surfaces sample the pair best, so they
        count for both ways. By the sea both ways each order counts; `one_order`: tubes of the direct leg stand for the sea's.
        """
        first, last = tubes.launch.rank.take(tubes.launched), self.rank.take(tubes.triangle)
        ranked = 1.0 + np.sign(last - first)
        if back == 0:
            return np.asarray(ranked)
        return np.where(out > 0, 1.0, 2.0 if one_order else ranked)

    def coherence(self, distance: float) -> float:
        """Size [m] over which phases are summed into one echo at `distance` [m]."""
        nearest = distance - self.scene.radius
        return max(self.limits.at(nearest))

    def facets_near(self, antenna: Floats, longest: float = np.inf) -> BodyFacets:
        """The facets for an antenna (3,) in the body's frame [m], each column as its own distance asks, upright or not.

        longest: edge that no facet exceeds [m].
        """
        limits = [self.limits.at(column.distance(antenna)) for column in self.columns]
        keys = tuple((number, cell, min(edge, longest)) for number, (cell, edge) in enumerate(limits))
        facets = self.joined.get(
            keys, lambda: BodyFacets.joined([self.facets.get(key, partial(self._cut, *key)) for key in keys])
        )
        return facets if self.lean is None else facets.rotated(self.lean)

    def _cut(self, number: int, cell: float, edge: float) -> BodyFacets:
        """A column cut to this longest edge [m]."""
        return body_facets(self.columns[number], cell, edge)


def facet_enlargement(body: Body, radar: Radar, distance: float) -> float:
    """How many times longer than requested the largest column's facets are at `distance` [m]; 1 where they are not."""
    assert body.mesh is not None
    limit = edge_limits(radar, body.mesh).longest_edge(distance)
    area, largest = max(
        ((float(normals_and_areas(b.mesh)[1].sum()), b.mesh) for b in body_columns(body.mesh)),
        key=lambda area_and_mesh: area_and_mesh[0],
    )
    if len(largest.faces) + 16.0 * area / limit**2 <= MAX_FACETS:  # halving leaves some limit^2 / 8 a piece, slivers less
        return 1.0
    return cut_facets(largest, limit).enlargement


def optical_body(body: Body, radar: Radar, bounces: int, rays: RayCount | None = None) -> OpticalBody:
    """A body with a mesh, prepared for this radar. rays: counts rays."""
    assert body.mesh is not None
    mesh, parts = body.mesh, body_columns(body.mesh)
    spans, planes = patch_spans(mesh), Planes.of(mesh)
    patch = np.asarray(np.linalg.norm(spans, axis=1))
    return OpticalBody(
        mesh,
        planes,
        parts,
        Wave(radar.wavelength, radar.polarization),
        edge_limits(radar, mesh),
        bounces,
        power_reflectivity(body.material.name),
        TriangleScene(mesh.vertices, mesh.faces, rays),
        patch,
        ranks(patch),
        outward_side(mesh),
        ResultCache(FACET_SETS * len(parts)),
        ResultCache(FACET_SETS),
        ResultCache(1),
        PlatedWalls.of(mesh, planes.normal, spans, body.plating, radar.wavelength),
    )


def optical_bodies(bodies: Sequence[Body], radar: Radar, bounces: int, rays: RayCount | None = None) -> list[OpticalBody]:
    """`optical_body` of each body. Those of equal meshes, materials and plating are one object. rays: counts rays."""
    keys = [_key(body) for body in bodies]
    result: dict[tuple[bytes, str, Plating | None], OpticalBody] = {}
    for key, body in zip(keys, bodies, strict=True):
        if key not in result:
            result[key] = optical_body(body, radar, bounces, rays)
    for key, count in Counter(keys).items():
        for cache in (result[key].facets, result[key].joined, result[key].convex):
            cache.grow(cache.size * min(count, MAX_SHARES))
    return [result[key] for key in keys]


def _key(body: Body) -> tuple[bytes, str, Plating | None]:
    assert body.mesh is not None
    return content_key(body.mesh.vertices, body.mesh.faces), body.material.name, body.plating
