"""The command `record`: computes scans of a scene into a recording."""

import argparse
import math
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from tqdm import tqdm

from radar_service.numerics.types import Singles
from radar_service.recording.error import RecordingError
from radar_service.recording.radar_recording import RadarRecording
from radar_service.recording.recording_file import RecordingFile
from radar_service.records.cell_sources import SourceRequest
from radar_service.scene_file.load import load_scene
from radar_service.service.controls import controls_state
from radar_service.service.settings import Pace, Settings
from radar_service.service.source import SceneOrder
from radar_service.service.spokes import Epoch, RadarInfo, SpokeBatch, new_epoch_name
from radar_service.simulator import Simulator
from radar_service.terminal.output_files import prepare
from radar_service.world.commands import CommandLog
from radar_service.world.scene import Scene

RADAR = "0"
BLOCK = 32  # spokes; a message of the feed holds no more


def record(options: argparse.Namespace, make: Callable[[Scene], Simulator]) -> int:
    """Records scans, with a progress bar on a terminal; returns the exit status.

    Raises SceneError, RecordingError and OSError.
    """
    prepare([options.out], options.overwrite)
    simulator, request = make(load_scene(options.scene)), SourceRequest(options.labels, options.powers)
    try:
        simulator.request_sources(request.labels, request.powers)
    except ValueError as error:
        raise RecordingError(f"--{error}") from None
    with RecordingFile(options.out) as file:
        recording = RadarRecording(file, RADAR, options.truth, request)
        record_scans(recording, simulator, options.scene, options.scans, options.truth)
    azimuths = simulator.scene.radar.azimuths
    print(f"{options.out}: {options.scans} x {azimuths} spokes of {simulator.range.size} cells")
    return 0


def record_scans(
    recording: RadarRecording, simulator: Simulator, scene: str | Path | Mapping[str, Any], scans: int, with_truth: bool
) -> None:
    """Records the next scans of a simulator as one epoch. scene: its scene, as SceneOrder names it. Raises OSError."""
    settings = Settings(pace=Pace("run", math.inf))
    commands = CommandLog(simulator.scene.steerable, simulator.commands)
    epoch = Epoch(new_epoch_name(), simulator, None, commands, SceneOrder(scene))
    controls = controls_state(settings, epoch.info.scene, epoch.info.scene)
    recording.open_epoch(RadarInfo(RADAR, f"radar {RADAR}", epoch, 0.0, controls, with_truth))
    number = 0
    before: Singles | None = None
    with tqdm(total=scans * simulator.scene.radar.azimuths, unit="spokes", disable=None) as bar:
        for block in simulator.blocks(scans=scans, size=BLOCK):
            recording.send(SpokeBatch(epoch, number, block, settings.video, before))
            number, before = number + len(block), block.power[-1]
            bar.update(len(block))
