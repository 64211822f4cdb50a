"""A radar that computes nothing, served in a process of its own: python -m tests.bench.replay AZIMUTHS BINS.

At 24 rpm, 4096 azimuths are 1638 spokes/s and 8192 are 3277. It prints its address, and its processor time when it ends.
"""

import asyncio
import json
import signal
import sys
import time
from collections.abc import Iterator

import numpy as np

from radar_service.records import SpokeBlock
from radar_service.stream.app import create_app
from radar_service.stream.server import Server, configuration, listening_socket
from radar_service.stream.station import Station
from tests.stream.fake import FakeEngine, scene


class ReplayEngine(FakeEngine):
    """The same 32 spokes of noise over and over, at no cost but that of handing them out."""

    def __init__(self, azimuths: int, bins: int) -> None:
        super().__init__(scene(azimuths=azimuths, range_max_m=bins * 10.0, rpm=24))
        noise = np.random.default_rng(0).exponential(1e-15, (32, self.range.size)).astype(np.float32)
        self._noise, self._field = noise, np.sqrt(noise).astype(np.complex64)

    def blocks(self, scans: int | None = None, size: int = 32) -> Iterator[SpokeBlock]:
        radar, first = self.scene.radar, 0
        still, place = np.zeros(32), np.zeros((32, 2))
        while scans is None or first < scans * radar.azimuths:
            n, index = first + np.arange(32), first % radar.azimuths
            yield SpokeBlock(
                first, first // radar.azimuths, index, n * radar.spoke_period, (index + np.arange(32)) * radar.azimuth_step,
                still, place, still, still, self.range, self.range_step, self._field, self._noise,
            )  # fmt: skip
            first += 32


def main(azimuths: int, bins: int) -> None:
    """Serve until SIGTERM."""
    station = Station("0", ReplayEngine(azimuths, bins), lambda of: ReplayEngine(azimuths, bins))
    app = create_app([station])
    config = configuration(app, connections=2000)
    listener = listening_socket("127.0.0.1", 0)
    server = Server(config, [station], lambda: None)
    signal.signal(signal.SIGTERM, lambda *_: None)  # uvicorn stops at it and raises it again, which must not be our end
    started = time.process_time()
    with asyncio.Runner(loop_factory=config.get_loop_factory()) as runner:
        runner.run(server.serve(sockets=[listener]))
    print(json.dumps({"processor_s": time.process_time() - started}), flush=True)


if __name__ == "__main__":
    main(int(sys.argv[1]), int(sys.argv[2]))
