"""Equal triangles share a tree; at most so many live; those unused for longest go first, and all go with their meshes."""

import threading

import numpy as np
import pytest

from radar_service.trace.tree_cache import SharedTree, TreeCache, Triangles, content_key


class Tree:
    """Any tree; it knows what it was made of."""

    def __init__(self, vertices: np.ndarray, faces: np.ndarray) -> None:
        self.vertices = vertices

    def first_hit(self, origins: np.ndarray, directions: np.ndarray) -> np.ndarray:
        return np.zeros(len(origins), dtype=np.int64)

    def occluded(self, origins: np.ndarray, directions: np.ndarray, reach: np.ndarray) -> np.ndarray:
        return reach > 0.0


def triangles(size: float) -> Triangles:
    return np.eye(3, dtype=np.float32) * np.float32(size), np.array([[0, 1, 2]], dtype=np.int32)


def used(cache: TreeCache, size: float) -> SharedTree:
    """The shared tree of a mesh that has traced a ray."""
    shared = cache.share(triangles(size))
    cache.tree(shared, lambda: triangles(size))
    return shared


def test_equal_triangles_share_one_tree_and_others_do_not() -> None:
    cache = TreeCache(Tree, 10)
    one, equal, other = (used(cache, size) for size in (1.0, 1.0, 2.0))
    assert one is equal and one is not other
    assert (cache.live, cache.builds) == (2, 2)


def test_keys_differ_by_shape_type_and_content() -> None:
    given = np.arange(6, dtype=np.float32)
    others = [given.reshape(2, 3), given.reshape(3, 2), given.view(np.int32), given + 1]
    assert len({content_key(array) for array in [given, *others]}) == 5
    assert content_key(given) == content_key(np.repeat(given, 2)[::2])  # not contiguous
    assert content_key(given[:2], given[2:]) != content_key(given[:3], given[3:])


def test_at_most_so_many_trees_live_and_the_oldest_goes_first() -> None:
    cache = TreeCache(Tree, 3)
    kept = [used(cache, size) for size in (1.0, 2.0, 3.0)]
    used(cache, 1.0)
    kept.append(used(cache, 4.0))
    assert [shared.tree is not None for shared in kept] == [True, False, True, True]
    kept.append(used(cache, 2.0))  # built again; 3 is the oldest now
    assert cache.tree(kept[1], lambda: triangles(2.0)).vertices[0, 0] == 2.0
    assert [shared.tree is not None for shared in kept[:4]] == [True, True, False, True]
    assert (cache.live, cache.builds) == (3, 5)


@pytest.mark.parametrize("maximum", [1, 2, 7, 8, 9, 64])
def test_the_bound_holds_after_every_build(maximum: int) -> None:
    cache = TreeCache(Tree, maximum)
    kept = []
    for size in range(3 * maximum):
        kept.append(used(cache, float(size)))
        assert cache.live <= maximum and kept[-1].tree is not None
    assert cache.live > maximum - max(1, maximum // 8)


def test_trees_end_with_the_last_mesh_that_uses_them_and_leave_room() -> None:
    cache = TreeCache(Tree, 4)
    kept, dropped = [used(cache, size) for size in (1.0, 2.0)], [used(cache, size) for size in (3.0, 4.0)]
    dropped.clear()
    assert cache.live == 2
    kept += [used(cache, size) for size in (5.0, 6.0)]
    assert cache.live == 4 and all(shared.tree is not None for shared in kept)  # those that ended made the room


def test_eight_threads_that_thrash_get_their_own_trees() -> None:
    """24 meshes in room for 4: each tree is of its mesh, whoever dropped it meanwhile."""
    cache = TreeCache(Tree, 4)
    meshes = [cache.share(triangles(float(size))) for size in range(24)]
    wrong: list[int] = []

    def work(seed: int) -> None:
        for size in np.random.default_rng(seed).integers(24, size=400).tolist():
            tree = cache.tree(meshes[size], lambda size=size: triangles(float(size)))
            if tree.vertices[0, 0] != size:
                wrong.append(size)

    threads = [threading.Thread(target=work, args=(seed,)) for seed in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert not wrong and cache.live <= 4


def test_no_tree_is_shared_or_built_while_the_cache_is_unchanged() -> None:
    cache = TreeCache(Tree, 10)
    with cache.unchanged():
        thread = threading.Thread(target=used, args=(cache, 1.0))
        thread.start()
        assert thread.is_alive() and cache.builds == 0
    thread.join(60.0)
    assert cache.builds == 1
