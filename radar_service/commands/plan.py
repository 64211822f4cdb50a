"""The command `plan`: prints what is modelled of a scene, at what error and cost."""

import argparse
import json

from radar_service.commands.shared_options import add_exactness, add_radar, add_scene, simulator_options
from radar_service.plan.budget import PACE_HELP, finite_pace
from radar_service.plan.plan import plan_in_time
from radar_service.scene_file import load_scene
from radar_service.simulator import Simulator
from radar_service.terminal import UsageError


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the arguments."""
    add_exactness(parser)
    add_radar(parser)
    parser.add_argument("--json", action="store_true", help="as JSON")
    parser.add_argument("--realtime-factor", type=finite_pace, metavar="F", help=PACE_HELP)
    add_scene(parser)


def run(options: argparse.Namespace) -> int:
    """Runs the command; returns the exit status. Raises SceneError and UsageError."""
    scene = load_scene(options.scene).for_radar(options.radar)
    if options.realtime_factor is None:
        plan = simulator_options(options)(scene).plan
    elif options.fidelity != "auto":
        raise UsageError(f"--realtime-factor: needs --fidelity auto, not {options.fidelity}; remove one of them")
    else:
        plan = plan_in_time(
            scene, options.realtime_factor, lambda fidelity: Simulator(scene, fidelity, options.seed).plan, options.error_db
        )
    print(json.dumps(plan.as_dict(), indent=2) if options.json else plan)
    return 0
