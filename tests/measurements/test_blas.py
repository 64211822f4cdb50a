"""What the limit of BLAS is worth: harbour with and without it, two cores busy:
`pytest -m bench -s tests/measurements/test_blas.py`.

Azimuths per second of wall clock of one simulator with two threads. Turns with and without the limit alternate, so that a busy
machine slows both.
"""

import time
from collections.abc import Sequence

import numpy as np
import pytest

import radar_service as rs
from radar_service.numerics.parallel import BLAS_LIMIT, BlasLibrary
from tests.measurements.places import shipped

pytestmark = pytest.mark.bench
TURNS = 9
HELD_US = 100.0  # a block of 16 azimuths takes 2 ms: a twentieth of it


def azimuths_per_second(sim: rs.Simulator, libraries: Sequence[BlasLibrary] | None) -> float:
    """Over one scan, with these libraries limited; None for all."""
    BLAS_LIMIT.libraries = libraries
    start = time.perf_counter()
    for _ in sim.blocks(scans=1):
        pass
    return sim.scene.radar.azimuths / (time.perf_counter() - start)


@pytest.mark.parametrize("fidelity", ["auto", "balanced"])
def test_harbour_with_and_without_the_limit(fidelity: str) -> None:
    sim = rs.Simulator(shipped("harbour"), fidelity, seed=1, threads=2)
    sim.scan()
    result = BLAS_LIMIT.libraries
    try:
        pairs = [(azimuths_per_second(sim, result), azimuths_per_second(sim, ())) for _ in range(TURNS)]
    finally:
        BLAS_LIMIT.libraries = result
    limited, free = np.median(pairs, axis=0)
    print(f"\nharbour, {fidelity}, two threads: {limited:.0f} azimuths/s with the limit, {free:.0f} without")
    assert limited > 0.95 * free  # the limit costs nothing; its gain depends on cores and load


def test_holding_the_limit_takes_microseconds() -> None:
    with BLAS_LIMIT.held():
        pass  # finds the libraries, once
    taken = []
    for _ in range(2000):
        start = time.perf_counter()
        with BLAS_LIMIT.held():
            pass
        taken.append(time.perf_counter() - start)
    print(f"\nthe limit, taken and released: {np.median(taken) * 1e6:.1f} us")
    assert np.median(taken) * 1e6 < HELD_US
