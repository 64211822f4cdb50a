"""A cluster of Dask: what is done there, what is refused before anything begins, and workers that die."""

import json
import os
import signal
from collections.abc import Iterator
from importlib.metadata import version
from pathlib import Path
from typing import Any

import pytest

from radar_service.__main__ import main
from radar_service.batch.dask_cluster import ClusterError, check_versions, cluster, common_facts, worker_facts
from radar_service.batch.jobs import Job, JobsFailed, run
from radar_service.numerics.arithmetic_name import arithmetic
from tests.batch.loopback_cluster import loopback_cluster
from tests.sweep.sweeps import content, swept


@pytest.fixture(scope="module", autouse=True)
def dask() -> None:
    pytest.importorskip("distributed")  # here and not above: each process collects, one runs these tests


@pytest.fixture(scope="module")
def scheduler() -> Iterator[str]:
    with loopback_cluster(1) as address:
        yield address


def squared(number: int) -> int:
    if number < 0:
        raise ValueError(f"{number} is negative")
    return number**2


def dies_once(folder: Path) -> int:
    if not (folder / "died").exists():
        (folder / "died").touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return os.getpid()


def test_jobs_are_done_there_and_fail_alone(scheduler: str) -> None:
    with cluster(scheduler) as (executor, of_workers):
        assert of_workers == arithmetic()
        assert run(squared, [Job(f"job {k}", (k,)) for k in range(5)], executor) == [0, 1, 4, 9, 16]
        assert run(os.getpid, [Job("where", ())], executor) != [os.getpid()]
        with pytest.raises(JobsFailed, match="1 failed and 1 of 2 are done; job -1: -1 is negative") as failed:
            run(squared, [Job(f"job {k}", (k,)) for k in (-1, 1)], executor)
    assert isinstance(failed.value.__cause__, ValueError)


def test_a_worker_that_dies_loses_no_job(scheduler: str, tmp_path: Path) -> None:
    with cluster(scheduler) as (executor, _):
        assert run(dies_once, [Job("dies", (tmp_path,))], executor) != [os.getpid()]


def test_a_sweep_there_has_the_bytes_of_one_here(scheduler: str, tmp_path: Path) -> None:
    with cluster(scheduler) as (executor, of_workers):
        _, there, tally = swept(tmp_path / "there", executor=executor, arithmetic=of_workers)
    _, here, _ = swept(tmp_path / "here")
    assert content(there) == content(here) and (tally.done, tally.failed) == (4, {})


@pytest.mark.parametrize(
    ("address", "message"),
    [("tcp://127.0.0.1:1", "no scheduler of Dask answers there"), ("nonsense", "no scheduler of Dask answers there"),
     ("ftp://127.0.0.1:1", "no scheduler of Dask answers there")],
)  # fmt: skip
def test_a_scheduler_that_is_absent_is_told_in_a_sentence(
    address: str, message: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("radar_service.batch.dask_cluster.CONNECT_SECONDS", 0.2)
    with pytest.raises(ClusterError, match=rf"^--scheduler {address}: {message} \(.*\); start one by `dask scheduler`"):
        with cluster(address):
            pass


PACKAGES = {
    "python": "3.11.7.final.0",
    "dask": "2026.8.0",
    "distributed": "2026.8.0",
    "cloudpickle": "3",
    "msgpack": "1",
}


@pytest.mark.parametrize(
    ("scheduler_has", "worker_has", "message"),
    [
        ({"distributed": "2020.1"}, {}, "the scheduler has distributed 2020.1, and this machine 2026.8.0"),
        ({}, {"python": "3.12.1.final.0"}, "worker w has python 3.12, and this machine 3.11"),
        ({}, {"cloudpickle": None}, "worker w has cloudpickle None, and this machine 3"),
    ],
)
def test_other_versions_are_refused(scheduler_has: dict[str, str], worker_has: dict[str, str], message: str) -> None:
    versions = {
        "client": {"packages": PACKAGES}, "scheduler": {"packages": PACKAGES | scheduler_has},
        "workers": {"w": {"packages": PACKAGES | worker_has}},
    }  # fmt: skip
    with pytest.raises(ClusterError, match=f"^--scheduler tcp://x: {message}; install the same version$"):
        check_versions("tcp://x", versions)
    equal = {
        "client": {"packages": PACKAGES},
        "scheduler": {"packages": PACKAGES | {"python": "3.11.9"}},
        "workers": {},
    }
    check_versions("tcp://x", equal)


@pytest.mark.parametrize(
    ("facts", "message"),
    [
        ({}, "it has no workers; start some by `dask worker tcp://x`"),
        (
            {"w": ModuleNotFoundError("No module named 'radar_service'")},
            r"worker w has no usable radar-service \(ModuleNotFound.*install 0",
        ),
        ({"w": {"version": "0.0.1", "arithmetic": "a"}}, "worker w has radar-service 0.0.1, and this machine 0"),
        (
            {"v": {"arithmetic": "a"}, "w": {"arithmetic": "b"}},
            "workers round differently: v computes by a, w by b; start workers on equal",
        ),
    ],
)
def test_workers_that_cannot_do_it_are_refused(facts: dict[str, Any], message: str) -> None:
    filled = {
        name: {"version": version("radar-service"), **each} if isinstance(each, dict) else each
        for name, each in facts.items()
    }
    with pytest.raises(ClusterError, match=f"^--scheduler tcp://x: {message}"):
        common_facts("tcp://x", filled)
    assert common_facts("tcp://x", {"w": worker_facts()}) == {
        "version": version("radar-service"),
        "arithmetic": arithmetic(),
    }


@pytest.mark.study
def test_workers_without_the_package_are_told(scheduler: str, tmp_path: Path) -> None:
    """One joins whose Python does not find it."""
    with loopback_cluster(1, without="radar_service") as address:
        with pytest.raises(ClusterError, match="has no usable radar-service .*radar_service.*; install "), cluster(address):
            pass


@pytest.mark.study
@pytest.mark.parametrize("command", ["bench-detection", "bench-tracker", "chart"])
def test_benches_and_charts_on_a_cluster_are_those_of_this_machine(command: str, scheduler: str, tmp_path: Path) -> None:
    words = {
        "bench-detection": ["--scans", "40", "--ranges", "2"], "chart": ["far-target", "--quick"],
        "bench-tracker": ["missed-scans", "--smoke", "--plots", str(tmp_path / "plots")],
    }[command]  # fmt: skip
    name = {"bench-detection": "detection.json", "bench-tracker": "report.json", "chart": "chart.json"}[command]
    results = []
    for where in ((), ("--scheduler", scheduler)):
        main([command, *words, "-o", str(tmp_path / f"out{len(where)}"), *where])
        results.append(json.loads((tmp_path / f"out{len(where)}" / name).read_text()))
    if command == "chart":  # how often it repeats hangs on times, which are of another process
        results = [[(point["panel"], point["family"], point["setting"]) for point in result["points"]] for result in results]
    assert results[0] == results[1]
