"""The facets of a body, coarse and fine: shadows are found on coarse ones, phases are integrated over fine ones."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from radar_service.scattering.physical_optics.blocks import Block
from radar_service.scattering.physical_optics.facets import cut_facets, cut_triangles
from radar_service.scattering.physical_optics.lit_facets import Surface
from radar_service.scene.body import Mesh
from radar_service.types import Floats, Indices

SHADOW_EDGE = 4.0  # m; shadows are sampled at a pitch of 2 m at least


@dataclass(frozen=True)
class BodyFacets:
    """Coarse facets (M,) and the fine ones that they consist of (N,).

    surface: the coarse facets.
    fine: (N, 3, 3) corners of the fine ones [m], in the order of the coarse ones.
    first: (M + 1,) index of the first fine one of each coarse one, and their number.
    """

    surface: Surface
    fine: Floats
    first: Indices

    @classmethod
    def joined(cls, parts: "Sequence[BodyFacets]") -> "BodyFacets":
        """The facets of several parts of a body."""
        if len(parts) == 1:
            return parts[0]
        surface = parts[0].surface
        for part in parts[1:]:
            surface = surface.joined(part.surface)
        counts = np.concatenate([np.diff(part.first) for part in parts])
        surface = replace(surface, facet=np.arange(len(surface)))
        return cls(surface, np.concatenate([part.fine for part in parts]), _starts(counts))

    def cut(self, surface: Surface) -> tuple[Floats, Indices]:
        """Fine facets (K, 3, 3) of triangles of the body, and the triangle that each comes from (K,)."""
        whole, parts = np.flatnonzero(surface.facet >= 0), np.flatnonzero(surface.facet < 0)
        facet = surface.facet[whole]
        counts = self.first[facet + 1] - self.first[facet]
        begin = np.repeat(self.first[facet] - _starts(counts)[:-1], counts)
        fine = self.fine.take(begin + np.arange(len(begin)), axis=0)
        cut, origin = cut_triangles(surface.corners[parts], surface.longest[parts])
        return np.concatenate([fine, cut]), np.concatenate([np.repeat(whole, counts), parts[origin]])


def body_facets(block: Block, cell: float, edge: float, tubes: Floats, max_tubes: int) -> BodyFacets:
    """The facets of a block, summed in cells of size `cell` [m]: coarse ones with edges of at most SHADOW_EDGE, fine ones with
    edges of at most `edge`, and at most `tubes` (F,) on each of the block's triangles."""
    coarse, origin = cut_triangles(block.mesh.vertices[block.mesh.faces], SHADOW_EDGE)
    count = len(coarse)
    mesh = Mesh(coarse.reshape(-1, 3), np.arange(3 * count).reshape(-1, 3))
    fine = cut_facets(mesh, tubes[origin], edge, max_tubes)
    none = np.zeros((count, 0))
    sizes = np.full(count, cell)
    surface = Surface(coarse, block.triangle[origin], np.arange(count), sizes, fine.longest, none.astype(np.int8), none)
    return BodyFacets(surface, fine.corners, _starts(np.bincount(fine.triangle, minlength=count)))


def _starts(counts: Indices) -> Indices:
    return np.concatenate([np.zeros(1, dtype=np.int64), np.cumsum(counts)])
