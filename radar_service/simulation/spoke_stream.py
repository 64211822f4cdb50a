"""The spokes of a simulator in order: tiles of the engine as blocks, as commands steer them and as sensors report them."""

import math
from collections.abc import Generator, Iterator, Mapping, Sequence
from contextlib import closing
from dataclasses import replace
from threading import Lock
from typing import Any

import numpy as np

from radar_service.errors.reporter import ErrorReporter
from radar_service.numerics import BLAS_LIMIT, Floats, Indices
from radar_service.records import OwnShipTruth, Readings, SourceRequest, SpokeBlock, regrouped
from radar_service.scans import Sector
from radar_service.simulation.engine_set_up import SourceTile
from radar_service.simulation.tile_processes import TileProcesses
from radar_service.world import Command, Steering


class SpokeStream:
    """Computes blocks from one spoke on. All but `blocks` and `skip_to` may be called from any thread.

    steering: the commands. reporter: the errors of sensors, antenna and feed. next_scan, next_spoke: what comes next.
    request: what spokes tell of their sources.
    """

    def __init__(self, tiles: TileProcesses, steering: Steering, sector: Sector, reporter: ErrorReporter) -> None:
        """tiles: what the engine computes."""
        self.steering, self.reporter = steering, reporter
        self.next_scan = self.next_spoke = 0
        self._tiles, self._sector = tiles, sector
        self._radar = steering.scene.radar
        self.request, self._requests, self._again = tiles.request, 0, math.inf
        self._commanding, self._first = Lock(), 0

    def blocks(self, scans: int | None, size: int) -> Iterator[SpokeBlock]:
        """Yields blocks as Simulator.blocks. Where a command or a request acts on spokes that were computed, it goes back to
        the first of them."""
        azimuths = self._radar.azimuths
        at, left = self.next_scan * azimuths, math.inf if scans is None else scans
        while left > 0:
            self._begin(at)
            with closing(self._rest_of_scan(at, size)) as blocks:
                for block in blocks:
                    part = self._as_commanded(block)
                    if part is not None:
                        yield self.reporter.reported(part, self.readings)
                    if self._due <= self.next_spoke:
                        break
            scan, back = at // azimuths, self._overtaken()
            at = self.next_scan * azimuths if back is None else back
            left -= 1 if back is None else back // azimuths - scan

    def skip_to(self, scan: int) -> None:
        """Makes `scan` the next one. Commands that act earlier are followed from there on."""
        self.next_scan = max(scan, 0)
        self.next_spoke = self._first = self.next_scan * self._radar.azimuths
        self.reporter = self.reporter.restarted(self.next_spoke)

    def command(self, body: str | None, spoke: int | None, time: float | None, values: Mapping[str, Any]) -> Command:
        """Adds a command as Simulator.command. Raises CommandError."""
        with self._commanding:
            at = self.next_spoke if spoke is None and time is None else spoke
            return self.steering.add(at, body, values, self.next_spoke, time)

    def take(self, command: Command) -> None:
        """Adds a command as Simulator.take."""
        with self._commanding:
            self.steering.take(command, self.next_spoke)

    def request_sources(self, request: SourceRequest, spoke: int | None) -> None:
        """Changes what the spokes tell of their sources, as Simulator.request_sources."""
        with self._commanding:
            self.request, self._requests = request, self._requests + 1
            self._again = min(self._again, self.next_spoke if spoke is None else max(spoke, 0))

    def readings(self, number: Indices) -> Readings:
        """Returns true boresight and own ship of spokes of these numbers (K,), which are computed or earlier ones."""
        return self._readings(*self._radar.schedule(number))

    def reported(self, number: Indices) -> Readings:
        """Returns boresight and own ship of spokes of these numbers (K,) as they report them, by the errors of the first."""
        laws, true = self.reporter.laws_at(int(number[0])), self.readings(number)
        return true if laws is None else laws.reported(number, self._radar.schedule(number)[1], true, self.readings)

    def _readings(self, boresight: Floats, time: Floats) -> Readings:
        """The readings of spokes at boresights [rad] and times [s] (K,)."""
        own = self.steering.past.own_ship.pose(time)
        return Readings(boresight, own.heading, own.position[:, :2], own.course, own.speed)

    def with_reports(self, own: Sequence[OwnShipTruth], scans: Sequence[int], spokes: Sequence[int]) -> list[OwnShipTruth]:
        """Returns own ship with what the nearest spokes of scans report."""
        nearest = [min(spoke, self.reporter.last_spoke(scan)) for scan, spoke in zip(scans, spokes, strict=True)]
        reports = self.reporter.own_ships(own, nearest, self.readings)
        return [replace(each, reported=report) for each, report in zip(own, reports, strict=True)]

    def _begin(self, spoke: int) -> None:
        """Makes ready to compute from this spoke on, as commanded until there."""
        with self._commanding:
            self.next_scan, self.next_spoke = spoke // self._radar.azimuths + 1, spoke
            self.steering.go_to(spoke)
            self._tiles.request = self.request
            self._again = math.inf if max(self._again, self._first) >= spoke else self._again

    def _rest_of_scan(self, spoke: int, size: int) -> Generator[SpokeBlock, None, None]:
        """The blocks from this spoke to the end of its scan."""
        scan, index = divmod(spoke, self._radar.azimuths)
        sector = self._sector.after(index)
        computed = (self._block(scan, tile) for tile in self._tiles.scan(scan, sector.requested))
        for stretch in sector.stretches(computed):
            yield from BLAS_LIMIT.each(regrouped(stretch, size))

    def _as_commanded(self, block: SpokeBlock) -> SpokeBlock | None:
        """The spokes of a block before the next command or request, which count as taken from now on; None: there are none."""
        with self._commanding:
            count = min(len(block), int(min(self._due, block.first + len(block))) - block.first)
            self.next_spoke = block.first + max(count, 0)
            if count <= 0:
                return None
            part = block if count == len(block) else block.part(0, count)
            count, requests = self.steering.count, self._requests
            return replace(part, commands=count, requests=requests) if count or requests else part

    @property
    def _due(self) -> float:
        """The first spoke that what is computed now does not hold for, none before that of the last skip."""
        return max(min(self.steering.due, self._again), self._first)

    def _overtaken(self) -> int | None:
        """The spoke to go on from where a command or a request acts that the last blocks do not show; else None."""
        with self._commanding:
            return int(self._due) if self._due <= self.next_spoke else None

    def _block(self, scan: int, tile: SourceTile) -> SpokeBlock:
        number = scan * self._radar.azimuths + np.arange(tile.start, tile.start + len(tile.field))
        boresight, time = self._radar.schedule(number)
        readings = self._readings(boresight, time)
        return SpokeBlock(
            int(number[0]), scan, tile.start, time, *readings, self._tiles.engine.range, self._radar.range_step,
            tile.field, tile.power, labels=tile.labels, powers=tile.powers,
        )  # fmt: skip
