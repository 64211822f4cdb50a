"""Raster files: GeoTIFF coordinates, missing data, declared sizes."""

import io
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import TiffImagePlugin

from radar_service.scene_file.load import load_scene
from radar_service.scene_file.readers.file_format import Format
from radar_service.scene_file.readers.raster import MAX_SIDE, Raster, raster_from_bytes
from radar_service.world.error import SceneError
from radar_service.world.geo import map_from_geographic
from tests.plug_ins import join
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


def test_a_reader_of_another_package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def parse(content: bytes, location: str) -> Raster:
        return Raster(np.array([row.split() for row in content.decode().splitlines()[1:]], dtype=np.float64), grey=False)

    join(monkeypatch, "rasters", "grid", Format("grid", lambda content: content.startswith(b"grid"), parse, lambda: ()))
    (body,) = load(tmp_path, "h.grid", b"grid\n1 2\n3 4\n", extent_m=[100, 100]).bodies
    assert sorted({*world_vertices(body)[:, 2].tolist()}) == [1.0, 2.0, 3.0, 4.0]
    with pytest.raises(SceneError, match="does not end in .grid, .npy, .png, .tif, .tiff; convert it to one of them"):
        raster_from_bytes(b"grid", "h.jpg", "m")
    with pytest.raises(SceneError, match="not readable as GRID"):
        raster_from_bytes(b"grid\n1 x", "h.grid", "m")


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


@pytest.mark.parametrize(
    ("keys", "system"),
    [
        ([1024, 0, 1, 1, 3072, 0, 1, 32610], "projected coordinates of EPSG:32610"),  # UTM 10 north
        ([1024, 0, 1, 1, 2048, 0, 1, 4326, 3072, 0, 1, 3857], "projected coordinates of EPSG:3857"),  # Mercator of web maps
        ([1024, 0, 1, 1, 3072, 0, 1, 32767], "projected coordinates of a system of its own"),
        ([1024, 0, 1, 1], "projected coordinates of a system of its own"),
        ([1024, 0, 1, 2, 2048, 0, 1, 4269], "latitude and longitude of EPSG:4269"),  # NAD 83
        ([1024, 0, 1, 3, 2048, 0, 1, 4978], "unknown coordinates of EPSG:4978"),  # earth-centred
    ],
)
def test_a_geotiff_in_another_system_is_told_which_command_converts_it(tmp_path: Path, keys: list[int], system: str) -> None:
    """With the keys of the scene file it needs no system."""
    content = geotiff(np.ones((3, 3), dtype=np.float32), [1, 1, 0, len(keys) // 4, *keys])
    told = (
        f"body[0].extent_m: missing; the file has {system}, which are not read: gdalwarp -t_srs EPSG:4326 -dstnodata -9999 "
        "IN.tif OUT.tif makes a file that is; or give extent_m, or south_west_deg and north_east_deg"
    )
    with pytest.raises(SceneError) as refusal:
        load(tmp_path, "h.tif", content)
    assert refusal.value.problems == (told,)
    assert load(tmp_path, "h.tif", content, extent_m=[300, 300]).bodies


def test_a_turned_grid_and_a_file_without_coordinates_are_told_apart(tmp_path: Path) -> None:
    samples = np.ones((3, 3), dtype=np.float32)
    tags = TiffImagePlugin.ImageFileDirectory_v2()
    tags.tagtype.update({34264: 12, 34735: 3})
    tags[34264], tags[34735] = (0.01, 0.001, 0, 1, 0.001, -0.01, 0, 51, 0, 0, 0, 0, 0, 0, 0, 1), tuple(GEOGRAPHIC)
    with pytest.raises(
        SceneError, match="latitude and longitude of EPSG:4326 on a turned grid, which are not read: gdalwarp"
    ):
        load(tmp_path, "h.tif", picture(samples, "TIFF", tiffinfo=tags))
    with pytest.raises(SceneError, match="extent_m: missing; the file has no coordinates: give extent_m, or south_west_deg"):
        load(tmp_path, "h.tif", picture(samples, "TIFF"))


def test_a_map_over_180_degrees_is_told_how_it_gets_its_place(tmp_path: Path) -> None:
    """The tags of the file that the command makes are read. Corners that are really exchanged are told so."""
    corners = {"south_west_deg": [-17.0, 179.5], "north_east_deg": [-16.0, -179.5], "low_m": 0.0, "high_m": 9.0}
    content = picture(np.full((3, 3), 255, dtype=np.uint8))
    with pytest.raises(SceneError, match="crosses 180 degrees, .*-a_srs EPSG:4326 -a_ullr 179.5 -16 180.5 -17 IN OUT.tif"):
        load(tmp_path, "h.png", content, **corners)
    exchanged = corners | {"south_west_deg": [-16.0, 179.0], "north_east_deg": [-17.0, 178.0]}
    with pytest.raises(SceneError, match="; exchange them"):
        load(tmp_path, "h.png", content, **exchanged)
    made = geotiff(np.ones((3, 3), dtype=np.float32), GEOGRAPHIC, tag33922=(0.0, 0.0, 0.0, 179.99, -15.97, 0.0))
    (tmp_path / "h.tif").write_bytes(made)
    body = {"name": "island", "heightmap": "h.tif", "material": "land"}
    scene = load_scene({"origin": {"latitude_deg": -16, "longitude_deg": 179.999}, "body": [body]}, folder=tmp_path)
    assert 2000.0 < np.ptp(world_vertices(scene.bodies[0])[:, 0]) < 2200.0  # 0.02 degrees at 16 south


def test_claimed_sizes_are_checked_before_memory_is_taken() -> None:
    claimed = io.BytesIO()
    np.lib.format.write_array_header_1_0(claimed, {"descr": "<f8", "fortran_order": False, "shape": (10**9, 10**9)})
    with pytest.raises(SceneError, match="1000000000 x 1000000000 samples; two sides"):
        raster_from_bytes(claimed.getvalue(), "h.npy", "m")
    wide = picture(np.zeros((2, MAX_SIDE + 1), dtype=np.uint8))
    with pytest.raises(SceneError, match="2 x 4098 samples"):
        raster_from_bytes(wide, "h.png", "m")
    bomb = wide[:16] + (200_000).to_bytes(4, "big") * 2 + wide[24:]
    with pytest.raises(SceneError, match="is not readable as|samples"):
        raster_from_bytes(bomb, "h.png", "m")
