"""The radars of one group, which have one scene: they share a clock, and another scene brings radars of its own."""

from collections.abc import Callable, Mapping

from radar_service.radar import FIRST_ID
from radar_service.service.radio.command_worker import CommandWorker
from radar_service.service.radio.pacer import GroupClock
from radar_service.service.radio.scene_process import SpokeWorker, end
from radar_service.service.radio.transmitter import Transmitter
from radar_service.service.spokes import new_epoch_name
from radar_service.world import SceneOutline


class RadarGroup:
    """The transmitters of one group. Belongs to the event loop, but for its clock and its command worker.

    number: of its scene on the command line, from 0.
    """

    def __init__(self, number: int = 0) -> None:
        self.number = number
        self.clock = GroupClock()
        self.command_worker = CommandWorker(self.clock)
        self._transmitters: dict[str, Transmitter] = {}  # by the id of the radar
        self._requests = self._last_met = 0  # for another scene, and the number of the last one that was met

    @property
    def identities(self) -> list[str]:
        """The ids of its radars, in the order of the scene."""
        return list(self._transmitters)

    def join(self, identity: str, transmitter: Transmitter) -> None:
        """Adds the transmitter of a radar."""
        self._transmitters[identity] = transmitter

    def identities_in(self, scene: SceneOutline) -> list[str]:
        """Returns the ids under which the radars of a scene are on the air here, in its order.

        A single radar takes the only one of a scene, whatever its id. One without an id has the number of the group.
        """
        if len(self._transmitters) == len(scene.radar_ids) == 1:
            return self.identities
        return [str(self.number)] if scene.radar_ids == (FIRST_ID,) else list(scene.radar_ids)

    def request(self) -> int:
        """Returns the number of a request for another scene."""
        self._requests += 1
        return self._requests

    def has_met_after(self, request: int) -> bool:
        """Whether another scene was prepared that was requested later."""
        return self._last_met > request

    def switch_to(
        self, request: int, workers: Mapping[str, SpokeWorker], begin: Callable[[str, SpokeWorker], Transmitter],
        *, stopping: bool,
    ) -> Mapping[str, str]:  # fmt: skip
        """Lets the prepared spoke sources of a request take over; returns the names of their epochs.

        Radars that are not among them leave the group, and `begin` returns the transmitter of each one that is new.
        Spoke sources of a request before the last one that was met are ended: as if that request had been met before.
        """
        if stopping or request < self._last_met:
            end(workers)
            return {name: new_epoch_name() for name in workers}
        self._last_met = request
        before, self._transmitters = self._transmitters, {}
        if len(workers) > 1 or len(before) > 1:
            self.clock.restart()
        for name in before.keys() - workers.keys():
            before[name].leave()
        self._transmitters = {name: before.get(name) or begin(name, worker) for name, worker in workers.items()}
        return {
            name: self._transmitters[name].switch_to(worker) if name in before else self._transmitters[name].epoch.name
            for name, worker in workers.items()
        }
