"""Reflection by land: against a slow search along the profile, roughness by material, and who takes what from which ground."""

from typing import Any

import numpy as np
import pytest

import radar_service as rs
from radar_service.numerics.types import Complexes, Floats
from radar_service.propagation.land_reflection import LandBefore
from radar_service.propagation.radar_equation import elevation_gain, radar_two_rays
from radar_service.trace.line_of_sight import OcclusionScene
from radar_service.world.body import GROUND_ROUGHNESS, permittivity
from tests.reference.reflecting_ground import Piece, angles, factor, reflection, water
from tests.scenes import point, scene

EARTH = 4 / 3 * 6_371_000.0
RADAR = {"height_m": 18.0, "beamwidth_el_deg": 20.0}


def slab(name: str, begin: float, end: float, up: float, material: str, **more: Any) -> dict[str, Any]:
    """Land of one height across the way to the north, between two distances [m]."""
    size = {"length_m": end - begin, "width_m": 60.0, "height_m": up}
    return {"name": name, "shape": "box", "material": material, "position_m": [0, (begin + end) / 2, 0], **size, **more}


def ground(slab_at: dict[str, Any]) -> list[Piece]:
    """Water before a slab, and the slab."""
    begin = slab_at["position_m"][1] - slab_at["length_m"] / 2
    name, end = slab_at["material"], begin + slab_at["length_m"]
    e, rough = (permittivity(name), GROUND_ROUGHNESS[name]) if name in GROUND_ROUGHNESS else (0.0, 0.0)
    return [water(begin), Piece(end, slab_at["height_m"], e, rough)]


def engine_factor(made: rs.Scene, distance: Floats, height: Floats, body: int) -> Complexes:
    """F of parts of a body of a scene, due north."""
    radius = EARTH if np.isfinite(made.environment.earth_factor) else np.inf
    antenna = np.array([0.0, 0.0, made.radar.height])
    offset = np.stack([0.0 * distance, distance, height - antenna[2]], axis=-1)
    land = LandBefore(OcclusionScene(made.bodies, radius), antenna, offset, np.full(distance.shape, body))
    rays = radar_two_rays(made.radar, made.environment, distance, height, antenna[2], land=land)
    return np.asarray(1.0 + rays.ratio * np.exp(-2j * np.pi / made.radar.wavelength * rays.geometry.excess))


@pytest.mark.parametrize("earth", [EARTH, np.inf])
@pytest.mark.parametrize(
    ("material", "polarization"), [("concrete", "h"), ("sand", "v"), ("land", "h"), ("vegetation", "v")]
)
def test_the_field_is_that_of_a_search_along_the_profile(material: str, polarization: str, earth: float) -> None:
    """Targets over a slab and behind it, 1 to 40 m high: water reflects to some, land of 3 m to others, nothing where the point
    of reflection on either lies on the other. Points within a cell of the mask of an edge (1.5 m) are left out. Over land both
    agree to 1e-5: the search has the point of reflection to 1e-9 m, and the mask rounds heights to 1e-7; over water to 3e-3, as
    the search knows its permittivity to 0.1."""
    land = slab("land", 700.0, 2500.0, 3.0, material)
    flat = {} if np.isfinite(earth) else {"earth": "flat"}
    made = scene(
        [land, point("t", 0, 100)], radar=RADAR | {"polarization": polarization}, environment={"multipath": True, **flat}
    )
    rng = np.random.default_rng(4)
    distance, height = rng.uniform(300.0, 3500.0, 60), 3.0 + 10.0 ** rng.uniform(-0.5, 1.6, 60)
    profile, kinds = [*ground(land), water(1e4)], []

    def gain(elevation: float) -> float:
        return float(elevation_gain(made.radar, np.array([elevation]))[0])

    result = engine_factor(made, distance, height, 1)
    for d, h, value in zip(distance.tolist(), height.tolist(), result.tolist(), strict=True):
        place = reflection(d, h, 18.0, profile, earth)
        edges = [abs(np.subtract(*angles(x, d, h, 18.0, up, earth))) * d for x in (700.0, 2500.0) for up in (0.0, 3.0)]
        if min(edges) > 0.2 and (place is None or min(abs(place[0] - 700.0), abs(place[0] - 2500.0)) > 1.5):
            kinds.append(None if place is None else place[1].height)
            expected = factor(d, h, 18.0, profile, earth, polarization, gain)
            assert value == pytest.approx(expected, abs=1e-5 if kinds[-1] else 3e-3), (d, h)
    assert kinds.count(0.0) > 10 and kinds.count(3.0) > 10


