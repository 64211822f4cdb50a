"""How long lossless clients make the radar wait, and which of them read so slowly that others should not wait for them."""

import asyncio
from collections.abc import Callable, Set

from radar_service.service.fanout.client_queue import ClientQueue

PATIENCE = 10.0  # s that a lossless client may delay the simulation
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


class Delays:
    """The waits of a radar for its lossless clients, on its event loop."""

    def __init__(self, clock: Callable[[], float], patience: float = PATIENCE) -> None:
        self._clock, self._patience = clock, patience
        self._accounts: dict[ClientQueue, DelayAccount] = {}

    def forget(self, client: ClientQueue) -> None:
        """Forgets a client that has left."""
        self._accounts.pop(client, None)

    async def wait(self, clients: Set[ClientQueue], spoke_period: float) -> dict[ClientQueue, str]:
        """Waits until the lossless ones of all clients have room; returns those to disconnect, each with the reason.

        These are clients that read nothing, and those that others wait for too long; alone, a client may take its time.
        spoke_period: of the radar in real time [s].
        """
        full = [client for client in clients if client.mode == "lossless" and client.full]
        if not full:
            return {}
        waits = {asyncio.ensure_future(self._wait_for(client)): client for client in full}
        _, late = await asyncio.wait(waits, timeout=self._patience)
        for task in late:
            task.cancel()
        reason = f"nothing was read for {self._patience:g} s; read faster, or resume with since"
        ends = {waits[task]: reason for task in late}
        for client in full:
            if client not in ends and len(clients - ends.keys()) > 1 and self._is_too_slow(client, spoke_period):
                reason = f"for {WINDOW:g} s you have read less than {100 * FLOOR:g} % of real time, and others wait for you"
                ends[client] = f"{reason}; request mode=live, or a smaller view"
        return ends

    async def _wait_for(self, client: ClientQueue) -> None:
        if client.closed:  # it has left since
            return
        began = self._clock()
        account = self._accounts.setdefault(client, DelayAccount(began, client.delivered))
        await client.room()
        account.add(self._clock() - began)

    def _is_too_slow(self, client: ClientQueue, spoke_period: float) -> bool:
        account = self._accounts.get(client)  # none of a client that has left meanwhile
        return account is not None and account.is_too_slow(self._clock(), client.delivered, spoke_period)
