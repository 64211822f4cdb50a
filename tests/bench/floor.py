"""The floor: what a scan asks of the libraries, done again by them alone.

A scan is watched once: every FFT by its shape, every draw of normal and gamma numbers by its count, every batch of rays by
itself, and the bytes of the profiles handed over. The floor is the time of the same FFTs over other numbers, the same draws,
the same rays through the same trees, and one pass over the profiles for each time that a scan must touch them: rest added,
clutter added, power taken.
"""

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pytest
import scipy.fft
from numpy.typing import NDArray

import radar_service as rs
from radar_service.trace.embree import TriangleScene


@dataclass
class Work:
    """What one scan asked for."""

    ffts: list[tuple[str, tuple[int, ...], np.dtype[Any], int | None, int]] = field(default_factory=list)
    draws: list[tuple[str, int]] = field(default_factory=list)
    rays: list[tuple[Any, NDArray[np.float32], NDArray[np.float32], dict[str, Any]]] = field(default_factory=list)
    profiles: list[tuple[int, int]] = field(default_factory=list)

    @property
    def ray_count(self) -> int:
        return sum(len(direction) for _, _, direction, _ in self.rays)


@contextmanager
def watched(work: Work) -> Iterator[None]:
    """While it lasts, what is asked of scipy.fft, of generators and of Embree is noted in `work`."""
    with pytest.MonkeyPatch.context() as patch:
        for name in ("fft", "ifft"):
            patch.setattr(scipy.fft, name, _noting_fft(getattr(scipy.fft, name), name, work))
        patch.setattr(np.random, "Generator", _noting_generator(work))
        patch.setattr(TriangleScene, "_as_float32", _noting_rays(TriangleScene._as_float32, work))
        yield


def _noting_fft(original: Callable[..., Any], name: str, work: Work) -> Callable[..., Any]:
    def noting(x: Any, n: int | None = None, axis: int = -1, **more: Any) -> Any:
        work.ffts.append((name, np.shape(x), np.asarray(x).dtype, n, axis))
        return original(x, n, axis, **more)

    return noting


def _noting_generator(work: Work) -> type[np.random.Generator]:
    class Noting(np.random.Generator):
        def standard_normal(self, *args: Any, **more: Any) -> Any:
            drawn = super().standard_normal(*args, **more)
            work.draws.append(("normal", np.size(drawn)))
            return drawn

        def gamma(self, *args: Any, **more: Any) -> Any:
            drawn = super().gamma(*args, **more)
            work.draws.append(("gamma", np.size(drawn)))
            return drawn

    return Noting


def _noting_rays(original: Callable[..., Any], work: Work) -> Callable[..., Any]:
    def noting(self: TriangleScene, origin: Any, direction: Any) -> Any:
        origins, directions = original(self, origin, direction)
        work.rays.append((self._scene, origins, directions, {}))
        return origins, directions

    return noting


def scan_work(sim: rs.Simulator) -> Work:
    """What the next scan asks for."""
    work = Work()
    with watched(work):
        work.profiles = [block.field.shape for block in sim.blocks(scans=1)]
    return work


def floor_seconds(work: Work) -> float:
    """CPU time [s] of doing `work` once, all arrays made beforehand."""
    rng = np.random.default_rng(0)
    transforms = [
        (getattr(scipy.fft, name), np.zeros(shape, dtype), n, axis) for name, shape, dtype, n, axis in work.ffts[:200]
    ]
    share = len(work.ffts) / max(len(transforms), 1)
    total = 0.0
    start = time.process_time()
    for transform, x, n, axis in transforms:
        transform(x, n, axis)
    total += (time.process_time() - start) * share
    start = time.process_time()
    for kind, count in work.draws:
        _ = rng.standard_normal(count, dtype=np.float32) if kind == "normal" else rng.standard_gamma(1.0, count, np.float32)
    for scene, origins, directions, _ in work.rays:
        scene.run(origins, directions)
    total += time.process_time() - start
    for shape in set(work.profiles):
        a, power = np.zeros(shape, np.complex64), np.zeros(shape, np.float32)
        start = time.process_time()
        for _ in range(work.profiles.count(shape)):
            np.add(a, a, out=a)
            np.add(a, a, out=a)
            np.multiply(a.real, a.real, out=power)
        total += time.process_time() - start
    return total
