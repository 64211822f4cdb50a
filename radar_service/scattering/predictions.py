"""Errors that scattering models predict of themselves: what a model is told, and what it answers."""

from dataclasses import dataclass
from typing import NamedTuple

from radar_service.numerics import Floats
from radar_service.radar import Radar
from radar_service.records import Fidelity
from radar_service.world import Environment, Scene

NEAREST = 16.0  # m: parts of a body are taken as no nearer: no marine antenna observes nearer bodies


@dataclass(frozen=True)
class Conditions:
    """What a prediction depends on, besides the body and its run.

    radar, environment, fidelity: of the simulation.
    antenna: (3,) at time 0 on the map [m].
    scatterers: how many fixed scatterers the body has; None before they are drawn.
    """

    radar: Radar
    environment: Environment
    fidelity: Fidelity
    antenna: Floats
    scatterers: int | None = None

    @classmethod
    def of_scene(cls, scene: Scene, fidelity: Fidelity, scatterers: int | None = None) -> "Conditions":
        """The conditions of a body of a scene with so many scatterers."""
        return cls(scene.radar, scene.environment, fidelity, scene.antenna(0.0)[0], scatterers)


class BodyRun(NamedTuple):
    """What a body does over a run, seen from the antenna.

    nearest: least ground distance of its nearest part [m], at least 0.
    approach: least ground distance of its middle [m].
    time: when its middle is nearest [s].
    turn: highest rate at which its aspect changes [rad/s].
    radial: highest rate of range [m/s].
    sea_turn: highest rate of the angle between the direct ray and the one by the sea [rad/s].
    start: ground distance of its middle at the start [m].
    """

    nearest: float
    approach: float
    time: float
    turn: float
    radial: float
    sea_turn: float
    start: float


class RunError(NamedTuple):
    """What a run adds to the error of a body's mean power [dB], and sentences about it."""

    power_db: float = 0.0
    remarks: tuple[str, ...] = ()
