"""Raster files: GeoTIFF coordinates, missing data, declared sizes."""

import io
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import TiffImagePlugin

from radar_service.scene_file.readers.raster import MAX_SIDE, raster_from_bytes
from radar_service.world.error import SceneError
from radar_service.world.geo import map_from_geographic
from tests.scene_file.readers.height_maps import load, picture, world_vertices


def geotiff(samples: NDArray[Any], keys: list[int], **extra: Any) -> bytes:
    tags = TiffImagePlugin.ImageFileDirectory_v2()
    tags.tagtype.update({33550: 12, 33922: 12, 34735: 3, 42113: 2})
    tags[33550] = (0.01, 0.02, 0.0)
    tags[33922] = (0.0, 0.0, 0.0, 1.0, 51.0, 0.0)
    tags[34735] = tuple(keys)
    for tag, value in extra.items():
        tags[int(tag.removeprefix("tag"))] = value
    return picture(samples, "TIFF", tiffinfo=tags)


GEOGRAPHIC = [1, 1, 0, 3, 1024, 0, 1, 2, 1025, 0, 1, 1, 2048, 0, 1, 4326]


@pytest.mark.parametrize("raster_type, shift", [(1, 0.5), (2, 0.0)])
def test_a_geotiff_has_its_own_position(tmp_path: Path, raster_type: int, shift: float) -> None:
    """PixelIsArea ties the corner of a pixel, PixelIsPoint its centre (OGC 19-008r4, section 7.1.1)."""
    keys = [*GEOGRAPHIC]
    keys[11] = raster_type
    content = geotiff(np.array([[1, 2, 3], [4, 5, 6]], dtype=np.float32), keys)
    (body,) = load(tmp_path, "h.tif", content, range_max_m=200_000).bodies
    result = world_vertices(body)
    first = result[np.isclose(result[:, 2], 1.0)][0]
    expected = map_from_geographic(51.0 - shift * 0.02, 1.0 + shift * 0.01, (50.9, 1.4))
    np.testing.assert_allclose(first[:2], expected, atol=1e-6)
    last = result[np.isclose(result[:, 2], 6.0)][0]
    np.testing.assert_allclose(
        last[:2], map_from_geographic(51.0 - (1 + shift) * 0.02, 1.0 + (2 + shift) * 0.01, (50.9, 1.4)), atol=1e-6
    )


@pytest.mark.parametrize(
    ("kind", "mark"),
    [(np.float32, "-32768"), (np.float32, "nan"), (np.float32, "1e38"), (np.uint16, "65535"), (np.int16, "-9999")],
)
def test_geotiff_without_data_is_sea(tmp_path: Path, kind: type, mark: str) -> None:
    """Of any type of samples, and 1 m below the sea however high the map stands: land beside it falls to there."""
    samples = np.full((4, 4), 7, dtype=kind)
    samples[0, 0] = samples[2, 2] = kind(mark) if kind is np.float32 else int(mark)
    content = geotiff(samples, GEOGRAPHIC, tag42113=mark)
    scene = load(tmp_path, "h.tif", content, range_max_m=200_000, position_m=[0, 0, 30])
    assert "2 samples without data become sea" in scene.warnings[0]
    assert np.unique(world_vertices(scene.bodies[0])[:, 2]).tolist() == [-1.0, 37.0]


def test_projected_geotiff_needs_placing(tmp_path: Path) -> None:
    content = geotiff(np.ones((3, 3), dtype=np.float32), [1, 1, 0, 1, 1024, 0, 1, 1])
    with pytest.raises(SceneError, match=r"body\[0\].extent_m: missing; the file has no coordinates"):
        load(tmp_path, "h.tif", content)


def test_claimed_sizes_are_checked_before_memory_is_taken() -> None:
    claimed = io.BytesIO()
    np.lib.format.write_array_header_1_0(claimed, {"descr": "<f8", "fortran_order": False, "shape": (10**9, 10**9)})
    with pytest.raises(SceneError, match="1000000000 x 1000000000 samples; two sides"):
        raster_from_bytes(claimed.getvalue(), "h.npy", "m")
    wide = picture(np.zeros((2, MAX_SIDE + 1), dtype=np.uint8))
    with pytest.raises(SceneError, match="2 x 4098 samples"):
        raster_from_bytes(wide, "h.png", "m")
    bomb = wide[:16] + (200_000).to_bytes(4, "big") * 2 + wide[24:]
    with pytest.raises(SceneError, match="cannot be read|samples"):
        raster_from_bytes(bomb, "h.png", "m")
