"""The environment record: the earth, the air, and the sea."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, NamedTuple

from radar_service.numerics import KNOT, Floats, bearing_text
from radar_service.radar import Radar
from radar_service.world.seaway import Seaway
from radar_service.world.stream import NO_STREAM, Stream


class SightLines(NamedTuple):
    """Straight ways from the antenna to targets (E,).

    antenna: (3,) or (E, 3) on the map [m]; time: one or (E,) [s]; azimuth: (E,) [rad]; distance: slant range (E,) [m].
    """

    antenna: Floats
    time: Floats | float
    azimuth: Floats
    distance: Floats


class Attenuator:
    """What attenuates by place and time. An environment has those among the values of effects' keys."""

    def one_way_db(self, radar: Radar, lines: SightLines) -> Floats:
        """Returns its attenuation (E,) [dB] of a radar's wave along each line."""
        raise NotImplementedError

    @property
    def text(self) -> str:
        """What it is, in a few words."""
        raise NotImplementedError


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

    @property
    def texts(self) -> list[str]:
        """What it has, in a few words each, but for effects' keys."""
        texts = [name for name in ("noise", "multipath", "diffraction", "ground_plane") if getattr(self, name)]
        texts += [f"gas {self.gas_db_per_km:.4g} dB/km one way"] if self.gas_db_per_km else []
        texts += [f"rain {self.rain_mm_h:g} mm/h"] if self.rain_mm_h else []
        texts += [f"sea state {self.sea_state:.3g}"] if self.sea_state else []
        if self.seaway is not None:
            coming_from = bearing_text(self.seaway.towards + math.pi)
            texts.append(f"waves of {self.seaway.height:.3g} m in {self.seaway.period:.3g} s from {coming_from} move ships")
        if any(self.stream):
            texts.append(f"stream of {math.hypot(*self.stream) / KNOT:.3g} kn to {bearing_text(math.atan2(*self.stream))}")
        return texts

    @cached_property
    def attenuators(self) -> tuple[Attenuator, ...]:
        """What attenuates by place and time."""
        return tuple(value for value in self.effect_keys.values() if isinstance(value, Attenuator))
