"""A simulated marine radar: triangle meshes in, the live feed of a rotating X-band radar out.

>>> import radar_service as rs
>>> sim = rs.Simulator(rs.load_scene("worked-example"), seed=0)
>>> scan = sim.scan()
"""

from importlib.metadata import version

from radar_service.fidelity import Fidelity
from radar_service.records import BodyTruth, Spoke, SpokeBlock, Truth
from radar_service.scan import Scan, load_scan
from radar_service.scene.error import SceneError
from radar_service.scene.load import load_scene
from radar_service.scene.world import Scene
from radar_service.simulator import Simulator

__all__ = [
    "BodyTruth", "Fidelity", "Scan", "Scene", "SceneError", "Simulator", "Spoke", "SpokeBlock", "Truth", "load_scan",
    "load_scene",
]  # fmt: skip

__version__ = version("radar-service")
