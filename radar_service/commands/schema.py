"""The command `schema`: prints the JSON Schema of a scene."""

import argparse
import json

from radar_service.scene_file.describe import json_schema


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds nothing."""


def run(_: argparse.Namespace) -> int:
    """Runs the command; returns the exit status."""
    print(json.dumps(json_schema(), indent=2))
    return 0
