"""A radar that computes nothing, served in a process of its own: python -m tests.measurements.replay AZIMUTHS BINS [SCENE].

At 24 rpm, 4096 azimuths are 1638 spokes/s and 8192 are 3277. With a scene it computes after all: that scene, with so many
azimuths. It prints its address, and when it ends its processor time and how late spokes went out.
"""

import asyncio
import gc
import json
import signal
import sys
import time
from collections.abc import Iterator

import numpy as np

from radar_service.ports.app import create_app
from radar_service.ports.http.server import Requests, Server, configuration, listening_socket
from radar_service.processes.call import Progress
from radar_service.processes.fork_server import ForkServer
from radar_service.records.spokes import SpokeBlock
from radar_service.service.radio.pacer import Schedule
from radar_service.service.radio.scene_process import SceneProcessMaker
from radar_service.service.radio.station import Station, Stations
from radar_service.service.scene_request import SceneRequest
from radar_service.spoke_source import SpokeSource
from tests.measurements.with_azimuths import WithAzimuths
from tests.service.fake import FakeEngine, scene

SETTLING = 3.0  # s of simulation, while clients connect


class ReplayEngine(FakeEngine):
    """The same 32 spokes of noise over and over, at no cost but that of handing them out."""

    def __init__(self, azimuths: int, bins: int) -> None:
        super().__init__(scene(azimuths=azimuths, range_max_m=bins * 10.0, rpm=24))
        noise = np.random.default_rng(0).exponential(1e-15, (32, self.range.size)).astype(np.float32)
        self._noise, self._field = noise, np.sqrt(noise).astype(np.complex64)

    def blocks(self, scans: int | None = None, size: int = 32) -> Iterator[SpokeBlock]:
        radar, first = self.scene.radar, 0
        still, position = np.zeros(32), np.zeros((32, 2))
        while scans is None or first < scans * radar.azimuths:
            n, index = first + np.arange(32), first % radar.azimuths
            yield SpokeBlock(
                first, first // radar.azimuths, index, n * radar.spoke_period, (index + np.arange(32)) * radar.azimuth_step,
                still, position, still, still, self.range, self.range_step, self._field, self._noise,
            )  # fmt: skip
            first += 32


class Recorded(Schedule):
    """A schedule that remembers how late each batch was taken up to be encoded and sent [s]."""

    def __init__(self) -> None:
        super().__init__()
        self.late: list[float] = []
        self.early_slips = 0

    def delay(self, now: float, simulated: float, factor: float) -> float:
        delay = super().delay(now, simulated, factor)
        if simulated <= SETTLING:
            self.early_slips = self.slips
        elif delay <= 0:
            self.late.append(-delay)
        return delay


def engine(azimuths: int, bins: int, name: str, fork_server: ForkServer) -> SpokeSource:
    """The engine of a scene, or where none is named of the same noise over and over."""
    if not name:
        return ReplayEngine(azimuths, bins)
    return SceneProcessMaker(fork_server, WithAzimuths(azimuths))(SceneRequest(name), Progress())


def main(azimuths: int, bins: int, name: str = "") -> None:
    """Serve until SIGTERM."""
    schedule, fork_server = Recorded(), ForkServer()
    source = engine(azimuths, bins, name, fork_server)
    station = Station("0", source, lambda *_: engine(azimuths, bins, name, fork_server), schedule=schedule)
    app = create_app([station], fork_server=fork_server)
    config = configuration(app, connections=2000)
    listener = listening_socket("127.0.0.1", 0)
    server = Server(config, Stations([station]).stop, Requests())
    signal.signal(signal.SIGTERM, lambda *_: None)  # uvicorn stops at it and raises it again, which must not be our end
    gc.collect()
    gc.freeze()
    started = time.process_time()
    with asyncio.Runner(loop_factory=config.get_loop_factory()) as runner:
        runner.run(server.serve(sockets=[listener]))
    late_ms = 1000 * np.array(schedule.late)
    reported = {"processor_s": time.process_time() - started, "slips": schedule.slips - schedule.early_slips}
    print(json.dumps(reported | {"schedule_p99_ms": round(float(np.percentile(late_ms, 99)), 2)}), flush=True)


if __name__ == "__main__":
    main(int(sys.argv[1]), int(sys.argv[2]), *sys.argv[3:])
