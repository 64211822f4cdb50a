"""Where ray tubes hit a body after reflection: traced by a few rays, halved and cut where these hit different planes.

Rays at the centre of a tube and near its corners are traced. Where they hit different planes, the tube is halved, or cut in a
straight line along the edge between two planes, if a few more rays agree with that. Rays only bracket the edge: where an edge
of a triangle crosses the bracket, it is computed.
"""

from collections.abc import Iterator
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from radar_service.kernels.library import KERNELS, run_with_rays
from radar_service.numerics.types import Flags, Floats, Indices
from radar_service.scattering.physical_optics.facet_integral import specular_reflection
from radar_service.scattering.physical_optics.lit_facets import Planes
from radar_service.scattering.physical_optics.ray_tubes import EVERY, RayTubes, dot
from radar_service.trace.embree import RotatedScene, TriangleScene
from radar_service.world.body import Mesh

MAX_HALVINGS = 9
CUT_LEVEL = 1  # halvings before a tube may be cut: a whole one is sampled too sparsely to know that one line divides it
MAX_DIVIDED = (2_000, 500)  # tubes at the second surface and at each later one, those of large area first
GRAZING = 0.01  # cosine below which a footprint is over a hundred tubes long, and its middle ray no longer represents it


Rays = TriangleScene | RotatedScene


class Ends(NamedTuple):
    """The triangles (F,) of a mesh where tubes end: whether any leg that receives reaches them; their rank; and the length of
    edges below which tubes on them are not divided [m]."""

    mesh: Mesh
    lit: Flags
    rank: Indices
    smallest: Floats


def hits(tubes: RayTubes, planes: Planes, scene: Rays, bounces: int, ends: Ends) -> Iterator[RayTubes]:
    """The tubes after each reflection at a surface, up to `bounces` surfaces in all, the first one counted."""
    tubes = replace(tubes, chain=np.pad(tubes.chain, ((0, bounces - 1), (0, 0)), constant_values=-1))
    for bounce in range(2, bounces + 1):
        count = MAX_DIVIDED[min(bounce - 2, 1)]
        tubes = _reflected(tubes.chosen(_may_hit_more(tubes, planes)), planes, scene, ends, bounce == bounces, count)
        if not len(tubes):
            return
        yield tubes


def _reflected(tubes: RayTubes, planes: Planes, scene: Rays, ends: Ends, last: bool, count: int) -> RayTubes:
    """The tubes that hit another surface of the body after reflection at this one, divided where parts of one hit different
    planes; last: without those that do not count there."""
    direction, field = specular_reflection(tubes.direction.T, tubes.field.T, tubes.normal.T)
    tubes = replace(tubes, direction=np.ascontiguousarray(direction.T), field=np.ascontiguousarray(field.T))
    launch, rank = tubes.launch, np.append(np.where(ends.lit, ends.rank, EVERY - 1), EVERY - 1)
    columns = [
        tubes.corners, tubes.centre, tubes.normal, tubes.direction, tubes.field, tubes.begin, tubes.length, tubes.launched,
        tubes.triangle, tubes.bounces, launch.direction, launch.field, launch.least, launch.longest, ends.mesh.vertices,
        ends.mesh.faces, rank, ends.smallest, planes.number, planes.point, planes.normal, scene.centre,
    ]  # fmt: skip
    sizes = (len(tubes), len(ends.lit), len(launch.least), last, count, MAX_HALVINGS, CUT_LEVEL)
    address = np.zeros(1, dtype=np.int64)
    taken = [np.ascontiguousarray(column) for column in columns]
    rotation = np.ascontiguousarray(scene.rotation)
    number = run_with_rays(KERNELS.reflect_tubes, scene.first_hit_of, *sizes, *taken, scene.radius, rotation, address)
    parent, triangle = np.empty(number, dtype=np.int64), np.empty(number, dtype=np.int64)
    corners, vectors, length = np.empty((3, 3, number)), np.empty((4, 3, number)), np.empty(number)
    KERNELS.take_tubes(number, int(address[0]), parent, triangle, corners, *vectors, length)
    centre, normal, direction, begin = vectors
    arrived = tubes.chosen(parent)
    arrived.chain[arrived.bounces, np.arange(number)] = triangle
    return replace(
        arrived, corners=corners, centre=centre, normal=normal, triangle=triangle, direction=direction, length=length,
        begin=begin, bounces=arrived.bounces + 1,
    )  # fmt: skip


def _may_hit_more(tubes: RayTubes, planes: Planes) -> Indices:
    front = dot(tubes.normal, planes.normal.take(tubes.triangle, axis=0).T) > 0.0
    return np.flatnonzero(planes.may_rebounce[tubes.triangle, np.where(front, 0, 1)])
