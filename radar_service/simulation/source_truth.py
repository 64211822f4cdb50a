"""The power of each source alone, and the radiometric truth of crossings, also of a run that was steered."""

from dataclasses import replace
from threading import Lock

from radar_service.engine.preparation import Prepared
from radar_service.numerics.types import Singles
from radar_service.records.fidelity import Fidelity
from radar_service.records.truth import Crossing
from radar_service.simulation.engine_set_up import pipeline_set_up, prepared_pulses
from radar_service.sources.numbers import source_numbers
from radar_service.sources.power_window import pulse_powers, scan_powers
from radar_service.sources.radiometric import RadiometricTruth
from radar_service.world.steering import Steering


class SourceTruth:
    """Computes azimuths again, source by source. Safe to call from several threads.

    A steered run is computed from its past: a second preparation, whose bodies move as they were commanded at each time.
    """

    def __init__(
        self, steering: Steering, fidelity: Fidelity, requested: str | Fidelity, seed: int, pulses: tuple[Prepared, ...]
    ) -> None:
        """fidelity: of the requested one; pulses: those of the run; none for the fidelity `documented`, which has no sources."""
        self._steering, self._fidelity, self._requested, self._seed = steering, fidelity, requested, seed
        self._pulses = pulses
        self._past: tuple[Prepared, ...] = ()
        self._radiometric: RadiometricTruth | None = None
        self._followed = 0  # commands that both know
        self._lock = Lock()

    def powers(self, scan: int) -> dict[int, Singles]:
        """Returns what Simulator.source_powers returns. Raises ValueError for the fidelity `documented`."""
        with self._lock:
            pulses = self._prepared("source_powers")
            return scan_powers(pulse_powers(pulses, source_numbers(self._steering.scene)), scan)

    def measured(self, crossings: tuple[Crossing, ...]) -> tuple[Crossing, ...]:
        """Returns crossings with their radiometric part. Raises ValueError for the fidelity `documented`."""
        index = {body.name: k for k, body in enumerate(self._steering.scene.bodies)}
        with self._lock:
            pulses = self._prepared("radiometric")
            if self._radiometric is None:
                self._radiometric = RadiometricTruth(pulses)
            return tuple(
                replace(crossing, **vars(self._radiometric.at(index[crossing.body], crossing.spoke)))
                for crossing in crossings
            )

    def _prepared(self, name: str) -> tuple[Prepared, ...]:
        """What to compute from, for each pulse. name: of the argument or method that needs it."""
        if not self._pulses:
            raise ValueError(f"{name}: the fidelity 'documented' has none; choose another fidelity")
        past = self._steering.past
        if past is self._steering.scene:
            return self._pulses
        if not self._past:
            last = pipeline_set_up(past, self._fidelity, self._seed).prepared
            self._past = prepared_pulses(past, last, self._requested, self._seed)
        if self._followed != self._steering.count:
            self._radiometric, self._followed = None, self._steering.count
        return self._past
