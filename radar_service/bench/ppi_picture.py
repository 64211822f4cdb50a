"""The picture of a scan on which a report draws its tracks."""

import base64
import zlib
from collections.abc import Mapping
from typing import Any

import numpy as np

from radar_service.bench.run import simulator_of
from radar_service.bench.scenario import Scenario
from radar_service.display.picture import picture_from_power
from radar_service.display.ppi import scan_convert
from radar_service.numerics.types import Singles
from radar_service.scans.scan import Scan

SIZE = 800  # pixels


def ppi_of(scan: Scan) -> dict[str, Any]:
    """Returns the PPI of a scan as plain data, north up: `range`, half its width [m], and `pixels`, bytes of brightness row by
    row, deflated and in base 64."""
    reach = float(scan.range[-1] + scan.range_step / 2.0)
    bright = picture_from_power(np.nan_to_num(scan.power))
    image = scan_convert(bright, float(scan.range[0]), scan.range_step, SIZE, reach, interpolation="peak")
    return {"range": reach, "pixels": base64.b64encode(zlib.compress(np.rint(image).astype(np.uint8).tobytes())).decode()}


def ppi_at(scenario: Scenario, seed: int, scan: int) -> dict[str, Any]:
    """Returns the PPI of a scan of a scenario and a seed, which alone is simulated. Raises SceneError."""
    simulator = simulator_of(scenario, seed)
    simulator.skip_to(scan)
    return ppi_of(simulator.scan())


def image_of(ppi: Mapping[str, Any]) -> Singles:
    """Returns the brightness (SIZE, SIZE), 0 to 1, of what `ppi_of` returned; row 0 is in the north."""
    pixels = np.frombuffer(zlib.decompress(base64.b64decode(ppi["pixels"])), dtype=np.uint8)
    return pixels.reshape(SIZE, SIZE).astype(np.float32) / np.float32(255.0)
