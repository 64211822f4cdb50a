"""Tiles of the engine with what is requested of their sources: labels, powers, the radiometric truth of crossings."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from threading import Lock
from typing import NamedTuple

from radar_service.engine.preparation import Prepared
from radar_service.numerics.types import Flags, Profiles, Singles
from radar_service.records.cell_sources import Labels, Powers, SourceList, SourceRequest
from radar_service.records.fidelity import Fidelity
from radar_service.records.truth import Crossing
from radar_service.simulation.engine_set_up import AzimuthEngine, LabelledEngine, pipeline_set_up, prepared_pulses
from radar_service.sources.numbers import source_numbers
from radar_service.sources.power_window import PulsePowers, ScanPowers, pulse_powers, scan_powers
from radar_service.sources.radiometric import RadiometricTruth
from radar_service.world.steering import Steering

DOCUMENTED = "the fidelity 'documented' has none; choose another fidelity"


class SourceTile(NamedTuple):
    """Some azimuths (K,) of a scan from `start` on: field [sqrt(W)] and power [W] (K, N), and what is requested of sources."""

    start: int
    field: Profiles
    power: Singles
    labels: Labels | None
    powers: Powers | None


class SourceTiles:
    """The tiles of an engine. Powers are computed anew.

    request: what they tell of sources; it may change between scans.
    length: azimuths in a tile; 0 for the specification as printed.
    """

    def __init__(self, engine: AzimuthEngine, pulses: Sequence[Prepared], request: SourceRequest) -> None:
        """pulses: the scene prepared for each, as of EngineSetUp; the specification as printed has none, and no sources."""
        self.engine, self.request = engine, request
        self._pulses = pulses
        self.length = pulses[-1].tile if pulses else 0

    @cached_property
    def _powers(self) -> list[PulsePowers]:
        return pulse_powers(self._pulses, source_numbers(self._pulses[-1].scene))

    def sources(self, names: Mapping[int, str]) -> SourceList:
        """Returns what spokes can tell of the sources of these names."""
        reason = "" if self._pulses else DOCUMENTED
        return SourceList(names, reason, reason)

    def scan(self, scan: int, requested: Flags | None) -> Iterator[SourceTile]:
        """Yields the tiles of a scan; only those that hold any of the requested azimuths (A,), where there are flags of these."""
        request = self.request
        if request.labels and isinstance(self.engine, LabelledEngine):
            tiles: Iterator[tuple[int, Profiles, Singles, Labels | None]] = self.engine.labelled_tiles(scan, requested)
        else:
            tiles = ((*tile, None) for tile in self.engine.tiles(scan, requested))
        powers = ScanPowers(self._powers, scan, request.powers) if request.powers else None
        for start, field, power, labels in tiles:
            yield SourceTile(start, field, power, labels, powers.between(start, start + len(field)) if powers else None)


class SourceTruth:
    """Computes azimuths again, source by source. Safe to call from several threads.

    A steered run is computed from its past: a second preparation, whose bodies move as they were commanded at each time.
    """

    def __init__(
        self, steering: Steering, fidelity: Fidelity, requested: str | Fidelity, seed: int, pulses: tuple[Prepared, ...]
    ) -> None:
        """fidelity: of the requested one; pulses: those of the run; none for the fidelity `documented`, which has no sources."""
        self._steering, self._fidelity, self._requested, self._seed = steering, fidelity, requested, seed
        self._pulses = pulses
        self._past: tuple[Prepared, ...] = ()
        self._radiometric: RadiometricTruth | None = None
        self._followed = 0  # commands that both know
        self._lock = Lock()

    def powers(self, scan: int) -> dict[int, Singles]:
        """Returns what Simulator.source_powers returns. Raises ValueError for the fidelity `documented`."""
        with self._lock:
            pulses = self._prepared("source_powers")
            return scan_powers(pulse_powers(pulses, source_numbers(self._steering.scene)), scan)

    def measured(self, crossings: tuple[Crossing, ...]) -> tuple[Crossing, ...]:
        """Returns crossings with their radiometric part. Raises ValueError for the fidelity `documented`."""
        index = {body.name: k for k, body in enumerate(self._steering.scene.bodies)}
        with self._lock:
            pulses = self._prepared("radiometric")
            if self._radiometric is None:
                self._radiometric = RadiometricTruth(pulses)
            return tuple(
                replace(crossing, **vars(self._radiometric.at(index[crossing.body], crossing.spoke)))
                for crossing in crossings
            )

    def _prepared(self, name: str) -> tuple[Prepared, ...]:
        """What to compute from, for each pulse. name: of the argument or method that needs it."""
        if not self._pulses:
            raise ValueError(f"{name}: the fidelity 'documented' has none; choose another fidelity")
        past = self._steering.past
        if past is self._steering.scene:
            return self._pulses
        if not self._past:
            last = pipeline_set_up(past, self._fidelity, self._seed).prepared
            self._past = prepared_pulses(past, last, self._requested, self._seed)
        if self._followed != self._steering.count:
            self._radiometric, self._followed = None, self._steering.count
        return self._past
