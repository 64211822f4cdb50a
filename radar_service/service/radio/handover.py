"""Where one spoke source hands over to another one that goes on with its rotation and its time: the end of a scan, known in
advance.

It is agreed when the other spoke source is prepared but for its origin. Until then, and until its first spokes are computed, the
running spoke source turns on. One that is late by PATIENCE is not waited for: the next agreement is further ahead.
"""

import threading

from radar_service.radar.parameters import Origin, Radar
from radar_service.service.radio.pacer import Pacer
from radar_service.service.radio.worker_supervisor import WorkerSupervisor

PATIENCE = 0.25  # s of silence at most for a spoke source that is late; a calm feed has 0.2 s between two batches at times
LEAD = 1.0  # s from an agreement to the handover at least: some ten times what first spokes take
MAX_LEAD = 60.0  # s: a spoke source that takes longer for its first spokes does not keep pace


class Overtaken(Exception):
    """A later request for another rate of rotation has come first."""


class SceneChanged(Exception):
    """The scene that a spoke source was to go on with does not run any more."""


class Handover:
    """The agreement of a radar's requests with its transmitter. All methods may be called from any thread.

    at: number of the next spoke source's first spoke; the transmitter sends no spoke from there on before it has taken over,
    or is late. None where nothing is agreed. request: number of the newest request that has agreed.
    """

    def __init__(self) -> None:
        self.at: int | None = None
        self.request = self._claimed = 0
        self._lock = threading.Lock()

    def agree(self, request: int, radar: Radar, sent: int, idle: bool, lead: float) -> Origin:
        """Returns where the spoke source of a request begins: at the end of a scan `lead` [s] ahead; at once where the radar
        is idle.

        radar: that runs; sent: the number of its next spoke. It replaces what an earlier request has agreed. Raises Overtaken.
        """
        with self._lock:
            self._overtake(request)
            next_spoke = max(sent, self._claimed)
            ahead = next_spoke + int(lead / radar.spoke_period)
            self.at = next_spoke if idle else (ahead // radar.azimuths + 1) * radar.azimuths
            return Origin(radar.time_of_spokes(float(self.at)), -(-self.at // radar.azimuths))

    def overtake(self, request: int) -> None:
        """Ends what earlier requests have agreed, and lets them agree no more. Raises Overtaken."""
        with self._lock:
            self._overtake(request)

    def is_agreed(self, request: int) -> bool:
        """Whether the agreement of a request holds."""
        return self.at is not None and self.request == request

    def is_due(self, number: int) -> bool:
        """Whether the spoke of that number is the next spoke source's."""
        return self.at is not None and number >= self.at

    def claim(self, first: int, end: int) -> bool:
        """Returns whether the spokes from `first` to `end` (exclusive) are still the running spoke source's; then they are
        sent now."""
        with self._lock:
            if self.at is not None and first >= self.at:
                return False
            self._claimed = end
            return True

    def cancel(self, request: int | None = None) -> None:
        """Forgets what was agreed, by any request or by this one: no spoke source takes over there."""
        with self._lock:
            if request in (None, self.request):
                self.at = None

    def end(self, number: int) -> None:
        """Forgets what was agreed: a spoke source has taken over. number: of its next spoke."""
        with self._lock:
            self.at, self._claimed = None, number

    def _overtake(self, request: int) -> None:
        if request < self.request:
            raise Overtaken
        self.at, self.request = None, request


def wait_for_spoke_source(handover: Handover, pacer: Pacer, supervisor: WorkerSupervisor) -> None:
    """Waits for the spoke source of a handover that is due, PATIENCE at most but while the radar is idle; then cancels the
    handover."""

    def is_settled() -> bool:
        return supervisor.has_pending or handover.at is None

    pacer.wait_for(lambda: is_settled() or not pacer.idle)
    pacer.wait_for(is_settled, PATIENCE)
    with pacer.group_clock.changed:  # while no spoke source is handed over
        if not supervisor.has_pending:
            handover.cancel()
