"""The stage of an effect: made once for a scene, it adds to tile after tile."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple, Self

import numpy as np

from radar_service.echo import AzimuthTimes, Beam, BeamPath, BeamWeightedEchoes, MovingEchoes
from radar_service.numerics import STAGE, Complexes, Flags, Profiles, Singles, generator, name_key
from radar_service.radar import Aperture, FieldChange
from radar_service.receive import Compression, receiver_noise_power
from radar_service.records import Fidelity, PlanItem
from radar_service.scattering import ScatteringContext
from radar_service.stages.effect import EffectTruth
from radar_service.trace import OcclusionScene
from radar_service.world import Scene


class Context(NamedTuple):
    """What a stage is made from.

    effect: its name. scene, fidelity, seed: of the simulator. line_of_sight: all that may occlude.
    compression: matched filter, window and noise of the receiver.
    numbers: of its sources, by name. echo_sources: what `BeamWeightedEchoes.body` has for echoes of its sources, by name.
    noise_seed: of what each pulse of a radar has of its own, as its noise.
    scattering: what scatterers of bodies are built from. moving: echoes of bodies that do not rest.
    silent: indices of bodies without echoes.
    """

    effect: str
    scene: Scene
    fidelity: Fidelity
    seed: int
    line_of_sight: OcclusionScene
    compression: Compression
    numbers: Mapping[str, int]
    echo_sources: Mapping[str, int]
    noise_seed: int
    scattering: ScatteringContext
    moving: MovingEchoes
    silent: Collection[int] = ()

    @property
    def noise_power(self) -> float:
        """Mean power of receiver noise [W]."""
        return receiver_noise_power(self.scene.radar)

    def random(self, *key: int) -> np.random.Generator:
        """Random numbers of the effect for one purpose, by its name: they depend on the seed, the scene's radar and the key."""
        return generator(self.seed, STAGE, name_key(self.effect), *self.scene.random_key, *key)


@dataclass(frozen=True)
class RandomField:
    """A random field in the first bins of all azimuths (K,) of a tile, as clutter is.

    field: (K, columns) as drawn [sqrt(W)].
    amplitude: root of its mean power over speckle, (K, columns) or (columns,) [sqrt(W)], wherever the radar transmits.
    """

    field: Profiles
    amplitude: Singles

    def powers(self) -> dict[int, Singles]:
        """The power of the field (K, columns) [W] by the number of its source; new arrays."""
        raise NotImplementedError


@dataclass
class Added:
    """What stages added to a tile. profiles: (bins,) [sqrt(W)] by source number and row. fields: of all azimuths."""

    profiles: dict[int, dict[int, Complexes]] = field(default_factory=dict)
    fields: list[RandomField] = field(default_factory=list)

    def __bool__(self) -> bool:
        return bool(self.profiles or self.fields)


@dataclass
class Tile:
    """Azimuths (K,) that are computed together.

    transmitting: (K,) which are not blind. field: (K, bins) [sqrt(W)], to which stages add.
    added: what they added; None where nobody asks for sources.
    """

    azimuths: AzimuthTimes
    transmitting: Flags
    field: Profiles
    added: Added | None = None

    def add(self, source: int, row: int, received: Complexes) -> None:
        """Adds a profile (bins,) [sqrt(W)] of a source, by its number, to the azimuth of a row."""
        self.field[row] += received
        if self.added is not None:
            rows = self.added.profiles.setdefault(source, {})
            rows[row] = rows.get(row, 0.0) + received

    def add_field(self, received: RandomField) -> None:
        """Adds a random field."""
        self.field[:, : received.field.shape[1]] += received.field
        if self.added is not None:
            self.added.fields.append(received)


class Stage:
    """An effect, ready for any azimuth of a scene. It can be pickled. has_echoes: whether it has `echoes`."""

    has_echoes: bool = False

    @classmethod
    def of(cls, context: Context) -> Self:
        """The stage of a scene; called where the plan models the effect."""
        return cls()

    @classmethod
    def plan(cls, scene: Scene, fidelity: Fidelity, microseconds: float | None) -> Sequence[PlanItem]:
        """Returns its lines of the plan of a scene that asks for it, prepared or not. microseconds: its costs [us]."""
        return ()

    @classmethod
    def truth(cls, scene: Scene, line_of_sight: OcclusionScene) -> EffectTruth | None:
        """What it tells of the scene; None for nothing."""
        return None

    @classmethod
    def field_changes(cls, record: Any, aperture: Aperture, wavelength: float, extent: float) -> Sequence[FieldChange]:
        """Returns what the effect takes from the antenna's field, as far off boresight as `extent` [rad].

        record: of a radar, on which alone it depends; aperture: of its antenna; wavelength: [m].
        """
        return ()

    @classmethod
    def paths(cls, scene: Scene, beam: Beam, echo_sources: Mapping[str, int]) -> Sequence[BeamPath]:
        """Returns further paths of the echoes of all bodies, of an effect that `has_paths`; echo_sources: as of `Context`."""
        return ()

    def echoes(self, azimuths: AzimuthTimes) -> BeamWeightedEchoes:
        """Echoes (E,) before the receiver's filter at consecutive azimuths (K,); also of earlier instants, where those of earlier
        pulses count."""
        raise NotImplementedError

    def add(self, tile: Tile) -> None:
        """Adds what comes behind the receiver's filter to a tile."""