def test_roughness_at_a_third_of_a_degree() -> None:
    """At 0.31 degrees a surface of 0.02, 0.1, 0.3 and 1 m rms leaves 1.00, 0.98, 0.81 and 0.10 of the field that a smooth one
    reflects (8 (pi s sin psi / lambda)^2 = 0.0009, 0.023, 0.20, 2.3), rock and towns nothing; vegetation has no reflection."""
    left, distance = {}, np.array([2772.0])  # 7.5 m + 7.5 m over that distance
    for material in (*GROUND_ROUGHNESS, "vegetation"):
        made = scene([slab("land", 100.0, 4000.0, 1e-3, material), point("t", 0, 100)], radar={"height_m": 7.5},
                     environment={"multipath": True, "earth": "flat"})  # fmt: skip
        value = complex(engine_factor(made, distance, 0.0 * distance + 7.5, 1)[0])
        sine, root = 15.0 / 2772.0, np.sqrt(permittivity(material) - 1.0)
        left[material] = abs(value - 1.0) * (root + sine) / (root - sine)
    expected = {"concrete": 1.0, "ice": 0.98, "sand": 0.81, "land": 0.1, "vegetation": 0.0}
    assert left == pytest.approx(dict.fromkeys((*GROUND_ROUGHNESS, "vegetation"), 0.0) | expected, abs=6e-3)


def island(name: str, north: float, material: str, **more: Any) -> dict[str, Any]:
    """A slab of 600 m at a distance [m], 2 m high."""
    return slab(name, north, north + 600.0, 2.0, material, **more)


@pytest.mark.parametrize(
    ("target", "distance", "height", "factor_is_one"),
    [
        (0, 1550.0, 2.0, True),  # diffuse land over its own ground
        (1, 1550.0, 2.1, True),  # a diffuse building on it: one landmass
        (2, 1550.0, 2.1, False),  # a point on it
        (3, 2700.0, 5.0, False),  # other diffuse land, behind water: the island before it reflects
        (0, 1100.0, 2.0, False),  # over water
    ],
)
def test_diffuse_land_takes_nothing_from_its_own_ground_alone(
    target: int, distance: float, height: float, factor_is_one: bool
) -> None:
    """An island of sand at 1 to 1.6 km, what stands on it, and another one behind it at 2.6 km."""
    house = {"name": "house", "shape": "box", "material": "building", "length_m": 4, "width_m": 4, "height_m": 8}
    bodies = [
        island("near", 1000.0, "sand"), {**house, "position_m": [0, 1550, 0]}, point("mark", 0, 1550, 2.1),
        slab("far", 2600.0, 3200.0, 5.0, "land"),
    ]  # fmt: skip
    made = scene(bodies, radar={"height_m": 4.0}, environment={"multipath": True, "earth": "flat"})
    value = complex(engine_factor(made, np.array([distance]), np.array([height]), target)[0])
    assert (value == 1.0) is factor_is_one, value


def test_shapes_broadcast_and_nothing_depends_on_the_others() -> None:
    """Targets (3, 5) before three antennas have what each has alone, to the bit."""
    made = scene(
        [slab("land", 500.0, 1500.0, 2.0, "concrete"), point("t", 0, 100)], radar=RADAR, environment={"multipath": True}
    )
    rng, sight = np.random.default_rng(1), OcclusionScene(made.bodies, EARTH)
    antenna = np.column_stack([rng.uniform(-5, 5, 3), rng.uniform(-5, 300, 3), rng.uniform(10, 20, 3)])
    position = np.stack([rng.uniform(-20, 20, (3, 5)), rng.uniform(400, 2500, (3, 5)), rng.uniform(2.5, 9, (3, 5))], axis=-1)
    offset, body = position - antenna[:, None], np.array([1, 1, 1, 1, 1])
    distance = np.hypot(offset[..., 0], offset[..., 1])
    land = LandBefore(sight, antenna[:, None], offset, body)
    rays = radar_two_rays(made.radar, made.environment, distance, position[..., 2], antenna[:, None, 2], land=land)
    assert np.ptp(np.broadcast_to(rays.level, distance.shape)) == 2.0  # some by water, some by land
    for k, e in np.ndindex(3, 5):
        land = LandBefore(sight, antenna[k], offset[k, e : e + 1], body[:1])
        alone = radar_two_rays(
            made.radar, made.environment, distance[k, e : e + 1], position[k, e : e + 1, 2], antenna[k, 2], land=land
        )
        assert alone.ratio[0] == rays.ratio[k, e] and alone.geometry.excess[0] == rays.geometry.excess[k, e]


def test_no_reflection_below_the_ground_nor_beside_the_land() -> None:
    """A target, or an antenna, below the height of the land before it, and one whose way meets the plane beyond the land."""
    made, low = (
        scene([slab("land", 500.0, 900.0, up, "concrete"), point("t", 0, 100)], radar={"height_m": 8.0},
              environment={"multipath": True, "earth": "flat"})
        for up in (6.0, 9.0)
    )  # fmt: skip
    values = engine_factor(made, np.array([1300.0, 1500.0, 1000.0]), np.array([5.0, 7.0, 6.2]), 1)
    assert values.tolist() == [1.0, 1.0, 1.0]
    assert engine_factor(low, np.array([1400.0]), np.array([12.0]), 1).tolist() == [1.0]
    wall = scene([slab("wall", 500.0, 560.0, 9.0, "concrete"), slab("land", 560.0, 900.0, 1.0, "concrete"), point("t", 0, 100)],
                 radar={"height_m": 8.0}, environment={"multipath": True, "earth": "flat"})  # fmt: skip
    assert engine_factor(wall, np.array([1275.0]), np.array([10.0]), 2).tolist() == [
        1.0
    ]  # by the land it would be on the wall
