"""The command `check`: validates a scene, and lists what it contains."""

import argparse
from dataclasses import replace

from radar_service.commands.shared_options import add_radar, add_scene
from radar_service.plan.body_errors import body_remarks
from radar_service.plan.budget import ErrorBudget
from radar_service.plan.settings_search import fidelity_for
from radar_service.scattering import scattering_model, upright_warnings
from radar_service.scene_file import load_scene, overview
from radar_service.scene_file.describe import describe


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the arguments."""
    add_radar(parser)
    parser.add_argument("--all", action="store_true", help="all bodies, notes and remarks, not one screen")
    add_scene(parser)


def run(options: argparse.Namespace) -> int:
    """Runs the command; returns the exit status. Raises SceneError."""
    scene = load_scene(options.scene).for_radar(options.radar)
    upright = upright_warnings([body for body in scene.bodies if scattering_model(body).by_aspect], scene.environment)
    scene = replace(scene, warnings=(*scene.warnings, *upright))
    remarks = body_remarks(scene, fidelity_for(scene, ErrorBudget()))
    print(describe(scene, remarks) if options.all else overview(scene, remarks))
    return 0
