"""The command `schema`: prints the JSON Schema of a scene, or of a sweep."""

import argparse
import json

from radar_service import plug_ins
from radar_service.scene_file import json_schema


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds what the schema is of."""
    parser.add_argument("of", nargs="?", default="scene", choices=["scene", "sweep"], help="of which files (default scene)")


def run(options: argparse.Namespace) -> int:
    """Runs the command; returns the exit status. Raises PlugInError without sweeps."""
    schema = json_schema if options.of == "scene" else plug_ins.load("commands", options.of).json_schema
    print(json.dumps(schema(), indent=2))
    return 0
