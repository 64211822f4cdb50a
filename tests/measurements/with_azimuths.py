"""A scene with another number of azimuths; the process of its world finds this by its name."""

from dataclasses import dataclass, replace

from radar_service import Scene, Simulator


@dataclass(frozen=True)
class WithAzimuths:
    """Makes the simulator of a scene with so many azimuths, in the process of its world."""

    azimuths: int

    def __call__(self, of: Scene) -> Simulator:
        return Simulator(replace(of, radar=replace(of.radar, azimuths=self.azimuths, rotation_period=2.5)), threads=1)
