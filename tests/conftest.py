"""How the suite runs: in two processes more than there are cores, save where figures are measured. The scene that tests share."""

import asyncio
import gc
import inspect
import json
import os
import sys
from collections.abc import Generator
from pathlib import Path

import pytest

from tests.cpu_budget import pytest_addoption, pytest_configure  # noqa: F401 (its hooks are also this conftest's)
from tests.same_bytes import compares_bytes
from tests.samples import beyond_samples
from tests.scenes import ONE_TARGET

pytest_plugins = (
    "tests.plug_ins.fixtures", "tests.recording.fixtures", "tests.scene_file.fixtures", "tests.service.fixtures",
    "tests.stages.fixtures",
)  # fmt: skip
SUITE = "not bench and not study"
SAME_BYTES = f"same_bytes and {SUITE}"  # what tests.arithmetics runs
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)  # processes that tests start need not each compile the package anew,
sys.dont_write_bytecode = False  # nor this one the tests with their rewritten asserts: half the time of collecting them


def pytest_xdist_auto_num_workers(config: pytest.Config) -> int:
    """Two more than cores for the suite, as tests wait two fifths of their time for what they start, at most five; none besides
    this process for benchmarks, studies and with -s or --pdb."""
    alone = config.option.markexpr not in (SUITE, SAME_BYTES) or config.option.capture == "no" or config.option.usepdb
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    return 0 if alone else min(5, cores + 2)


@pytest.hookimpl(wrapper=True)
def pytest_collection() -> Generator[None, object, object]:
    """Collects without the collector of garbage: modules and tests live on, and to search them takes a fifth of the time."""
    gc.disable()
    try:
        return (yield)
    finally:
        gc.enable()


@pytest.hookimpl(tryfirst=True)  # before -m chooses
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Gives tests beyond the sample of their parameters their marker, and those that compare bytes where -m names it; those
    that drive a browser compare pixels of given pictures. What takes minutes runs on request alone, whatever else is chosen."""
    chosen_by = str(config.option.markexpr)
    on_request, by_bytes = "study" in chosen_by.replace("not study", ""), "same_bytes" in chosen_by
    for item in beyond_samples(items):
        item.add_marker("study")
    for item in items:
        if item.get_closest_marker("study") and not on_request:
            item.add_marker(pytest.mark.skip(reason="opt-in: -m study"))
        if by_bytes and isinstance(item, pytest.Function) and not item.get_closest_marker("browser"):
            if compares_bytes(item.function):
                item.add_marker("same_bytes")


def pytest_collection_finish(session: pytest.Session) -> None:
    """Modules and tests of the suite live to its end: the collector of garbage need not go through them again and again."""
    if session.config.option.markexpr == SUITE:
        gc.freeze()  # without a search before it, which takes 0.3 s in each process
        gc.set_threshold(5_000, 10, 10)  # seven times as seldom: what a test leaves may wait, a full search takes 0.1 s


@pytest.hookimpl(tryfirst=True)
def pytest_pyfunc_call(pyfuncitem: pytest.Function) -> bool | None:
    """Runs a test that is a coroutine, for a minute at most where it is no study."""
    if not inspect.iscoroutinefunction(pyfuncitem.function):
        return None
    arguments = {name: pyfuncitem.funcargs[name] for name in inspect.signature(pyfuncitem.function).parameters}
    asyncio.run(asyncio.wait_for(pyfuncitem.obj(**arguments), None if pyfuncitem.get_closest_marker("study") else 60))
    return True


@pytest.fixture
def one_target(tmp_path: Path) -> Path:
    """A file with the scene ONE_TARGET."""
    path = tmp_path / "one.json"
    path.write_text(json.dumps(ONE_TARGET))
    return path
