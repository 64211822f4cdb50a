"""The radars of one group, which have one scene: they share a clock, and another scene replaces all of them together."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

from radar_service.service.radio.command_worker import CommandWorker
from radar_service.service.radio.group_clock import GroupClock
from radar_service.service.radio.prefetch import SpokeWorker
from radar_service.service.radio.transmitter import Transmitter
from radar_service.service.scene_request import SceneRequest, other_radars
from radar_service.service.spokes import new_epoch_name
from radar_service.world.outline import SceneOutline


class RadarGroup:
    """The transmitters of one group. Belongs to the event loop, but for its clock and its command worker."""

    def __init__(self) -> None:
        self.clock = GroupClock()
        self.command_worker = CommandWorker(self.clock)
        self._transmitters: dict[str, Transmitter] = {}  # by the id of the radar
        self._requests = self._last_met = 0  # for another scene, and the number of the last one that was met

    @property
    def size(self) -> int:
        """Number of radars."""
        return len(self._transmitters)

    def join(self, identity: str, transmitter: Transmitter) -> None:
        """Adds the transmitter of a radar."""
        self._transmitters[identity] = transmitter

    def scene_requests(self, scene_request: SceneRequest) -> dict[str, SceneRequest]:
        """Returns the scene request of another scene for each radar. A single radar takes the only one of a scene, whatever
        its id."""
        if len(self._transmitters) == 1:
            return dict.fromkeys(self._transmitters, scene_request)
        return {identity: replace(scene_request, radar=identity) for identity in self._transmitters}

    def changed_requests(self, identity: str, scene_request: SceneRequest) -> dict[str, SceneRequest]:
        """Returns the scene requests of the scene that runs next, with another one for one radar."""
        running = {
            name: transmitter.supervisor.pending_spoke_source.scene_request
            for name, transmitter in self._transmitters.items()
        }
        return running | {identity: scene_request}

    def check(self, scene: SceneOutline) -> None:
        """Raises SceneError for a scene that has other radars than this group."""
        single = len(self._transmitters) == 1 == len(scene.radar_ids)
        if not single and set(scene.radar_ids) != set(self._transmitters):
            raise other_radars(scene.radar_ids, list(self._transmitters))

    def request(self) -> int:
        """Returns the number of a request for another scene."""
        self._requests += 1
        return self._requests

    def has_met_after(self, request: int) -> bool:
        """Whether another scene was prepared that was requested later."""
        return self._last_met > request

    def switch_to(self, request: int, workers: Mapping[str, SpokeWorker], *, stopping: bool) -> Mapping[str, str]:
        """Lets the prepared spoke sources of a request take over; returns the names of their epochs.

        Spoke sources of a request before the last one that was met are ended: as if that request had been met before.
        """
        if stopping or request < self._last_met:
            end(list(workers.values()))
            return {name: new_epoch_name() for name in workers}
        self._last_met = request
        if len(workers) > 1:
            self.clock.restart()
        return {name: self._transmitters[name].switch_to(worker) for name, worker in workers.items()}


def end(workers: Sequence[SpokeWorker]) -> None:
    """Ends prepared spoke sources that nobody needs."""
    for worker in workers:
        worker.stop()
