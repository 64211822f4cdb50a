"""Days of running in minutes: `pytest -m study -s tests/ports/test_soak.py` prints what a day of spokes leaves behind.

The hub, the client queues, the pacing and the wire are the real ones; the radar makes the same samples over and over.
"""

import asyncio
import json
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import pytest

from radar_service import wire
from radar_service.service.fanout.client_queue import CATCH_UP_BYTES, ClientQueue
from radar_service.service.fanout.hub import EncodedBatch, Hub
from radar_service.service.feed_request import View
from radar_service.service.radio.pacer import BATCH_SPOKES, Schedule
from tests.service.held import ResultCache, held

ROOT = Path(__file__).parents[2]
DAY = 24 * 3600 * 1638  # spokes of 24 rpm and 4096 azimuths: 142 million
PERIOD = 60.0 / 24 / 4095  # s; no binary fraction, so that a sum of them would drift
BINS = 1024
COME_BACK = 997  # batches after which one client goes and comes again, and asks for what it missed
SNAPSHOTS = 16  # of what the process holds
SETTLED = 4  # snapshots after which every buffer has been full


class Reader:
    """A client that reads all there is. seen: the number after the last one; wrong: what did not follow."""

    def __init__(self, hub: Hub, view: View, checks_content: bool) -> None:
        self._hub, self._view, self._checks_content = hub, view, checks_content
        self.seen, self.returns = 0, 0
        self._client = ClientQueue(view)
        hub.join(self._client)

    def come_back(self) -> None:
        """Leave without having read what is queued, and ask for it again."""
        self._hub.leave(self._client)
        self._client = ClientQueue(self._view)
        self._hub.join(self._client, ("e", self.seen))
        self.returns += 1

    async def read(self) -> None:
        while self._client.waiting:
            item = await self._client.get()
            assert item is not None
            if not item.count:
                continue  # a hello
            assert item.first == self.seen and item.droppable  # no gap, no double
            if self._checks_content:
                message = wire.unpack(item.data)
                times, numbers = message["time"], (item.first, item.first + item.count - 1)
                assert (message["first"], message["count"]) == (item.first, item.count)
                assert (times[0], times[-1]) == (numbers[0] * PERIOD, numbers[1] * PERIOD)
            self.seen = item.first + item.count


def message(first: int, samples: bytes) -> dict[str, Any]:
    """Spokes as the feed sends them, with only the fields that the hub and these clients read."""
    number = range(first, first + BATCH_SPOKES)
    fields = {"type": "spokes", "epoch": "e", "first": first, "count": BATCH_SPOKES, "data": samples}
    return fields | {"time": [n * PERIOD for n in number]}


async def soak(spokes: int) -> list[ResultCache]:
    """So many spokes to readers, one that comes and goes, and one that never reads; what was held on the way."""
    hub, schedule, view, snapshots = Hub(time.monotonic), Schedule(), View("u8"), list[ResultCache]()
    hub.open_epoch("e", lambda view, mode: wire.pack({"type": "hello", "epoch": "e"}))
    samples, batches = bytes(BATCH_SPOKES * BINS), spokes // BATCH_SPOKES
    readers = [Reader(hub, view, checks_content=n == 0) for n in range(4)]
    hub.join(stalled := ClientQueue(view))
    for k in range(batches):
        first = k * BATCH_SPOKES
        assert abs(schedule.delay(7.0 + first * PERIOD, first * PERIOD, 1.0)) < 1e-10  # s: 7 + 86 400 s to 53 bits
        await hub.publish(EncodedBatch("e", first, BATCH_SPOKES, {view: wire.pack(message(first, samples))}))
        if k % COME_BACK == COME_BACK - 1:
            readers[-1].come_back()
        for reader in readers:
            await reader.read()
        if k % (batches // SNAPSHOTS) == 0:
            snapshots.append(held())
    assert [reader.seen for reader in readers] == [hub.next] * 4 == [batches * BATCH_SPOKES] * 4
    batches_left = [item for item in stalled.waiting if item.droppable]
    assert stalled.lost + len(batches_left) * BATCH_SPOKES == hub.next
    assert sum(len(item.data) for item in batches_left) < 2 * CATCH_UP_BYTES
    assert readers[-1].returns == batches // COME_BACK
    return snapshots


@pytest.mark.parametrize("spokes", [DAY // 2000, pytest.param(DAY, marks=pytest.mark.study)])
def test_a_day_of_spokes_through_the_hub_leaves_nothing_behind(spokes: int) -> None:
    """142 million in batches of 32; four clients receive every one of them in order, and its time to the last bit. In a process
    of its own, where no other test's threads make anything."""
    command = [sys.executable, "-m", "tests.ports.test_soak", str(spokes)]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    seconds, *rest = json.loads(done.stdout)
    snapshots = [ResultCache(*snapshot) for snapshot in rest]
    print(f"\n{spokes / 1e6:.1f} million spokes in {seconds:.0f} s of processor time; resident MiB:",
          [round(snapshot.memory / 2**20, 1) for snapshot in snapshots],
          "then tasks, threads, files, objects:", snapshots[-1][1:])  # fmt: skip
    settled, last = snapshots[SETTLED], snapshots[-1]
    assert last[1:4] == settled[1:4]
    assert last.memory - settled.memory < 2 * 2**20  # bytes: less than the allocator's own arenas come and go by
    assert abs(last.objects - settled.objects) < 100


if __name__ == "__main__":
    held_then = asyncio.run(soak(int(sys.argv[1])))
    print(json.dumps([time.process_time(), *held_then]))
