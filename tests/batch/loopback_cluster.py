"""A scheduler of Dask and its workers on loopback, on ports that the system gives, for tests and studies.

They run in a process of their own, `python -m tests.batch.loopback_cluster COUNT WITHOUT`. It ends when its standard input does.
"""

import asyncio
import contextlib
import importlib.abc
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

ROOT = Path(__file__).parents[2]


@contextlib.contextmanager
def loopback_cluster(count: int, without: str = "") -> Iterator[str]:
    """The address of a scheduler that has so many workers, each a process of its own that is started again when it dies.

    without: a package that its one worker, which is no process of its own then, does not find.
    """
    command = [sys.executable, "-m", "tests.batch.loopback_cluster", str(count), without]
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "DASK_DISTRIBUTED__WORKER__MEMORY__TERMINATE": "False"}
    with TemporaryDirectory() as folder:
        process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, env={**environment, "TMPDIR": folder}, cwd=folder, text=True
        )  # fmt: skip
        with process:
            assert process.stdout is not None
            yield process.stdout.readline().strip()
            assert process.stdin is not None
            process.stdin.close()
            process.wait(60)


class Without(importlib.abc.MetaPathFinder):
    """Lets this process find no module of a package."""

    def __init__(self, package: str) -> None:
        self.package = package

    def find_spec(self, name: str, path: Any, target: Any = None) -> None:
        if name.split(".")[0] == self.package:
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)


async def serve(count: int, without: str) -> None:
    """Runs a scheduler and its workers until standard input ends."""
    from distributed import Nanny, Scheduler, Worker

    def worker(address: str) -> Any:
        if without:
            return Worker(address, host="127.0.0.1", nthreads=1, dashboard_address="127.0.0.1:0")
        return Nanny(address, host="127.0.0.1", nthreads=1, dashboard_address="127.0.0.1:0", memory_limit=0)

    async with (
        Scheduler(host="127.0.0.1", port=0, dashboard_address="127.0.0.1:0") as scheduler,
        contextlib.AsyncExitStack() as stack,
    ):
        await asyncio.gather(*(stack.enter_async_context(worker(scheduler.address)) for _ in range(count)))
        print(scheduler.address, flush=True)
        await asyncio.to_thread(sys.stdin.read)


if __name__ == "__main__":
    if sys.argv[2]:
        sys.meta_path.insert(0, Without(sys.argv[2]))
    asyncio.run(serve(int(sys.argv[1]), sys.argv[2]))
