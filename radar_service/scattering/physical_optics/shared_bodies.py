"""Bodies prepared for physical optics, where equal ones share what does not depend on their motion."""

from collections import Counter
from collections.abc import Sequence

from radar_service.radar.parameters import Radar
from radar_service.scattering.physical_optics.optical_body import OpticalBody, optical_body
from radar_service.scene.body import Body
from radar_service.trace.embree import RayCount
from radar_service.trace.tree_cache import content_key

MAX_SHARES = 8  # bodies that a cache of facets is enlarged for: others are at the same half octaves of range as these


def optical_bodies(bodies: Sequence[Body], radar: Radar, bounces: int, rays: RayCount | None = None) -> list[OpticalBody]:
    """`optical_body` of each body. Those of equal meshes and materials are one object. rays: counts rays."""
    keys = [_key(body) for body in bodies]
    result: dict[tuple[bytes, str], OpticalBody] = {}
    for key, body in zip(keys, bodies, strict=True):
        if key not in result:
            result[key] = optical_body(body, radar, bounces, rays)
    for key, count in Counter(keys).items():
        result[key].facets.grow(result[key].facets.size * min(count, MAX_SHARES))
    return [result[key] for key in keys]


def _key(body: Body) -> tuple[bytes, str]:
    assert body.mesh is not None
    return content_key(body.mesh.vertices, body.mesh.faces), body.material.name
