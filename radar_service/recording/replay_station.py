"""A recording that a service sends as it sends radars: what needs an engine is refused in a sentence."""

from collections.abc import Iterator
from typing import Any

from typing_extensions import override

from radar_service.processes.call import Progress
from radar_service.recording.error import RecordingError
from radar_service.recording.recording import NO_TRUTH, Recording
from radar_service.records.spokes import SpokeBlock
from radar_service.service.controls import CONTROLS, changed_settings
from radar_service.service.fanout.client_queue import ClientQueue
from radar_service.service.fanout.hub import FeedRefused
from radar_service.service.logs import log_event
from radar_service.service.radio.prefetch import SpokeSourceFault
from radar_service.service.radio.station import Station
from radar_service.service.scene_request import SceneRequest, SceneSpokeSource
from radar_service.service.settings import Settings

ENDED = "the recording has ended"
PLAYS = "this radar replays a recording: its scene and rate of rotation stay; serve a scene to change them"


class ReplaySpokeSource(Recording):
    """A recording whose end is told to its clients. has_ended: whether all of it was read."""

    has_ended = False

    @property
    def scene_request(self) -> SceneRequest:
        """The scene as it was recorded."""
        return SceneRequest(self.record["document"] or {})

    def blocks(self, *, size: int = 16) -> Iterator[SpokeBlock]:
        """Yields the recorded blocks. Raises SpokeSourceFault at the end, and where the file is damaged."""
        try:
            yield from super().blocks(size=size)
        except RecordingError as error:
            raise SpokeSourceFault(str(error)) from None
        self.has_ended = True
        raise SpokeSourceFault(ENDED)


def recorded_settings(recording: Recording, settings: Settings) -> Settings:
    """Returns settings with the display controls and the range of a recording."""
    names = {"range_m", *(control.name for control in CONTROLS if control.acts_on == "display")}
    recorded = {name: value for name, value in recording.record["controls"].items() if name in names}
    return changed_settings(settings, recording.info.scene, recorded)


class ReplayStation(Station):
    """A radar that sends a recording once."""

    def __init__(
        self, identity: str, spoke_source: ReplaySpokeSource, *arguments: Any, settings: Settings, **options: Any
    ) -> None:
        """settings: display controls and range are those of the recording instead."""
        settings = recorded_settings(spoke_source, settings)
        super().__init__(identity, spoke_source, *arguments, settings=settings, restarts=0, **options)

    @override
    def join(self, client: ClientQueue, since: tuple[str, int] | None = None) -> None:
        """Raises FeedRefused also for a client that requests the truth of every instant."""
        if client.truth:
            raise FeedRefused(f"truth: {NO_TRUTH}")
        super().join(client, since)

    def _report_failure(self, reason: str) -> None:
        log_event("radar stopped", radar=self.identity, reason=reason)
        self.failed()


def refuse(scene_request: SceneRequest, progress: Progress) -> SceneSpokeSource:
    """Raises SpokeSourceFault in place of another scene: a `MakeSpokeSource`."""
    raise SpokeSourceFault(PLAYS)
