"""The options of the command line that make a simulator, as one object that can be sent to another process."""

import argparse
from dataclasses import dataclass
from typing import TYPE_CHECKING

from radar_service.plan.budget import ErrorBudget

if TYPE_CHECKING:
    from radar_service.simulator import Simulator
    from radar_service.world.scene import Scene


@dataclass(frozen=True)
class SimulatorOptions:
    """fidelity: a preset's name or `auto`; error_db: budget that `auto` plans for, None for its own; others as Simulator."""

    fidelity: str = "auto"
    error_db: ErrorBudget | None = None
    seed: int = 0
    threads: int = 1
    labels: bool = False

    def __call__(self, scene: "Scene") -> "Simulator":
        """Returns the simulator of a scene."""
        from radar_service.plan.settings_search import fidelity_for  # here: the service makes options, not simulators
        from radar_service.simulator import Simulator

        fidelity = self.fidelity if self.error_db is None else fidelity_for(scene, self.error_db)
        return Simulator(scene, fidelity, self.seed, self.threads, labels=self.labels)


def simulator_options(options: argparse.Namespace, threads: int = 1, labels: bool = False) -> SimulatorOptions:
    """Returns what the command line says about simulators."""
    return SimulatorOptions(options.fidelity, options.error_db, options.seed, threads, labels)
