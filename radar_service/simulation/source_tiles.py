"""Tiles of the engine with what is requested of their sources: labels, and the power of each source."""

from collections.abc import Iterator, Mapping
from typing import NamedTuple

from radar_service.cell_sources import Labels, Powers, PowersOf, SourceList, SourceRequest
from radar_service.engine.source_numbers import source_numbers
from radar_service.engine.source_powers import SourcePowers
from radar_service.plan.cost_model import SetUp
from radar_service.simulation.engine_set_up import AzimuthEngine, LabelledEngine
from radar_service.types import Flags, Profiles, Singles

DOCUMENTED = "the fidelity 'documented' has none; choose another fidelity"
SEVERAL_PULSES = "a radar with several pulses has none; give it one pulse"


class SourceTile(NamedTuple):
    """Some azimuths (K,) of a scan from `start` on: field [sqrt(W)] and power [W] (K, N), and what is requested of sources."""

    start: int
    field: Profiles
    power: Singles
    labels: Labels | None
    powers: Powers | None


class SourceTiles:
    """The tiles of an engine. request: what they tell of sources; it may change between scans. Powers are computed anew."""

    def __init__(self, engine: AzimuthEngine, set_up: SetUp | None, request: SourceRequest) -> None:
        """set_up: of the engine; None for the specification as printed, which has no sources."""
        self.engine, self.request = engine, request
        self._set_up = set_up
        self._powers: SourcePowers | None = None  # made when they are first requested

    def sources(self, names: Mapping[int, str]) -> SourceList:
        """Returns what spokes can tell of the sources of these names."""
        reason = DOCUMENTED if self._set_up is None else SEVERAL_PULSES
        has_powers = self._set_up is not None and not self._set_up.prepared.scene.radar.near_pulses
        return SourceList(names, "" if isinstance(self.engine, LabelledEngine) else reason, "" if has_powers else reason)

    def scan(self, scan: int, requested: Flags | None) -> Iterator[SourceTile]:
        """Yields the tiles of a scan; only those that hold any of the requested azimuths (A,), where there are flags of these."""
        request = self.request
        if request.labels and isinstance(self.engine, LabelledEngine):
            tiles: Iterator[tuple[int, Profiles, Singles, Labels | None]] = self.engine.labelled_tiles(scan, requested)
        else:
            tiles = ((*tile, None) for tile in self.engine.tiles(scan, requested))
        for start, field, power, labels in tiles:
            yield SourceTile(
                start, field, power, labels, self._powers_of(scan, start, request.powers) if request.powers else None
            )

    def _powers_of(self, scan: int, start: int, of: PowersOf) -> Powers:
        assert self._set_up is not None, "powers of an engine that has none"
        if self._powers is None:
            self._powers = SourcePowers(self._set_up.prepared, source_numbers(self._set_up.prepared.scene))
        return self._powers.computed(scan, start, of).power
