"""Places of bodies that are allowed and odd: below the sea, under the ground, at the antenna, round the antenna."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from radar_service.frames import map_from_body
from radar_service.scene.world import Body, Scene

Floats = NDArray[np.float64]
FEW = 16  # points of a body, besides its highest, that must lie under the ground for it to be called buried
ASIDE = np.array([1.7e-6, 2.3e-6])  # m: a plumb line through a corner would count its triangles once each


def odd_places(scene: Scene, terrain: Sequence[int] = ()) -> tuple[str, ...]:
    """A sentence for each body whose place at the start is odd, with what becomes of its echo.

    terrain: which bodies are ground that others may lie under.
    """
    antenna = scene.antenna(0.0)[0]
    ground = [Ground(scene.bodies[i]) for i in terrain if len(scene.bodies) > len(terrain)]
    return tuple(
        said
        for i, body in enumerate(scene.bodies)
        if (said := _oddity(body, f"body[{i}]", antenna, scene, () if i in terrain else ground))
    )


class Ground:
    """A height map, asked what lies under it."""

    def __init__(self, body: Body) -> None:
        assert body.mesh is not None
        corners = _corners_on_the_map(body)[body.mesh.faces]
        west = corners[:, :, 0].min(axis=1)
        order = np.argsort(west)
        self.name, self._corners, self._west = body.name, corners[order], west[order]
        self._widest = float(np.ptp(corners[:, :, 0], axis=1).max())

    def covers(self, points: Floats) -> bool:
        """Whether it rises over the highest of points (P, 3) [m], and over a few others of them as well."""
        few = points[:: max(1, len(points) // FEW)]
        return all(self._covers(point) for point in (points[np.argmax(points[:, 2])], *few))

    def _covers(self, point: Floats) -> bool:
        first, end = np.searchsorted(self._west, [point[0] - self._widest - 1.0, point[0] + 1.0])
        near = self._corners[first:end].reshape(-1, 3)
        return len(near) > 0 and surfaces_above(near, np.arange(len(near)).reshape(-1, 3), point) > 0


def _corners_on_the_map(body: Body) -> Floats:
    """Vertices (V, 3) [m] of a body as it stands at the start, or the place (1, 3) of a point."""
    pose = body.motion.pose(max(float(body.motion.time[0]), 0.0))
    points = np.zeros((1, 3)) if body.mesh is None else body.mesh.vertices
    return map_from_body(points, pose.position[0], float(pose.heading[0]))


def _oddity(body: Body, place: str, antenna: Floats, scene: Scene, grounds: Sequence[Ground]) -> str:
    corners = _corners_on_the_map(body)
    if corners[:, 2].max() < 0.0:
        return f"{place}: {body.name} lies wholly below the sea, so nothing of it is seen; raise it"
    over = [ground.name for ground in grounds if ground.covers(corners)]
    if over:
        return f"{place}: {body.name} lies under the ground of {over[0]}, so nothing of it is seen; raise it"
    if body.mesh is None:
        distance, nearest = float(np.linalg.norm(corners[0] - antenna)), scene.radar.range_min
        if distance >= nearest:
            return ""
        return (
            f"{place}: {body.name} stands {distance:.3g} m from the antenna; its echo is that of range_min_m, {nearest:g} m"
        )
    if surfaces_above(corners, body.mesh.faces, antenna) % 2 == 0:
        return ""
    return f"{place}: the antenna stands in or under {body.name}, which then hides all else from it; move one of the two"


def surfaces_above(vertices: Floats, faces: NDArray[np.int64], point: Floats) -> int:
    """How many triangles, faces (F, 3) of vertices (V, 3) [m], a plumb line meets above `point` (3,) [m]."""
    place = point[:2] + ASIDE
    if (vertices[:, :2].min(axis=0) > place).any() or (vertices[:, :2].max(axis=0) < place).any():
        return 0
    east, north = (vertices[:, axis][faces] - place[axis] for axis in (0, 1))
    around = (east.min(axis=1) <= 0) & (east.max(axis=1) >= 0) & (north.min(axis=1) <= 0) & (north.max(axis=1) >= 0)
    near = np.flatnonzero(around)
    e, n, up = east[near], north[near], vertices[:, 2][faces[near]]
    # twice the areas that the plumb line cuts the triangle into: all of one sign inside
    share = np.stack([e[:, i] * n[:, j] - e[:, j] * n[:, i] for i, j in ((1, 2), (2, 0), (0, 1))], axis=1)
    inside = (share > 0).all(axis=1) | (share < 0).all(axis=1)
    height = np.einsum("ij,ij->i", share[inside], up[inside]) / share[inside].sum(axis=1)
    return int(np.count_nonzero(height > point[2]))
