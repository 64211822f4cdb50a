"""Arguments that several commands share, and the simulator that they make, as one object for another process."""

import argparse
import contextlib
import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from radar_service.plan.budget import ERROR_HELP, ErrorBudget, error_budget
from radar_service.records import PRESETS, PURPOSE
from radar_service.terminal import add_overwrite, add_whole_number, pace, thread_count, utc

if TYPE_CHECKING:
    from radar_service.batch.jobs import Executor

DEFAULT_SCENE = "harbour"
SCENE_HELP = f"a .toml or .json file, or the name of a packaged scene (default {DEFAULT_SCENE})"
SERVICE_GROUPS = ("what", "where", "how exact", "how fast", "who may", "records")


def add_simulation(parser: argparse.ArgumentParser) -> None:
    """Adds the options of all that computes spokes in this process."""
    add_exactness(parser)
    add_threads(parser)


def add_exactness(to: "argparse._ActionsContainer") -> None:
    """Adds the options that decide what is computed."""
    presets = "; ".join(f"{name}: {purpose}" for name, purpose in PURPOSE.items())
    precision = to.add_mutually_exclusive_group()
    precision.add_argument("--fidelity", default="auto", choices=["auto", *PRESETS], help=f"{presets}; auto: planned")
    precision.add_argument("--error-db", type=error_budget, metavar="DB", help=ERROR_HELP)
    add_whole_number(to, "--seed", 0, 0, 2**63 - 1, metavar="N", help="default 0")


def add_threads(to: "argparse._ActionsContainer") -> None:
    """Adds the number of processes that compute side by side."""
    to.add_argument(
        "--threads", default=1, type=thread_count, metavar="N",
        help="processes that compute each radar, or auto: all cores but one (default 1; Linux); changes no byte",
    )  # fmt: skip


def add_radar(parser: argparse.ArgumentParser) -> None:
    """Adds the choice of one radar of a scene."""
    parser.add_argument("--radar", metavar="ID", help="one of the scene's [[radar]] tables, by its id (default the first)")


def add_scene(parser: argparse.ArgumentParser) -> None:
    """Adds the scene, which has a default."""
    parser.add_argument("scene", nargs="?", default=DEFAULT_SCENE, metavar="SCENE", help=SCENE_HELP)


def add_jobs(parser: argparse.ArgumentParser) -> None:
    """Adds where jobs are done: processes of this machine, or a cluster; see `workers_of`."""
    jobs = max(1, (os.cpu_count() or 2) - 1)
    where = parser.add_mutually_exclusive_group()
    add_whole_number(where, "--jobs", jobs, 1, 256, metavar="N", help="processes at once (default: all cores but one)")
    add_scheduler(where)


def add_scheduler(to: "argparse._ActionsContainer") -> None:
    """Adds the scheduler of a cluster."""
    to.add_argument(
        "--scheduler",
        metavar="ADDRESS",
        help="of Dask, as tcp://host:8786: its workers do it (extra cluster; docs/scale.md)",
    )


@contextlib.contextmanager
def workers_of(options: argparse.Namespace, memory: int | None = None) -> Iterator[tuple["Executor | None", str]]:
    """What does the jobs of a command, processes of this machine or workers of a scheduler, None for this process; and its
    arithmetic. memory: of each process here, as `processes` takes it.

    Raises UsageError and MissingExtra for a cluster that cannot be used.
    """
    from radar_service.batch.dask_cluster import cluster  # here: the service, whose options stand here too, starts without
    from radar_service.batch.worker_processes import processes
    from radar_service.numerics import arithmetic

    if options.scheduler:
        with cluster(options.scheduler) as workers:
            yield workers
    else:
        with processes(getattr(options, "jobs", 1), memory) as executor:
            yield executor, arithmetic()


def service_groups(parser: argparse.ArgumentParser) -> dict[str, "argparse._ArgumentGroup"]:
    """The groups of options of all that listens on the network, by title."""
    return {title: parser.add_argument_group(title) for title in SERVICE_GROUPS}


def add_network(groups: Mapping[str, "argparse._ActionsContainer"]) -> None:
    """Adds the options of all that listens on the network."""
    what, where, fast, may = (groups[title] for title in ("what", "where", "how fast", "who may"))
    what.add_argument(
        "--scene-folder", action="append", default=[], type=Path, metavar="DIR", help="list the scenes of this folder too"
    )
    what.add_argument(
        "--sandbox-all",
        action="store_true",
        help="parse the files of every scene, not only of uploads, in a limited process",
    )
    where.add_argument("--host", default="127.0.0.1", help="address to listen on (default 127.0.0.1)")
    add_whole_number(where, "--port", 8000, 0, 65535, metavar="N", help="default 8000; 0: any")
    where.add_argument("--allow-host", action="append", default=[], metavar="NAME", help="a host name of this server")
    where.add_argument("--log", default="quiet", choices=["quiet", "text", "json"], help="log events on standard error")
    where.add_argument("--exit-when-failed", action="store_true", help="exit with status 1 when a radar has failed")
    fast.add_argument("--pace", default=1.0, type=pace, metavar="X", help="simulated seconds per second, or max (default 1)")
    begin = "UTC at simulated time 0, in whole seconds, as 2026-12-31T23:59:00 (default now)"
    fast.add_argument("--start-utc", type=utc, metavar="TIME", help=begin)
    add_overwrite(groups["records"])
    waiting = "send nothing until N clients listen to a radar, so that they get its first spoke (default 0)"
    add_whole_number(fast, "--wait-for", 0, 0, 500, metavar="N", help=waiting)
    _add_access(may)


def _add_access(may: "argparse._ActionsContainer") -> None:
    """Adds the options that decide who may do what."""
    may.add_argument("--truth", action="store_true", help="allow clients to read the truth")
    for name, needs in (("--token-file", "every change"), ("--token-file-for-reading", "reading")):
        may.add_argument(name, type=Path, metavar="FILE", help=f"a file whose first line is a token that {needs} needs")
    may.add_argument("--insecure", action="store_true", help="allow everybody who reaches the server to do anything")
    add_whole_number(may, "--connections", None, 1, 100_000, metavar="N", help="maximum number of connections")


if TYPE_CHECKING:
    from radar_service.simulator import Simulator
    from radar_service.world import Scene


@dataclass(frozen=True)
class SimulatorOptions:
    """fidelity: a preset's name or `auto`; error_db: budget that `auto` plans for, None for its own; others as Simulator."""

    fidelity: str = "auto"
    error_db: ErrorBudget | None = None
    seed: int = 0
    threads: int = 1
    labels: bool = False

    def __call__(self, scene: "Scene") -> "Simulator":
        """Returns the simulator of a scene."""
        from radar_service.plan.settings_search import fidelity_for  # here: the service makes options, not simulators
        from radar_service.simulator import Simulator

        fidelity = self.fidelity if self.error_db is None else fidelity_for(scene, self.error_db)
        return Simulator(scene, fidelity, self.seed, self.threads, labels=self.labels)


def simulator_options(options: argparse.Namespace, threads: int = 1, labels: bool = False) -> SimulatorOptions:
    """Returns what the command line says about simulators."""
    return SimulatorOptions(options.fidelity, options.error_db, options.seed, threads, labels)
