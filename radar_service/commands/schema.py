"""The command `schema`: prints the JSON Schema of a scene, or of a sweep."""

import argparse
import json

from radar_service.scene_file.describe import json_schema


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds what the schema is of."""
    parser.add_argument("of", nargs="?", default="scene", choices=["scene", "sweep"], help="of which files (default scene)")


def run(options: argparse.Namespace) -> int:
    """Runs the command; returns the exit status."""
    if options.of == "sweep":
        from radar_service.sweep import spec  # here: it brings the bench, which a scene does not need

        print(json.dumps(spec.json_schema(), indent=2))
    else:
        print(json.dumps(json_schema(), indent=2))
    return 0
