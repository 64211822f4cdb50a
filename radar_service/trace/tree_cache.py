"""Trees for ray tests: equal meshes share one, their number is bounded, and those unused for longest make room.

A tree belongs to the meshes that use it and goes with the last of them. A dropped tree is built again at the next ray.
"""

import itertools
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from hashlib import blake2b
from typing import Any, Protocol
from weakref import WeakValueDictionary

import numpy as np
from numpy.typing import NDArray

from radar_service.numerics import Flags, Indices, Singles

Triangles = tuple[Singles, NDArray[np.int32]]  # vertices (V, 3) [m] and faces (F, 3)
SHARE = 8  # where there is no room, one tree in so many is dropped at once: the search then costs little per tree


class Tree(Protocol):
    """Triangles ready for rays in float32: origins and directions (M, 3)."""

    def first_hit(self, origins: Singles, directions: Singles) -> Indices:
        """Index of the first triangle that each ray meets, -1 where none."""
        ...

    def occluded(self, origins: Singles, directions: Singles, reach: Singles) -> Flags:
        """Whether each ray meets a triangle within `reach` (M,), in lengths of `direction`."""
        ...


class SharedTree:
    """The tree of all equal meshes: None before the first ray, and after it was dropped. `used` orders trees by last use."""

    def __init__(self) -> None:
        self.tree: Tree | None = None
        self.used = 0


class TreeCache:
    """At most `maximum` live trees. Safe to call from several threads; a tree in use stays until its rays are traced."""

    def __init__(self, build: Callable[[Singles, NDArray[np.int32]], Tree], maximum: int) -> None:
        """build: makes a tree of vertices (V, 3) [m] and faces (F, 3)."""
        self.maximum, self.builds = maximum, 0
        self._build, self._lock, self._clock = build, threading.Lock(), itertools.count(1)
        self._shared: WeakValueDictionary[bytes, SharedTree] = WeakValueDictionary()
        self._live_at_most = 0  # trees that ended with their meshes are still counted, until the next search

    @property
    def live(self) -> int:
        """How many trees there are now."""
        return len(self._live())

    @contextmanager
    def unchanged(self) -> Iterator[None]:
        """Lets no other thread add or drop a tree during a `with` block."""
        with self._lock:
            yield

    def share(self, triangles: Triangles) -> SharedTree:
        """What equal triangles share, whichever scene they belong to."""
        key = content_key(*triangles)
        with self._lock:
            return self._shared.setdefault(key, SharedTree())

    def tree(self, shared: SharedTree, triangles: Callable[[], Triangles]) -> Tree:
        """The tree of a mesh, built from its `triangles` where there is none."""
        shared.used = next(self._clock)
        tree = shared.tree  # once: another thread may drop it meanwhile
        return self._built(shared, triangles) if tree is None else tree

    def _built(self, shared: SharedTree, triangles: Callable[[], Triangles]) -> Tree:
        with self._lock:
            if shared.tree is not None:
                return shared.tree
            if self._live_at_most >= self.maximum:
                self._make_room()
            shared.tree = tree = self._build(*triangles())
            self.builds, self._live_at_most = self.builds + 1, self._live_at_most + 1
            return tree

    def _make_room(self) -> None:
        """Drops the trees unused for longest, until a SHARE-th of the maximum is free."""
        live = sorted(self._live(), key=lambda shared: shared.used)
        room = max(1, self.maximum // SHARE)
        for shared in live[: max(0, len(live) + room - self.maximum)]:
            shared.tree = None
        self._live_at_most = min(len(live), self.maximum - room)

    def _live(self) -> list[SharedTree]:
        return [shared for shared in list(self._shared.values()) if shared.tree is not None]


def content_key(*arrays: NDArray[Any]) -> bytes:
    """The same for arrays of equal shapes and contents alone."""
    digest = blake2b(digest_size=16)
    for array in arrays:
        digest.update(repr((array.shape, array.dtype.str)).encode())
        digest.update(np.ascontiguousarray(array).data)
    return digest.digest()
