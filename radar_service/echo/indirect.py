"""False echoes by own ship's structures: of bodies all round, at the azimuths at which the antenna lights a structure.

They come from the range histories of moving echoes, with a beam of gain 1 all round. So bodies by aspect have echoes at the
azimuths that light a structure too, where the beam has long passed them: with the aspect of its crossing (`held_passages`), or
with nodes as close as on boresight.
"""

import numpy as np

from radar_service.echo.beam_paths import IndirectPaths
from radar_service.echo.echoes import AzimuthTimes, BeamWeightedEchoes, concatenated
from radar_service.echo.held_passages import HeldPassages
from radar_service.echo.moving import MovingEchoes
from radar_service.echo.moving_beam import BeamTable
from radar_service.echo.visibility import Visibility
from radar_service.world.scene import Scene

SPAN = 0.5  # rad of boresights computed together, at most


class IndirectEchoes:
    """The indirect echoes of the bodies of a set. Safe to call from several threads."""

    def __init__(
        self, scene: Scene, visibility: Visibility, extent: float, seed: int, direct: MovingEchoes | None = None
    ) -> None:
        """extent: offset from boresight up to which structures change the beam [rad]; direct: echoes whose aspects serve; None:
        bodies have aspects of their own."""
        self._scene, self._paths, self.is_held = scene, IndirectPaths(scene.radar, extent), direct is not None
        all_round = BeamTable(np.ones_like, scene.radar.beamwidth, np.pi, SPAN)
        held = None if direct is None else HeldPassages(scene, visibility, direct.passages)
        self._moving = MovingEchoes(scene, visibility, all_round, seed, paths=[self._paths], passages=held)

    def __len__(self) -> int:
        """How many bodies have such echoes."""
        return len(self._moving)

    def echoes(self, azimuths: AzimuthTimes) -> BeamWeightedEchoes:
        """All of them at azimuths over which no body comes or goes; none where no structure is lit."""
        if not self._paths.are_lit(self._scene, azimuths).any():
            return concatenated([], len(azimuths.time))
        return self._moving.echoes(azimuths)
