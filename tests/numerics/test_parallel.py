"""BLAS is limited while the engine computes and at no other time; importing the package changes nothing."""

import os
import subprocess
import sys
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from threadpoolctl import OpenBLASController, ThreadpoolController, threadpool_info, threadpool_limits

import radar_service as rs
from radar_service import __main__ as command_line
from radar_service.engine import pipeline
from radar_service.numerics.parallel import BLAS_LIMIT, BlasLimit
from radar_service.plan import cost_model
from radar_service.simulation import engine_set_up
from tests.scenes import point, scene

ROOT = Path(__file__).parents[2]
PATIENCE = 60.0  # s after which a test that waits for another thread fails
Numbers = dict[str, int]


def numbers() -> Numbers:
    """The number of threads of each BLAS library of this process."""
    return {result["filepath"]: result["num_threads"] for result in threadpool_info() if result["user_api"] == "blas"}


@pytest.fixture
def host() -> Iterator[Numbers]:
    """A host process that gave each library a number of threads of its own: 2, 3, ..."""
    with BLAS_LIMIT.held():
        pass  # loads and finds the libraries
    result = ThreadpoolController().select(user_api="blas").lib_controllers
    with threadpool_limits(user_api="blas"):  # restores what was before, whatever is set within
        for number, library in enumerate(result, start=2):
            library.set_num_threads(number)
        OpenBLASController.clear_controlling_thread()
        chosen = numbers()
        assert sorted(chosen.values()) == list(range(2, 2 + len(result)))
        yield chosen


@pytest.fixture
def small() -> rs.Scene:
    return scene([point("a", 0, 500), point("b", 300, 300, speed_kn=10)], radar={"azimuths": 120, "range_max_m": 1000})


def in_force(seen: list[Numbers]) -> bool:
    return bool(seen) and all(set(result.values()) == {1} for result in seen)


