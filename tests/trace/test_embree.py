"""Embree's answers against float64, any number of scenes, and the same without embreex."""

import pickle
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import radar_service as rs
from radar_service.trace import embree
from radar_service.trace.box_tree import BoxTree
from radar_service.trace.embree import LAZY_FACES, RayCount, TriangleScene
from radar_service.trace.moller_trumbore import watertight_crossings
from radar_service.trace.tree_cache import TreeCache
from tests.scenes import scene as scene_of
from tests.trace.test_occluder import hills

MESH = hills(1, 300.0)
ORIGIN = np.array([3.0, -4.0, 60.0])


def rays(count: int = 400) -> np.ndarray:
    aims = np.random.default_rng(2).uniform([-400, -400, -20], [400, 400, 80], (count, 3))
    return np.asarray((aims - ORIGIN) / np.linalg.norm(aims - ORIGIN, axis=1)[:, None])


def scene(count: RayCount | None = None) -> TriangleScene:
    return TriangleScene(MESH.vertices, MESH.faces, count)


def test_first_hits_and_their_distances_are_those_of_float64() -> None:
    """The same triangle wherever the two nearest lie 1 cm apart; the distance in float64, 1e-9 m."""
    crossings = np.sort(watertight_crossings(ORIGIN, rays(), MESH.vertices[MESH.faces]), axis=1)
    which = np.argmin(watertight_crossings(ORIGIN, rays(), MESH.vertices[MESH.faces]), axis=1)
    made = scene()
    hit = made.first_hit(ORIGIN, rays())
    met = np.isfinite(crossings[:, 0])
    clear = np.zeros(len(met), dtype=np.bool_)
    clear[met] = crossings[met, 1] - crossings[met, 0] > 0.01
    assert (clear & met).sum() > 100 and np.mean((hit >= 0) == met) > 0.99  # edges of the terrain: float32
    both = clear & met & (hit >= 0)
    np.testing.assert_array_equal(hit[both], which[both])
    distance = made.hit_distance(hit[both], ORIGIN, rays()[both])
    np.testing.assert_allclose(distance, crossings[both, 0], rtol=0, atol=1e-9)


