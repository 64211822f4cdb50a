"""What takes minutes runs on request alone, whatever other markers are chosen by; one process that starts others."""

from collections.abc import Iterator

import pytest

from radar_service.stream.processes.fork_server import ForkServer
from radar_service.stream.serve import OTHERS_NEED, WORLDS_NEED


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Skip studies that `-m study` has not asked for."""
    if "study" in str(config.option.markexpr).replace("not study", ""):
        return
    for item in items:
        if item.get_closest_marker("study"):
            item.add_marker(pytest.mark.skip(reason="opt-in: -m study"))


@pytest.fixture(scope="session")
def fork_server() -> Iterator[ForkServer]:
    """One that has imported the simulator, for all tests of a process."""
    server = ForkServer(WORLDS_NEED, OTHERS_NEED)
    server.start()
    yield server
    server.close()
