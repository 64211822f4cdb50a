"""Shadows of convex bodies on faces against rays of many short steps, each of which is in a body or not."""

import numpy as np
import pytest

from tests.reference import metal_on_water as oracle
from tests.reference import ship_fields, ship_tracks
from tests.reference.cast_shadows import in_front, lit_pieces
from tests.reference.metal_on_water import Floats
from tests.reference.ship_draws import STEP, Case, drawn

WITHIN = 0.02  # m: the edge of a shadow may be off by so much
STEPS = np.linspace(0.0, 1.0, 60_000)[1:-1, None]


def inside(points: Floats, table: dict, stand: ship_tracks.Stand, own: Floats, margin: float) -> bool:
    """Whether any of the points (M, 3) about the antenna is above the sea and in a box, which is wider by a margin [m]."""
    local = (points + own - stand.position) @ stand.rotation - (0.0, 0.0, table["height_m"] / 2.0)
    half = np.array([table["width_m"], table["length_m"], table["height_m"]]) / 2.0 + margin
    return bool(((np.abs(local) < half).all(axis=1) & (points[:, 2] > -margin)).any())


def blocked(
    legs: list[Floats], rest: list[tuple[dict, list[Floats]]], own: Floats, time: float, case: Case, margin: float
) -> bool:
    """Whether a way (of legs (M, 3)) meets any of the bodies, which are wider by a margin [m]."""
    stands = [(table, ship_tracks.stand(table, time, case.tracks)) for table, _ in rest]
    return any(inside(raised(leg, case), *each, own, margin) for leg in legs for each in stands)


def raised(points: Floats, case: Case) -> Floats:
    """Points (M, 3) of straight lines, with their heights above the curved sea."""
    lifted = points.copy()
    lifted[:, 2] += (points[:, 0] ** 2 + points[:, 1] ** 2) / (2.0 * case.setting.earth_radius)
    return lifted


def ways(point: Floats, case: Case) -> tuple[list[Floats], list[Floats]]:
    """Points (M, 3) along the direct way to a point, and along the way by the sea."""
    antenna, end = np.array([0.0, 0.0, case.setting.antenna_height]), oracle.bent(point[None], case.setting)[0]
    distance = np.hypot(*point[:2])
    args = np.array([distance]), point[2:], case.setting.antenna_height, case.setting.earth_radius
    x = float(oracle.reflection_distance(*args)[0])
    foot = np.array([*(point[:2] * x / distance), -(x**2) / (2.0 * case.setting.earth_radius)])
    legs = [antenna + STEPS * (end - antenna)], [antenna + STEPS * (foot - antenna), foot + STEPS * (end - foot)]
    return legs[0], legs[1]


@pytest.mark.sample(3)
@pytest.mark.parametrize("number", [18, 27, 28, 38, 47, 9, 19, 29])
def test_pieces_are_lit_as_rays_say(number: int) -> None:
    """Two points of each piece of each face, by both ways. Points within 2 cm of an edge may be either."""
    case = drawn(number, 5)
    time = case.crossing * STEP
    own = ship_tracks.stand(case.own, time, case.tracks).position
    solids = [ship_fields.solid(table, time, own, case).faces for table in case.bodies]
    rest = list(zip(case.bodies[1:], solids[1:], strict=True))
    middle = np.concatenate(solids[0]).mean(axis=0)[:2]
    rng, judged = np.random.default_rng(number), 0
    for face in solids[0][:4]:
        dry = oracle.dry(face)
        before = [in_front(solid, solids[0]) for _, solid in rest]
        pieces = lit_pieces(dry, [solid for _, solid in rest], before, middle / np.hypot(*middle), case.setting)
        for _ in range(4):
            point = rng.dirichlet(np.ones(len(dry))) @ dry
            here = [piece for piece in pieces if holds(piece.corners, point)]
            for flag, legs in zip((any(p.direct for p in here), any(p.sea for p in here)), ways(point, case), strict=True):
                if blocked(legs, rest, own, time, case, -WITHIN) == (dark := blocked(legs, rest, own, time, case, WITHIN)):
                    judged += 1
                    assert flag == (not dark and (case.setting.sea or len(legs) == 1)), (str(case), point)
    assert judged > 16


def holds(corners: Floats, point: Floats) -> bool:
    """Whether a flat convex polygon (V, 3) has a point of its plane."""
    edges, offset = np.roll(corners, -1, axis=0) - corners, point - corners
    turns = np.cross(edges, offset)
    normal = np.cross(corners[1] - corners[0], corners[2] - corners[0])
    return bool((turns @ normal >= -1e-9).all())


def test_the_nearer_body_stands_in_front() -> None:
    square = np.array([(-1.0, 9.0, 0.0), (1.0, 9.0, 0.0), (1.0, 11.0, 0.0), (-1.0, 11.0, 0.0)])
    assert in_front([square], [square + (0.5, 5.0, 0.0)]) and not in_front([square + (0.5, 5.0, 0.0)], [square])
    with pytest.raises(ValueError, match="touch"):
        in_front([square], [square + (0.5, 0.5, 0.0)])
