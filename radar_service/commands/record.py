"""The command `record`: computes scans into a recording."""

import argparse
import math
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tqdm import tqdm

from radar_service.commands.shared_options import SCENE_HELP, add_simulation, simulator_options
from radar_service.numerics import Singles
from radar_service.records import SourceRequest
from radar_service.scene_file import load_scene
from radar_service.service.controls import controls_state
from radar_service.service.scene_request import SceneRequest
from radar_service.service.settings import Pace, Settings
from radar_service.service.spokes import Epoch, RadarInfo, SpokeBatch, new_epoch_name
from radar_service.simulator import Simulator
from radar_service.terminal import (
    UsageError,
    add_overwrite,
    add_sources,
    add_whole_number,
    check_sources,
    file_ending,
    prepare,
)
from radar_service.world import CommandLog

if TYPE_CHECKING:
    from radar_service.recording.radar_recording import RadarRecording
    from radar_service.recording.ros2_bag import Ros2Bag


RADAR = "0"
BLOCK = 32  # spokes; a message of the feed holds no more


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the arguments."""
    add_simulation(parser)
    parser.add_argument("scene", metavar="SCENE", help=SCENE_HELP)
    parser.add_argument("-o", "--out", type=partial(file_ending, suffix=".mcap"), required=True, help="file.mcap to write")
    add_overwrite(parser)
    add_whole_number(parser, "--scans", 1, 1, 1_000_000, help="revolutions (default 1)")
    parser.add_argument("--truth", action="store_true", help="record the truth of each beam crossing too")
    parser.add_argument("--ros2", action="store_true", help="write a ROS 2 bag in place of a recording (docs/recordings.md)")
    add_sources(parser, "record", " too")


def run(options: argparse.Namespace) -> int:
    """Runs the command; returns the exit status. Raises SceneError, UsageError, MissingExtra and OSError."""
    from radar_service.recording.radar_recording import RadarRecording  # here: they need an extra, and `--help` does not
    from radar_service.recording.recording_file import PROFILE, RecordingFile
    from radar_service.recording.ros2_bag import PROFILE as ROS2_PROFILE
    from radar_service.recording.ros2_bag import Ros2Bag

    check_sources(options, "labels", "powers")
    if options.ros2 and (options.truth or options.labels or options.powers):
        raise UsageError("--ros2: a bag has neither truth nor labels nor powers; leave these out, or record without --ros2")
    prepare([options.out], options.overwrite)
    simulator = simulator_options(options, options.threads)(load_scene(options.scene))
    request = SourceRequest(options.labels, options.powers)
    try:
        simulator.request_sources(request.labels, request.powers)
    except ValueError as error:
        raise UsageError(f"--{error}") from None
    with RecordingFile(options.out, profile=ROS2_PROFILE if options.ros2 else PROFILE) as file:
        recording = Ros2Bag(file) if options.ros2 else RadarRecording(file, RADAR, options.truth, request)
        record_scans(recording, simulator, options.scene, options.scans, options.truth)
    azimuths = simulator.scene.radar.azimuths
    print(f"{options.out}: {options.scans} x {azimuths} spokes of {simulator.range.size} cells")
    return 0


def record_scans(
    recording: "RadarRecording | Ros2Bag",
    simulator: Simulator,
    scene: str | Path | Mapping[str, Any],
    scans: int,
    with_truth: bool,
) -> None:
    """Records the next scans of a simulator as one epoch. scene: its scene, as SceneRequest names it. Raises OSError."""
    settings = Settings(pace=Pace("run", math.inf))
    commands = CommandLog(simulator.scene.steerable, simulator.commands)
    epoch = Epoch(new_epoch_name(), simulator, None, commands, SceneRequest(scene))
    controls = controls_state(settings, epoch.info.scene, epoch.info.scene)
    recording.open_epoch(RadarInfo(RADAR, f"radar {RADAR}", epoch, 0.0, controls, with_truth))
    number = 0
    before: Singles | None = None
    with tqdm(total=scans * simulator.scene.radar.azimuths, unit="spokes", disable=None) as bar:
        for block in simulator.blocks(scans=scans, size=BLOCK):
            recording.send(SpokeBatch(epoch, number, block, settings.video, before, errors=simulator.errors))
            number, before = number + len(block), block.power[-1]
            bar.update(len(block))