def test_planes_that_are_not_kept_give_the_same_distances(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of large meshes they are computed for those triangles alone that rays meet."""
    kept, large = scene(), scene()
    triangle = kept.first_hit(ORIGIN, rays())
    met = triangle >= 0
    expected = kept.hit_distance(triangle[met], ORIGIN, rays()[met])
    monkeypatch.setattr(embree, "MAX_PLANES", 10)
    assert np.array_equal(large.hit_distance(triangle[met], ORIGIN, rays()[met]), expected) and len(expected) > 100
    assert "planes" in kept.__dict__ and "planes" not in large.__dict__


def test_occluded_counts_only_triangles_within_reach() -> None:
    made = scene()
    hit = made.first_hit(ORIGIN, rays())
    met = np.flatnonzero(hit >= 0)
    distance = made.hit_distance(hit[met], ORIGIN, rays()[met])
    assert made.occluded(ORIGIN, rays()[met], distance + 0.01).all()
    assert not made.occluded(ORIGIN, rays()[met], distance - 0.01).any()
    assert not made.occluded(ORIGIN, rays()[hit < 0], 1e6).any()


def test_a_pickled_scene_hits_the_same() -> None:
    """Also where it had cast rays before, and where it had cast none. No tree travels along: it cannot be pickled."""
    used = scene()
    before = used.first_hit(ORIGIN, rays())
    used.hit_distance(before[before >= 0], ORIGIN, rays()[before >= 0])
    for made in (used, scene()):
        copy = pickle.loads(pickle.dumps(made))
        np.testing.assert_array_equal(copy.first_hit(ORIGIN, rays()), before)
        met = np.flatnonzero(before >= 0)
        args = before[met], ORIGIN, rays()[met]
        np.testing.assert_array_equal(copy.hit_distance(*args), used.hit_distance(*args))
        assert (copy.radius, copy.centre.tolist()) == (made.radius, made.centre.tolist())


def test_rays_are_counted_and_none_give_none() -> None:
    count = RayCount()
    made = scene(count)
    made.first_hit(ORIGIN, rays(30))
    made.occluded(ORIGIN, rays(12), 5.0)
    assert count.rays == 42
    assert made.first_hit(ORIGIN, np.zeros((0, 3))).shape == made.occluded(ORIGIN, np.zeros((0, 3)), 1.0).shape == (0,)


def test_a_ray_along_a_plane_never_meets_it() -> None:
    made = TriangleScene(np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]]), np.array([[0, 1, 2]]))
    assert np.isinf(made.hit_distance(np.zeros(1, dtype=np.int64), np.array([0.0, 0, 1]), np.array([[1.0, 0, 0]])))[0]


@pytest.mark.parametrize("offset", [0.0, 1e5])
def test_a_scene_far_from_the_origin_is_as_exact(offset: float) -> None:
    """Stored about its own centre: rays 2 mm inside and outside an edge are told apart 100 km off."""
    vertices = np.array([[0.0, 0, 0], [10, 0, 0], [0, 10, 0]]) + offset
    made = TriangleScene(vertices, np.array([[0, 1, 2]]))
    down = np.array([[0.0, 0, -1], [0.0, 0, -1]])
    origin = np.array([[5.0, 0.002, 1.0], [5.0, -0.002, 1.0]]) + offset
    assert made.first_hit(origin, down).tolist() == [0, -1]


def in_process(script: str) -> str:
    """What a script prints in a process of its own, whose death is an error."""
    root = Path(__file__).parents[2]
    run = subprocess.run([sys.executable, "-c", script], cwd=root, capture_output=True, text=True, timeout=120)
    assert run.returncode == 0, f"exit status {run.returncode}: {run.stderr[-2000:]}"
    return run.stdout


MANY = """
import numpy as np
from radar_service.trace.embree import TREES, TriangleScene
corners, face, up = np.eye(3), np.array([[0, 1, 2]]), np.array([[0.0, 0, 1]])
scenes = [TriangleScene(corners * size, face) for size in range(1, 1301)]
print(*(scene.first_hit(np.array([size / 4.0, size / 4.0, -1]), up)[0] for size, scene in enumerate(scenes, 1)), TREES.live)
del scenes
print(TREES.live)
"""


def test_thirteen_hundred_scenes_live_at_once() -> None:
    """embreex with a device for each scene dies at the 1017th. All trees go with their scenes."""
    together, after = in_process(MANY).splitlines()
    assert together.split() == ["0"] * 1300 + ["1300"]
    assert after == "0"


def own_trees(monkeypatch: pytest.MonkeyPatch, maximum: int, build=embree.build_tree) -> TreeCache:
    """A cache for this test alone."""
    trees = TreeCache(build, maximum)
    monkeypatch.setattr(embree, "TREES", trees)
    return trees


def test_equal_scenes_share_a_tree_and_a_dropped_one_is_built_again(monkeypatch: pytest.MonkeyPatch) -> None:
    trees = own_trees(monkeypatch, 2)
    scenes = [TriangleScene(MESH.vertices + offset, MESH.faces) for offset in (0.0, 64.0)]  # the same about their centres
    expected = [made.first_hit(ORIGIN, rays()) for made in scenes]
    assert trees.live == trees.builds == 1
    others = [TriangleScene(MESH.vertices * scale, MESH.faces) for scale in (2.0, 3.0, 4.0)]
    for other in others:
        other.first_hit(ORIGIN, rays())
        assert trees.live <= 2
    for made, hits in zip(scenes, expected, strict=True):
        np.testing.assert_array_equal(made.first_hit(ORIGIN, rays()), hits)
    assert trees.builds == 5
    del scenes, others, made, other
    assert trees.live == 0


def test_large_meshes_are_built_at_once_and_small_ones_at_their_first_ray(monkeypatch: pytest.MonkeyPatch) -> None:
    trees = own_trees(monkeypatch, 9)
    small, large = (hills(1, 300.0, posts) for posts in (12, 24))
    assert len(small.faces) <= LAZY_FACES < len(large.faces)
    made = TriangleScene(small.vertices, small.faces)
    assert trees.live == 0
    made.first_hit(ORIGIN, rays())
    assert trees.live == 1
    packed = pickle.dumps(TriangleScene(large.vertices, large.faces))
    assert trees.builds == 2
    pickle.loads(packed)
    assert trees.builds == 3


BOXES = [
    {"name": f"b{k}", "shape": "box", "length_m": 8 + k % 50 / 10, "width_m": 4 + k // 50 / 5, "height_m": 5,
     "scattering": "diffuse", "position_m": [700 * np.sin(k), 700 * np.cos(k), 0], "speed_kn": 4 + k % 7,
     "course_deg": k * 37 % 360}
    for k in range(40)
]  # fmt: skip


def some_spokes(bodies: list[dict[str, object]]) -> np.ndarray:
    sim = rs.Simulator(scene_of(bodies, radar={"range_max_m": 900, "azimuths": 90, "beamwidth_deg": 5}), "fast")
    return np.concatenate([block.field for block, _ in zip(sim.blocks(scans=1), range(2), strict=False)])


def test_a_bound_below_the_bodies_of_a_scene_changes_no_byte(monkeypatch: pytest.MonkeyPatch) -> None:
    """40 moving boxes, no two of them equal, in room for 8 trees."""
    expected = some_spokes(BOXES)
    trees = own_trees(monkeypatch, 8)
    assert some_spokes(BOXES).tobytes() == expected.tobytes()
    assert trees.builds > 40 and trees.live <= 8


def test_without_embree_spokes_are_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    """No line of sight here passes within rounding of an edge."""
    expected = some_spokes(BOXES)
    own_trees(monkeypatch, 99, BoxTree)
    assert some_spokes(BOXES).tobytes() == expected.tobytes() and np.abs(expected).max() > 0.0


MISSING = """
import sys, warnings
for name in ("embreex", "embreex.rtcore", "embreex.rtcore_scene", "embreex.mesh_construction"):
    sys.modules[name] = None
warnings.simplefilter("always")
with warnings.catch_warnings(record=True) as caught:
    import radar_service as rs
    sim = rs.Simulator(rs.load_scene("open-sea"), "fast")
    next(iter(sim.blocks()))
print(*(w.message for w in caught if issubclass(w.category, RuntimeWarning)), sep="|")
"""


def test_a_process_without_embreex_warns_once_and_works() -> None:
    (warning,) = in_process(MISSING).split("|")
    assert "embreex is not installed" in warning and "slower" in warning
