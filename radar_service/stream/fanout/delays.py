"""How long a lossless client makes the radar wait, and whether it reads so slowly that others should not wait for it."""

WINDOW = 10.0  # s over which a client is judged
FLOOR = 0.5  # of the spokes of real time: below it, the others see the radar at less than half its speed


class DelayAccount:
    """The delays that one client causes, from `now` [s] on. delivered: number of spokes that it has received so far."""

    def __init__(self, now: float, delivered: int) -> None:
        self._since, self._delivered, self._waited = now, delivered, 0.0

    def add(self, waited: float) -> None:
        """Adds a time [s] that the radar has waited for this client alone."""
        self._waited += waited

    def is_too_slow(self, now: float, delivered: int, spoke_period: float) -> bool:
        """Returns whether, over the last WINDOW, it was waited for most of the time and took less than FLOOR of real time.

        spoke_period: of the radar in real time [s]. Judges once for each WINDOW.
        """
        elapsed = now - self._since
        if elapsed < WINDOW:
            return False
        is_waited_for = self._waited > elapsed / 2.0
        is_below_floor = (delivered - self._delivered) * spoke_period < FLOOR * elapsed
        self._since, self._delivered, self._waited = now, delivered, 0.0
        return is_waited_for and is_below_floor
