"""Where one engine hands over to another one that goes on with its rotation and its time: the end of a scan, known in advance."""

import math
import threading

from radar_service.radar.parameters import Origin, Radar


class Handover:
    """The agreement of a radar's requests with its transmitter. All methods may be called from any thread.

    agree: the transmitter sends no spoke from number `at` on before each request has settled. at: None where nothing is agreed.
    """

    def __init__(self) -> None:
        self.at: int | None = None
        self._requests = self._claimed = 0
        self._lock = threading.Lock()

    @property
    def is_open(self) -> bool:
        """Whether a request has agreed and not settled."""
        return self._requests > 0

    def agree(self, radar: Radar, sent: int, idle: bool, lead: float) -> Origin:
        """Returns where the next engine begins: at the end of a scan `lead` [s] ahead, or at once where the radar is idle.

        radar: that runs; sent: the number of its next spoke. All requests before the handover get the same origin.
        """
        with self._lock:
            if self.at is None:
                next_spoke, azimuths = max(sent, self._claimed), radar.azimuths
                scans = next_spoke // azimuths + 1 + math.ceil(lead / radar.rotation_period)
                self.at = next_spoke if idle else scans * azimuths
            self._requests += 1
            return Origin(radar.time_of_spokes(float(self.at)), -(-self.at // radar.azimuths))

    def settle(self) -> None:
        """Ends a request: its engine is ready, or will never be."""
        with self._lock:
            self._requests -= 1

    def is_due(self, number: int) -> bool:
        """Whether the spoke of that number is the next engine's."""
        return self.at is not None and number >= self.at

    def claim(self, first: int, end: int) -> bool:
        """Returns whether the spokes from `first` to `end` (exclusive) are still the running engine's; then they are sent now."""
        with self._lock:
            if self.at is not None and first >= self.at:
                return False
            self._claimed = end
            return True

    def end(self, number: int) -> None:
        """Forgets what was agreed: an engine has taken over, or none will. number: of its next spoke."""
        with self._lock:
            self.at, self._claimed = None, number
