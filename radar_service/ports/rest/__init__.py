"""REST: what is under /api, and the metrics."""

import argparse
from collections.abc import Mapping
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from radar_service.ports.port import Port

replays = True


def add_arguments(groups: "Mapping[str, argparse._ActionsContainer]") -> None:
    """Adds nothing: the options of the server are in `shared_options`."""


def opened(options: argparse.Namespace) -> "Port":
    """Returns the port of REST."""
    from radar_service.ports.rest.rest_port import RestPort

    return RestPort(options.scene_folder, options.sandbox_all)
