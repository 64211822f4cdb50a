"""False echoes by own ship's structures: of bodies all round, at the azimuths at which the antenna lights a structure.

They come from the range histories of moving echoes, with a beam of gain 1 all round. So bodies by aspect have echoes at the
azimuths that light a structure too, where the beam has long passed them: with the aspect of its crossing (`held_passages`), or
with nodes as close as on boresight.
"""

import numpy as np

from radar_service.echo.beam_paths import Beam, Sights, false_echoes
from radar_service.echo.echoes import AzimuthTimes, BeamWeightedEchoes, concatenated
from radar_service.echo.moving import MovingEchoes
from radar_service.echo.moving_beam import BeamTable
from radar_service.echo.visibility import Visibility
from radar_service.numerics.types import Complexes, Flags
from radar_service.radar.parameters import Radar
from radar_service.stages.structures.held_passages import HeldPassages
from radar_service.stages.structures.reflection import Reflector, structure_reflectors
from radar_service.world.scene import Scene

SPAN = 0.5  # rad of boresights computed together, at most


class IndirectPaths:
    """Paths by own ship's structures: there and back by one, and one way by it. Their echoes are false.

    They stand where boresight points at the structure, farther off than the target by the detour or by half of it. A target has
    the echoes that the antenna receives of it: from a structure some metres off, scatterers add up with other phases.
    """

    def __init__(self, radar: Radar, beam: Beam, source: int) -> None:
        """source: as of `false_echoes`."""
        self._radar, self._beam, self._source, self._reflectors = radar, beam, source, structure_reflectors(radar)

    def are_lit(self, scene: Scene, azimuths: AzimuthTimes) -> Flags:
        """At which azimuths (K,) any structure may be lit."""
        boresight = azimuths.boresight - scene.platform.heading(azimuths.time)
        return np.asarray(np.any([reflector.is_lit(boresight) for reflector in self._reflectors], axis=0))

    def received(self, echoes: BeamWeightedEchoes, sights: Sights) -> BeamWeightedEchoes:
        """The false echoes of all structures."""
        direct = self._beam.field(sights)
        parts = [part for reflector in self._reflectors for part in self._by(reflector, echoes, sights, direct)]
        return concatenated(parts, len(sights.boresight))

    def _by(
        self, reflector: Reflector, echoes: BeamWeightedEchoes, sights: Sights, direct: Complexes
    ) -> list[BeamWeightedEchoes]:
        """Paths there and back by one structure, and paths one way by it."""
        field, ray = reflector.field(sights.from_bow, sights.boresight - sights.heading)
        return [
            false_echoes(self._radar, echoes, field**2, ray.detour, self._source),
            false_echoes(self._radar, echoes, 2.0 * direct * field, 0.5 * ray.detour, self._source),
        ]


class IndirectEchoes:
    """The indirect echoes of the bodies of a set. Safe to call from several threads."""

    def __init__(
        self, scene: Scene, visibility: Visibility, paths: IndirectPaths, seed: int, direct: MovingEchoes | None = None
    ) -> None:
        """direct: echoes whose aspects serve; None: bodies have aspects of their own."""
        self._scene, self._visibility, self._paths, self._seed = scene, visibility, paths, seed
        self.is_held = direct is not None
        all_round = BeamTable(np.ones_like, scene.radar.beamwidth, np.pi, SPAN)
        held = None if direct is None else HeldPassages(scene, visibility, direct.passages)
        self._moving = MovingEchoes(scene, visibility, all_round, seed, paths=[self._paths], passages=held)

    def of_scene(self, scene: Scene, direct: MovingEchoes) -> "IndirectEchoes":
        """Returns the same echoes in a scene whose rotation has another origin; direct: those of that scene."""
        visibility = self._visibility.of_scene(scene)
        return IndirectEchoes(scene, visibility, self._paths, self._seed, direct if self.is_held else None)

    def __len__(self) -> int:
        """How many bodies have such echoes."""
        return len(self._moving)

    def echoes(self, azimuths: AzimuthTimes) -> BeamWeightedEchoes:
        """All of them at azimuths over which no body comes or goes; none where no structure is lit."""
        if not self._paths.are_lit(self._scene, azimuths).any():
            return concatenated([], len(azimuths.time))
        return self._moving.echoes(azimuths)
