"""A simulated marine radar: triangle meshes in, the live feed of a rotating X-band radar out.

>>> import radar_service as rs
>>> sim = rs.Simulator(rs.load_scene("worked-example"), seed=0)
>>> scan = sim.scan()

Each name is imported when it is first used, so that the service, which has its simulators in other processes, starts soon.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from radar_service.public_names import lazily

if TYPE_CHECKING:
    from radar_service.records.fidelity import Fidelity
    from radar_service.records.spokes import Spoke, SpokeBlock
    from radar_service.records.truth import BodyTruth, Crossing, Snapshot, Truth
    from radar_service.scans.scan import Scan, load_scan
    from radar_service.scene_file.load import load_scene
    from radar_service.simulator import Simulator
    from radar_service.world.error import SceneError
    from radar_service.world.scene import Scene

    __version__: str

__all__ = [
    "BodyTruth", "Crossing", "Fidelity", "Scan", "Scene", "SceneError", "Simulator", "Snapshot", "Spoke", "SpokeBlock", "Truth",
    "load_scan", "load_scene",
]  # fmt: skip

_public, _names = lazily(__name__)


def __getattr__(name: str) -> Any:
    """Returns a public name, imported now."""
    return import_module("importlib.metadata").version("radar-service") if name == "__version__" else _public(name)


def __dir__() -> list[str]:
    """Returns the public names, imported or not."""
    return [*_names(), "__version__"]
