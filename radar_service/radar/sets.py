"""Radar sets that are sold, as tables by range scale: the keys of a scene's radar on each scale, and who printed them."""

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from radar_service.numerics import NAUTICAL_MILE, SPEED_OF_LIGHT

TABLE = Path(__file__).with_name("sets.toml")
USUAL_SCALE = 6.0  # NM, of a scene that names none; every set has it
SAME_SCALE = 0.01  # of its length: 24 NM are 44,448 m, and 44.5 km to a display in kilometres
SAMPLING = 1.5  # rate of samples over the band where the length of a spoke gives the rate


@dataclass(frozen=True)
class RadarSet:
    """A set that is sold.

    name: in scene files; of: band, transmitter and antenna.
    scales: by length [m], rising, the keys of a scene's radar; sources: by keys, who printed them.
    """

    name: str
    of: str
    scales: Mapping[float, Mapping[str, Any]]
    sources: Mapping[str, str]

    def scale(self, range_max: float | None) -> float:
        """Returns the scale of this length [m], the usual one for None. Raises ValueError, which names all."""
        length = USUAL_SCALE * NAUTICAL_MILE if range_max is None else range_max
        nearest = min(self.scales, key=lambda scale: abs(scale - length))
        if abs(nearest - length) > SAME_SCALE * nearest:
            scales = ", ".join(f"{scale:g}" for scale in self.scales)
            raise ValueError(
                f'{length:g} m is no range scale of set "{self.name}"; it has {scales} m: give one of them, or remove set'
            )
        return nearest


@cache
def radar_sets() -> Mapping[str, RadarSet]:
    """Returns all sets by name."""
    tables = tomllib.loads(TABLE.read_text(encoding="utf-8"))
    return {name: _radar_set(name, tables.get(table.get("like"), {}) | table) for name, table in tables.items()}


def _radar_set(name: str, table: Mapping[str, Any]) -> RadarSet:
    rows = [dict(zip(table["columns"], row, strict=True)) for row in table["rows"]]
    scales = {nm * NAUTICAL_MILE: row for row in rows for nm in row.pop("range_nm")}
    keys = {scale: _at_scale({**table["keys"], **row}, scale) for scale, row in scales.items()}
    return RadarSet(name, table["of"], keys, table["sources"])


def _at_scale(keys: dict[str, Any], scale: float) -> Mapping[str, Any]:
    """Returns the keys at a scale [m]; the length of a spoke becomes the rate of its samples, to which the band is limited."""
    if samples := keys.pop("samples", None):
        rate = samples * SPEED_OF_LIGHT / (2.0 * scale)
        keys |= {"sample_rate_hz": rate, "bandwidth_hz": min(keys["bandwidth_hz"], rate / SAMPLING)}
    return keys | {"range_max_m": scale}
