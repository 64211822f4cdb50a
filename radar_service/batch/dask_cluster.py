"""An executor of workers on other machines, by Dask's distributed scheduler.

What is sent there is pickled by reference: workers need this package, in the version that is here. They are asked before
anything begins.
"""

import contextlib
from collections.abc import Iterator, Mapping
from functools import cache
from importlib.metadata import version
from typing import Any, cast

from radar_service.batch.jobs import Executor
from radar_service.numerics import arithmetic
from radar_service.terminal import UsageError, extra

CONNECT_SECONDS = 10.0  # until a scheduler that does not answer counts as absent
SAME = ("python", "dask", "distributed", "cloudpickle", "msgpack")  # whose versions must agree: messages depend on them
PACKAGE = "radar-service"


class ClusterError(UsageError):
    """A cluster that cannot be used. The text names it and the remedy."""


@contextlib.contextmanager
def cluster(address: str) -> Iterator[tuple[Executor, str]]:
    """Connects to a scheduler, as tcp://host:8786, while the `with` block lasts; yields its workers and their arithmetic.

    Raises ClusterError for a scheduler that does not answer, other versions, no workers, and workers without this package, in
    another version or of different arithmetics; MissingExtra where distributed is not installed.
    """
    with _client(address) as client:
        check_versions(address, client.get_versions(check=False))
        facts = common_facts(address, client.run(worker_facts, on_error="return"))
        yield client.get_executor(pure=False), facts["arithmetic"]


@contextlib.contextmanager
def _client(address: str) -> Iterator[Any]:
    """A client of a scheduler. Raises ClusterError and MissingExtra."""
    with extra("cluster", "clusters"):
        from distributed import Client
    try:
        client: Any = cast(Any, Client)(address, timeout=CONNECT_SECONDS, set_as_default=False)
    except (OSError, ValueError, TypeError) as error:
        raise ClusterError(
            f"--scheduler {address}: no scheduler of Dask answers there ({_first_line(error)}); start one by `dask scheduler`, "
            "and give the address that it prints, as tcp://127.0.0.1:8786"
        ) from None
    with client:
        yield client


def check_versions(address: str, versions: Mapping[str, Any]) -> None:
    """Raises ClusterError where the scheduler or a worker has another version of what messages depend on.

    versions: as `Client.get_versions` gives them.
    """
    here = _packages(versions["client"])
    others = {
        "the scheduler": versions["scheduler"],
        **{f"worker {name}": worker for name, worker in versions["workers"].items()},
    }
    for who, each in others.items():
        for name, there in _packages(each).items():
            if there != here[name]:
                raise ClusterError(
                    f"--scheduler {address}: {who} has {name} {there}, and this machine {here[name]}; install the same version"
                )


def _packages(versions: Mapping[str, Any] | None) -> dict[str, str | None]:
    packages = (versions or {}).get("packages", {})
    return {name: packages.get(name) if name != "python" else (packages.get(name) or "")[:4] for name in SAME}


def common_facts(address: str, facts: Mapping[str, Any]) -> Mapping[str, str]:
    """Returns what all workers have in common. facts: of each worker, or its error. Raises ClusterError."""
    if not facts:
        raise ClusterError(f"--scheduler {address}: it has no workers; start some by `dask worker {address}`")
    first_name, first = next(iter(facts.items()))
    for name, each in facts.items():
        if isinstance(each, BaseException):
            raise ClusterError(
                f"--scheduler {address}: worker {name} has no usable {PACKAGE} ({_first_line(each)}); install "
                f"{version(PACKAGE)} there"
            )
        if each["version"] != version(PACKAGE):
            raise ClusterError(
                f"--scheduler {address}: worker {name} has {PACKAGE} {each['version']}, and this machine {version(PACKAGE)}; "
                "install the same version"
            )
        if each["arithmetic"] != first["arithmetic"]:
            raise ClusterError(
                f"--scheduler {address}: workers round differently: {first_name} computes by {first['arithmetic']}, {name} by "
                f"{each['arithmetic']}; start workers on equal machines only"
            )
    common: Mapping[str, str] = first
    return common


@cache
def worker_facts() -> dict[str, str]:
    """Returns what results of this process depend on: the version of this package and its arithmetic."""
    return {"version": version(PACKAGE), "arithmetic": arithmetic()}


def _first_line(error: BaseException) -> str:
    return f"{type(error).__name__}: {error}".splitlines()[0][:200]
