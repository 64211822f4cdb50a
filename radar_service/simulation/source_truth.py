"""The power of each source alone, and the radiometric truth of crossings, also of a run that was steered."""

from dataclasses import replace
from threading import Lock

from radar_service.engine.preparation import Prepared
from radar_service.engine.radiometric import RadiometricTruth
from radar_service.engine.source_numbers import source_numbers
from radar_service.engine.source_powers import SourcePowers
from radar_service.fidelity import Fidelity
from radar_service.plan.cost_model import SetUp
from radar_service.records import Crossing
from radar_service.scene.steering import Steering
from radar_service.simulation.engine_set_up import pipeline_set_up
from radar_service.types import Singles


class SourceTruth:
    """Computes azimuths again, source by source. Safe to call from several threads.

    A steered run is computed from its past: a second preparation, whose bodies move as they were commanded at each time.
    """

    def __init__(self, steering: Steering, fidelity: Fidelity, seed: int, set_up: SetUp | None) -> None:
        """set_up: that of the run; None for the fidelity `documented`, which has no sources."""
        self._steering, self._fidelity, self._seed, self._set_up = steering, fidelity, seed, set_up
        self._past: Prepared | None = None
        self._radiometric: RadiometricTruth | None = None
        self._followed = 0  # commands that both know
        self._lock = Lock()

    def powers(self, scan: int) -> dict[int, Singles]:
        """Returns what Simulator.source_powers returns. Raises ValueError for the fidelity `documented`."""
        with self._lock:
            return SourcePowers(self._prepared("source_powers"), source_numbers(self._steering.scene)).scan(scan)

    def measured(self, crossings: tuple[Crossing, ...]) -> tuple[Crossing, ...]:
        """Returns crossings with their radiometric part. Raises ValueError for the fidelity `documented`."""
        index = {body.name: k for k, body in enumerate(self._steering.scene.bodies)}
        with self._lock:
            prepared = self._prepared("radiometric")
            if self._radiometric is None:
                self._radiometric = RadiometricTruth(prepared)
            return tuple(replace(each, **vars(self._radiometric.at(index[each.body], each.spoke))) for each in crossings)

    def _prepared(self, name: str) -> Prepared:
        """What to compute from. name: of the argument or method that needs it."""
        if self._set_up is None:
            raise ValueError(f"{name}: the fidelity 'documented' has none; choose another fidelity")
        if self._steering.scene.radar.near_pulses:
            raise ValueError(f"{name}: a radar with several pulses has none; give it one pulse")
        if self._steering.past is self._steering.scene:
            return self._set_up.prepared
        if self._past is None:
            self._past = pipeline_set_up(self._steering.past, self._fidelity, self._seed).prepared
        if self._followed != self._steering.count:
            self._past.motions_changed(own_ship=True)
            self._radiometric, self._followed = None, self._steering.count
        return self._past
