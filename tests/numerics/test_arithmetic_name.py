"""Bytes depend on the arithmetic alone: every matrix product runs under the limit of BLAS, whoever asks for it."""

import dis
import os
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from types import CodeType, FrameType
from typing import Any

import numpy as np
import pytest

import radar_service as rs
from radar_service.numerics.arithmetic_name import arithmetic, dispatched, numpy_level
from radar_service.numerics.parallel import BLAS_LIMIT
from radar_service.records.cell_sources import SourceRequest
from radar_service.records.fidelity import PRESETS
from radar_service.simulation.engine_set_up import EngineSetUp, SourceTiles, engine_set_up
from radar_service.sources.numbers import source_numbers
from radar_service.sources.power_window import pulse_powers, scan_powers
from radar_service.sources.radiometric import RadiometricTruth
from radar_service.truth.crossings import CrossingTruth
from radar_service.truth.ground_truth import GroundTruth
from tests.arithmetics import arithmetics
from tests.same_bytes import compares_bytes
from tests.scenes import everything

PACKAGE = str(Path(rs.__file__).parent)
PRODUCTS = {"dot", "matmul", "tensordot", "inner", "vdot", "vecdot", "solve", "inv", "lstsq", "cholesky", "eigvalsh"}


@cache
def multiplies(code: CodeType) -> bool:
    """Whether a function of the package has a matrix product."""
    if not code.co_filename.startswith(PACKAGE):
        return False
    return bool(PRODUCTS & set(code.co_names)) or any(step.argrepr in ("@", "@=") for step in dis.get_instructions(code))


@contextmanager
def products() -> Iterator[dict[str, bool]]:
    """Notes of each function with a matrix product that runs meanwhile whether the limit was held each time."""
    seen: dict[str, bool] = {}

    def note(frame: FrameType, event: str, _: Any) -> None:
        if event == "call" and multiplies(frame.f_code):
            seen[frame.f_code.co_qualname] = seen.get(frame.f_code.co_qualname, True) and BLAS_LIMIT.is_held

    before = sys.getprofile()
    sys.setprofile(note)
    try:
        yield seen
    finally:
        sys.setprofile(before)


@pytest.fixture(scope="module")
def made() -> rs.Scene:
    return everything()


@pytest.fixture(scope="module")
def prepared(made: rs.Scene) -> EngineSetUp:
    return engine_set_up(made, PRESETS["fast"], "fast", 0)


def tiles(made: rs.Scene, prepared: EngineSetUp) -> None:
    source = SourceTiles(prepared.engine, prepared.pulses, SourceRequest(labels=True, powers="all"))
    for _ in source.scan(1, None):
        assert not BLAS_LIMIT.is_held


def again(made: rs.Scene, prepared: EngineSetUp) -> None:
    scan_powers(pulse_powers(prepared.pulses, source_numbers(made)), 1)


def radiometric(made: rs.Scene, prepared: EngineSetUp) -> None:
    RadiometricTruth(prepared.pulses).at(1, 0)


def truth(made: rs.Scene, prepared: EngineSetUp) -> None:
    source = GroundTruth(made, prepared.line_of_sight)
    source.at(1.0)
    crossings = CrossingTruth(source)
    crossings.crossings(0)
    crossings.snapshot(0)


def documented(made: rs.Scene, prepared: EngineSetUp) -> None:
    next(engine_set_up(made, PRESETS["documented"], "documented", 0).engine.tiles(0))


def set_up(made: rs.Scene, prepared: EngineSetUp) -> None:
    engine_set_up(made, PRESETS["fast"], "fast", 0)


@pytest.mark.parametrize("work", [set_up, tiles, again, radiometric, truth, documented])
def test_no_matrix_product_runs_without_the_limit(
    made: rs.Scene, prepared: EngineSetUp, work: Callable[[rs.Scene, EngineSetUp], None]
) -> None:
    with products() as held:
        work(made, prepared)
    assert held and [name for name, was in held.items() if not was] == []


SCAN = """
import sys
import numpy as np
import radar_service as rs
from radar_service.numerics.arithmetic_name import arithmetic
from tests.scenes import everything
print(arithmetic())
np.save(sys.argv[1], rs.Simulator(everything(), "fast").scan().field)
"""


def test_two_arithmetics_have_two_names_and_agree_within_120_db_of_the_peak(made: rs.Scene, tmp_path: Path) -> None:
    """BLAS without fused products and numpy without this processor's instructions, against what the suite has."""
    known, path = arithmetics(), tmp_path / "field.npy"
    changes = {key: value for name in ("Nehalem", "baseline") for key, value in known.get(name, {}).items()}
    command = [sys.executable, "-c", SCAN, str(path)]
    done = subprocess.run(command, env={**os.environ, **changes}, check=True, capture_output=True, text=True)
    if done.stdout.strip() == arithmetic():
        pytest.skip("this processor has one arithmetic")
    field, other = rs.Simulator(made, "fast").scan().field, np.load(path)
    assert np.abs(other - field).max() < 10.0 ** (-120.0 / 20.0) * np.abs(field).max()


def test_the_name_has_what_bytes_depend_on() -> None:
    name = arithmetic()
    assert f"numpy {np.__version__} {numpy_level()}, scipy " in name and len(name) < 150
    assert not dispatched() or numpy_level() == dispatched()[-1]


def test_simulators_on_several_threads_give_the_bytes_of_one(made: rs.Scene) -> None:
    """Each of two threads of the user's own has a simulator; a third one asks them for powers and truth meanwhile."""

    def scans(sim: rs.Simulator) -> bytes:
        return b"".join(sim.scan().field.tobytes() for _ in range(2))

    def asked(sim: rs.Simulator) -> list[Any]:
        powers = {number: power.tobytes() for number, power in sim.source_powers(0).items()}
        return [powers, sim.crossings(0, radiometric=True), sim.truth(1.0)]

    expected, answers = scans(rs.Simulator(made, "fast")), asked(rs.Simulator(made, "fast"))
    simulators = [rs.Simulator(made, "fast", threads=threads) for threads in (1, 2)]
    results: dict[int, Any] = {}
    work = [lambda k=k: results.update({k: scans(simulators[k])}) for k in (0, 1)]
    work.append(lambda: results.update({2: asked(simulators[0])}))
    threads = [threading.Thread(target=each) for each in work]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert results == {0: expected, 1: expected, 2: answers}


def test_tests_that_compare_bytes_are_found() -> None:
    assert compares_bytes(test_simulators_on_several_threads_give_the_bytes_of_one)
    assert not compares_bytes(test_the_name_has_what_bytes_depend_on)