def fresh(script: str) -> None:
    """Runs a script in a new process, without the variables that this one got from its own imports."""
    clean = {key: text for key, text in os.environ.items() if not key.startswith(("OPENBLAS", "OMP", "MKL", "KMP"))}
    done = subprocess.run([sys.executable, "-c", script], cwd=ROOT, env=clean, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def test_import_and_simulation_leave_the_environment_and_the_libraries_alone() -> None:
    """The libraries are set and restored; none is loaded after the limit is first held, with all that the code of ships, sea,
    rain and optics imports when it is first called."""
    fresh("""
import os
import numpy, scipy.linalg
from threadpoolctl import ThreadpoolController, threadpool_info
before = dict(os.environ)
for library in ThreadpoolController().lib_controllers:
    library.set_num_threads(3)
threads = threadpool_info()
assert threads and all(found["num_threads"] == 3 for found in threads)
import radar_service as rs
assert dict(os.environ) == before and threadpool_info() == threads, "import"
from radar_service.numerics.parallel import BLAS_LIMIT
from tests.measurements.test_memory import everything
made = everything()
with BLAS_LIMIT.held():
    limited = {library.filepath for library in BLAS_LIMIT.libraries}
for fidelity in ("auto", "documented"):
    sim = rs.Simulator(made, fidelity)
    next(sim.blocks())
    sim.plan
assert {found["filepath"] for found in threadpool_info() if found["user_api"] == "blas"} == limited != set()
assert dict(os.environ) == before, "simulation"
""")


def test_limit_is_in_force_while_costs_are_measured(host: Numbers, small: rs.Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    """In set-up, in each block and in the documented fidelity it is by tests/numerics/test_arithmetic_name.py."""
    seen: list[Numbers] = []
    measure = cost_model.timed_costs
    monkeypatch.setattr(cost_model, "timed_costs", lambda *given: (seen.append(numbers()), measure(*given))[1])
    assert rs.Simulator(small).plan.costs is not None
    assert in_force(seen) and numbers() == host


def test_overlapping_simulators_keep_the_limit_until_the_last_one_ends(
    host: Numbers, small: rs.Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The second simulator begins while the first computes, and ends after it; the first one's thread lives on meanwhile."""
    begun, go, ended, leave = ({name: threading.Event() for name in ("first", "second")} for _ in range(4))
    profiles = pipeline.profiles

    def waiting_profiles(*arguments: Any) -> Any:
        name = threading.current_thread().name
        begun[name].set()
        assert go[name].wait(PATIENCE)
        return profiles(*arguments)

    def run(sim: rs.Simulator) -> None:
        name = threading.current_thread().name
        sim.scan()
        ended[name].set()
        leave[name].wait(PATIENCE)

    monkeypatch.setattr(pipeline, "profiles", waiting_profiles)
    threads = [threading.Thread(target=run, args=(rs.Simulator(small),), name=name) for name in begun]
    for thread in threads:
        thread.start()
        assert begun[thread.name].wait(PATIENCE)
    both = numbers()
    go["first"].set()
    assert ended["first"].wait(PATIENCE)
    one = numbers()
    go["second"].set()
    assert ended["second"].wait(PATIENCE)
    none = numbers()
    for thread in threads:
        leave[thread.name].set()
        thread.join(PATIENCE)
    assert in_force([both, one]) and none == host


def test_a_host_that_limits_blas_on_another_thread_keeps_its_numbers(host: Numbers, small: rs.Scene) -> None:
    """threadpoolctl lets only the host's thread set OpenBLAS meanwhile; see `BlasLibrary.set_num_threads`."""
    seen: list[Numbers] = []

    def simulate() -> None:
        seen.append(numbers())
        with BLAS_LIMIT.held():
            seen.append(numbers())
        seen.append(numbers())

    with threadpool_limits(2, user_api="blas"):
        thread = threading.Thread(target=simulate)
        thread.start()
        thread.join(PATIENCE)
    assert [set(result.values()) for result in seen] == [{2}, {1}, {2}]
    assert numbers() == host


@pytest.mark.parametrize("threads", [1, 2])
def test_an_exception_restores(host: Numbers, small: rs.Scene, monkeypatch: pytest.MonkeyPatch, threads: int) -> None:
    def broken(*_: Any) -> None:
        assert in_force([numbers()])
        raise ArithmeticError("broken")

    sim = rs.Simulator(small, threads=threads)
    monkeypatch.setattr(pipeline, "profiles", broken)
    with pytest.raises(ArithmeticError, match="broken"):
        sim.scan()
    assert numbers() == host
    monkeypatch.setattr(engine_set_up, "prepare", broken)
    with pytest.raises(ArithmeticError, match="broken"):
        rs.Simulator(small, threads=threads)
    assert numbers() == host
    with pytest.raises(ValueError, match="seed"):
        rs.Simulator(small, seed=-1)
    assert numbers() == host


def test_an_iterator_that_is_not_finished_does_not_hold_the_limit(host: Numbers, small: rs.Scene) -> None:
    sim = rs.Simulator(small)
    for suspended in (sim.blocks(), sim.spokes()):
        next(suspended)
        assert numbers() == host
    abandoned = sim.blocks()
    next(abandoned)
    del abandoned
    assert numbers() == host
    closed = rs.Simulator(small, threads=3).blocks()
    next(closed)
    closed.close()  # type: ignore[attr-defined]
    assert numbers() == host


class Library:
    """A BLAS library; with a number of threads for each thread, or one for all."""

    def __init__(self, number: int, per_thread: bool = False) -> None:
        self.per_thread = per_thread
        self._first, self._numbers = number, dict[int, int]()

    def get_num_threads(self) -> int:
        return self._numbers.get(self._of(), self._first)

    def set_num_threads(self, number: int) -> None:
        self._numbers[self._of()] = number

    def _of(self) -> int:
        return threading.get_ident() if self.per_thread else 0


def test_a_thread_knows_whether_it_holds_the_limit_alone() -> None:
    """However often it holds it itself; meanwhile no other one takes it."""
    limit, taken, go = BlasLimit([Library(4)]), threading.Event(), threading.Event()

    def other() -> None:
        with limit.held():
            taken.set()
            assert go.wait(PATIENCE)

    with limit.held(), limit.held(), limit.alone() as alone:
        assert alone
        thread = threading.Thread(target=other)
        thread.start()
        assert not taken.is_set()
    assert taken.wait(PATIENCE)
    with limit.alone() as alone:
        assert not alone
    go.set()
    thread.join(PATIENCE)
    with limit.alone() as alone:
        assert alone


def test_each_thread_sets_and_restores_a_library_that_has_one_number_for_each_thread() -> None:
    library = Library(4, per_thread=True)
    limit = BlasLimit([library])
    seen = []

    def other() -> None:
        seen.append(library.get_num_threads())
        library.set_num_threads(7)
        with limit.held(), limit.held():
            seen.append(library.get_num_threads())
        seen.append(library.get_num_threads())

    with limit.held():
        thread = threading.Thread(target=other)
        thread.start()
        thread.join(PATIENCE)
        seen.append(library.get_num_threads())
    assert [*seen, library.get_num_threads()] == [4, 1, 7, 1, 4]


def test_commands_hold_the_limit_for_the_whole_process(host: Numbers, monkeypatch: pytest.MonkeyPatch) -> None:
    seen: list[Numbers] = []

    def run(_: Any) -> int:
        thread = threading.Thread(target=lambda: seen.append(numbers()))
        thread.start()
        thread.join(PATIENCE)
        return 0

    for name in ("check", "scan"):  # `serve` computes in the processes of its worlds, which hold it
        monkeypatch.setattr(f"radar_service.commands.{name}.run", run)
    assert command_line.main(["check"]) == command_line.main(["scan", "-o", "x.npz"]) == 0
    assert len(seen) == 2 and in_force(seen) and numbers() == host
