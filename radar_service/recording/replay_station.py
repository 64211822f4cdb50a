"""A recording that a service sends as it sends radars: what needs an engine is refused in a sentence."""

import contextlib
import math
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from typing_extensions import override

from radar_service.errors.reporter import ErrorReporter
from radar_service.recording.error import RecordingError
from radar_service.recording.radar_recording import file_hash
from radar_service.recording.recording import NO_TRUTH, Recording
from radar_service.records import ShipStates, SpokeBlock
from radar_service.scene_file import changed_errors, packaged_folder
from radar_service.service.controls import CONTROLS, changed_settings
from radar_service.service.fanout.client_queue import ClientQueue
from radar_service.service.fanout.hub import FeedRefused
from radar_service.service.logs import log_event
from radar_service.service.radio.scene_process import SpokeWorker
from radar_service.service.radio.station import Station
from radar_service.service.scene_request import SceneRequest, SceneSpokeSource
from radar_service.service.settings import Settings
from radar_service.spoke_source import SpokeSourceFault
from radar_service.world import MAX_SEGMENTS, NOT_STEERABLE, CommandError, Scene, SceneError, Steering, outline_of

ENDED = "the recording has ended"
PLAYS = "this radar replays a recording: its scene and rate of rotation stay; serve a scene to change them"


class ReplaySpokeSource(Recording):
    """A recording whose end is told to its clients. has_ended: whether all of it was read.

    is_over: whether its radar sends no more; together: the recordings of a command, which ends with the last one.
    sensors: with the laws of own ship's sensors, None before `make_scene_again`.
    no_ships: why there are no `ship_states`, "" where they are not needed: those of `TellsShips`.
    """

    has_ended = is_over = False
    together: Sequence["ReplaySpokeSource"] = ()
    sensors: ErrorReporter | None = None
    ship_states: Callable[[Sequence[float], Sequence[str | None]], list[ShipStates]]
    no_ships = ""

    def make_scene_again(self, folder: Path) -> None:
        """Builds the scene with its commands, for `ship_states`, or says in `no_ships` why not. folder: of its files."""
        try:
            for ship, count in Counter(command.body or "own ship" for command in self.commands).items():
                if count >= MAX_SEGMENTS:  # its motion forgets the first ones
                    raise RecordingError(
                        f"commands: {ship} has {count}; at most {MAX_SEGMENTS - 1} are replayed; record fewer"
                    )
            steering = Steering(scene := self._scene_again(folder))
            steering.replay(self.commands)
        except (RecordingError, SceneError, CommandError) as error:
            self.no_ships = f"the recorded scene cannot be built again: {error}"
            return
        steering.go_to(math.inf)
        self.ship_states, known, outline = steering.past.ship_states, self.info, outline_of(scene)
        names = scene.radar_id, 0, scene.platform.body, scene.environment.stream
        self.sensors = ErrorReporter(scene.radar, self.seed, scene.errors, *names)
        for change in self.own("errors"):
            self.sensors.set(changed_errors(None, change["errors"]), change["spoke"])
        steerable = replace(NOT_STEERABLE, own_ship=scene.platform.body)
        outline = replace(known.scene, ais=outline.ais, gnss_offset=outline.gnss_offset, steerable=steerable)
        self.info = replace(known, scene=outline)

    def _scene_again(self, folder: Path) -> Scene:
        """The scene as this radar had it. Raises RecordingError, SceneError."""
        from radar_service.scene_file import load_scene  # here: scipy would slow the start of every replay

        document, files = self.record["document"], self.record["files"]
        if document is None:
            raise RecordingError("document: the recording lacks the scene, whose file had changed; record again")
        folders = folder, packaged_folder("scenes")
        missing = [[name for name, sum in files.items() if not sum or file_hash(folder, name) != sum] for folder in folders]
        if all(missing):
            raise RecordingError(f"files: {missing[0][0]} is not as recorded; copy the scene's files beside the recording")
        scene = load_scene(document, folder=folders[missing.index([])])
        return scene.for_radar(self.record["id"] if self.record["id"] in scene.radar_ids else None)

    @property
    def first(self) -> int:
        """Number of the first spoke, from t = 0; 0 where it cannot be read."""
        with contextlib.suppress(RecordingError):
            return next((block.first for block in super().blocks()), 0)
        return 0

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
        self._recording, worker = spoke_source, SpokeWorker(spoke_source, first=spoke_source.first)
        super().__init__(identity, spoke_source, *arguments, settings=settings, restarts=0, worker=worker, **options)
        self.sensor_laws = spoke_source.sensors.laws_at if spoke_source.sensors else self.sensor_laws
        self.lacks = {"truth": NO_TRUTH} | ({"ships": spoke_source.no_ships} if spoke_source.no_ships else {})

    @override
    def join(self, client: ClientQueue, since: tuple[str, int] | None = None) -> None:
        """Raises FeedRefused also for a client that requests the truth of every instant."""
        if client.truth:
            raise FeedRefused(f"truth: {NO_TRUTH}")
        super().join(client, since)

    def _report_failure(self, reason: str) -> None:
        log_event("radar stopped", radar=self.identity, reason=reason)
        self._recording.is_over = True
        if all(each.is_over for each in self._recording.together):
            self.failed()


def refuse(*_: object) -> SceneSpokeSource:
    """Raises SpokeSourceFault in place of another scene: a `MakeSpokeSource`."""
    raise SpokeSourceFault(PLAYS)
