"""What a run costs a scheduler of Dask, and what a sweep costs by the scene: `python -m tests.measurements.cluster_constants`.

It prints the processor time of the scheduler for a task that does nothing, the bytes that a task is pickled to, and the dry runs
of an hour of radar in two shipped scenes. docs/scale.md calculates with them.
"""

import os
import pickle
from pathlib import Path
from tempfile import TemporaryDirectory

from radar_service.batch.dask_cluster import cluster
from radar_service.batch.jobs import Job, limited, run
from radar_service.processes.limits import processor_time_of
from radar_service.sweep.estimate import estimate
from radar_service.sweep.inputs import inputs_of
from radar_service.sweep.layout import layout_of
from radar_service.sweep.sweep import run as run_task
from tests.batch.loopback_cluster import loopback_cluster

TASKS = 1000
SCANS_AN_HOUR = 24 * 60  # at 24 rpm


def nothing(number: int) -> None:
    """Does nothing."""


def main() -> None:
    task = "s3://bucket/folder/sweep.zarr", "0" * 32, 123_456
    print(f"a task: {len(pickle.dumps((limited, run_task, *task)))} bytes")
    with loopback_cluster(2) as scheduler, cluster(scheduler) as (executor, _):
        (pid,) = (int(p) for p in Path(f"/proc/{os.getpid()}/task/{os.getpid()}/children").read_text().split())
        run(nothing, [Job("first", (0,))], executor)
        before, own = processor_time_of(pid) or 0.0, os.times()
        run(nothing, [Job(f"{k}", (k,)) for k in range(TASKS)], executor)
        after, now = processor_time_of(pid) or 0.0, os.times()
        print(
            f"a task: {(after - before) / TASKS * 1e3:.2f} ms of the scheduler, "
            f"{(now[0] - own[0]) / TASKS * 1e3:.2f} ms of the client"
        )
    with TemporaryDirectory() as folder:
        for scene in ("open-sea", "harbour"):
            (Path(folder) / "sweep.toml").write_text(f'scene = "{scene}"\nscans = {SCANS_AN_HOUR}\n')
            of = inputs_of(Path(folder) / "sweep.toml")
            print(estimate(of, layout_of(of)))


if __name__ == "__main__":
    main()
