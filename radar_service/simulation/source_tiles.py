"""Tiles of the engine with what is requested of their sources: labels, and the power of each source."""

from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from typing import NamedTuple

from radar_service.engine.preparation import Prepared
from radar_service.numerics.types import Flags, Profiles, Singles
from radar_service.records.cell_sources import Labels, Powers, SourceList, SourceRequest
from radar_service.simulation.engine_set_up import AzimuthEngine, LabelledEngine
from radar_service.sources.numbers import source_numbers
from radar_service.sources.power_window import PulsePowers, ScanPowers, pulse_powers

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
