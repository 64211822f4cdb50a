"""One process that starts others."""

from collections.abc import Iterator

import pytest

from radar_service.commands.serve import OTHERS_NEED, SCENES_NEED
from radar_service.processes.fork_server import ForkServer


@pytest.fixture(scope="session")
def fork_server() -> Iterator[ForkServer]:
    """One that has imported the simulator, for all tests of a process."""
    server = ForkServer(SCENES_NEED, OTHERS_NEED)
    server.start()
    yield server
    server.close()
