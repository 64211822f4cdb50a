"""The environment record: the earth, the air, and the sea."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from radar_service.world.seaway import Seaway
from radar_service.world.stream import NO_STREAM, Stream


@dataclass(frozen=True)
class Environment:
    """The earth, the atmosphere and the sea, in SI units; see EnvironmentModel."""

    earth_factor: float  # effective earth radius over the earth's radius; inf is flat
    noise: bool
    multipath: bool
    gas_db_per_km: float  # one way; a number also where the scene has "itu"
    rain_mm_h: float
    sea_state: float  # also where the scene has wave_height_m; 0 for no sea
    effect_keys: Mapping[str, Any] = field(hash=False)  # values of effects' keys, by key
    wind_from: float
    ground_plane: bool
    diffraction: bool = field(default=False, metadata={"added": True})
    seaway: Seaway | None = field(default=None, metadata={"added": True})  # that moves ships
    stream: Stream = field(default=NO_STREAM, metadata={"added": True})  # of the water over ground, east and north [m/s]
