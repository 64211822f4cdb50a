"""Reads raster files as samples. Their formats are the entry points `radar_service.rasters`, by the ending of their files.

Ours, grey PNG, .npy and TIFF, check sizes before the data is unpacked.
"""

import io
import warnings
from functools import partial
from pathlib import PurePosixPath
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from radar_service import plug_ins
from radar_service.numerics import Flags
from radar_service.scene_file.readers.file_format import Format, refusals
from radar_service.scene_file.readers.formats import formats_of
from radar_service.world import SceneError

MAX_SIDE = 4097
MAX_FILE_BYTES = 200 * 2**20
Corners = tuple[tuple[float, float], tuple[float, float]]

GREY_TYPES = {"L": np.uint8, "I;16": np.uint16, "I;16B": np.uint16, "I": np.int32, "F": np.float32}
# TIFF tags of GeoTIFF 1.1 (OGC 19-008r4, 2019)
PIXEL_SCALE, TIEPOINT, TRANSFORMATION, GEO_KEYS, NO_DATA = 33550, 33922, 34264, 34735, 42113
GT_MODEL_TYPE, GT_RASTER_TYPE, GEODETIC_CRS, PROJECTED_CRS = 1024, 1025, 2048, 3072
PROJECTED, GEOGRAPHIC, WGS84, USER_DEFINED = 1, 2, 4326, 32767
NO_COORDINATES = "the file has no coordinates: give"
EXAMPLE_SIDE = 140  # samples: above heightmap.MAX_GEODESIC_SAMPLES, so that examples use all that maps may


class Raster(NamedTuple):
    """The samples of a raster file, and what the file tells about them.

    samples: (rows, columns), row 0 is north.
    grey: whether samples are brightness; otherwise they are metres.
    corners: (latitude, longitude) [degrees, WGS 84] of the south-west and north-east samples, None if not in the file.
    findings: defects of the file in words without a subject, for warnings.
    empty: (rows, columns) which samples have no data; None: none of them.
    unplaced: why the file has no corners, in words before the keys that may give them.
    """

    samples: NDArray[Any]
    grey: bool
    corners: Corners | None = None
    findings: tuple[str, ...] = ()
    empty: Flags | None = None
    unplaced: str = NO_COORDINATES


def _check_size(shape: tuple[int, ...], location: str) -> None:
    if len(shape) != 2 or not all(2 <= side <= MAX_SIDE for side in shape):
        raise SceneError(
            f"{location}: {' x '.join(map(str, shape))} samples; two sides of 2 to {MAX_SIDE} are allowed: crop or thin it"
        )


def _npy(content: bytes, location: str) -> Raster:
    file = io.BytesIO(content)
    version = np.lib.format.read_magic(file)
    read_header = np.lib.format.read_array_header_1_0 if version == (1, 0) else np.lib.format.read_array_header_2_0
    shape, _, dtype = read_header(file)
    _check_size(shape, location)
    if dtype.hasobject or dtype.kind not in "iuf":
        raise SceneError(
            f"{location}: samples have the type {dtype}; integer or floating-point numbers are needed: convert them"
        )
    file.seek(0)
    return Raster(np.load(file, allow_pickle=False), grey=False)


def _image(kind: str, content: bytes, location: str) -> Raster:
    from PIL import Image  # here: few scenes have pictures, and it would slow every start

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # about sizes, which are checked here, and metadata, which is not used
        with Image.open(io.BytesIO(content), formats=[kind]) as image:
            _check_size((image.height, image.width), location)
            if image.mode not in GREY_TYPES:
                raise SceneError(f'{location}: the pixels are "{image.mode}", not grey; convert it to 8 or 16 bit grey')
            samples = np.array(image).astype(GREY_TYPES[image.mode])
            if kind == "PNG":
                return Raster(samples.astype(np.uint16) if image.mode == "I" else samples, grey=True)
            return _georeferenced(samples, dict(getattr(image, "tag_v2", {})), location)


def _georeferenced(samples: NDArray[Any], tags: dict[int, Any], location: str) -> Raster:
    """Returns the samples of a TIFF, which are metres, with its corners if its keys declare geographic WGS 84."""
    keys = _geo_keys(tags)
    unplaced = _other_system(keys, {PIXEL_SCALE, TIEPOINT} <= tags.keys(), TRANSFORMATION in tags)
    corners = None if unplaced else _corners(samples.shape, tags, keys, location)
    if NO_DATA not in tags:
        return Raster(samples, False, corners, unplaced=unplaced)
    mark = float(str(tags[NO_DATA]).strip("\0 "))
    empty = np.isnan(samples) if np.isnan(mark) else samples == mark
    findings = (f"{int(empty.sum())} samples without data become sea",) if empty.any() else ()
    return Raster(samples, False, corners, findings, empty, unplaced)


def _geo_keys(tags: dict[int, Any]) -> dict[int, int]:
    """Returns the whole-number keys of a GeoTIFF; none of another TIFF."""
    entries = np.array(tags.get(GEO_KEYS, ()), dtype=np.int64)
    return {int(key): int(value) for key, tag, _, value in entries[4 : 4 * (len(entries) // 4)].reshape(-1, 4) if tag == 0}


def _other_system(keys: dict[int, int], tied: bool, turned: bool) -> str:
    """Returns why a file has no corners in WGS 84, with the command that makes one that does; empty where it has them.

    tied: whether its tags tie a pixel to a place; turned: whether they turn or shear the grid.
    """
    if not keys or not (tied or turned):
        return NO_COORDINATES
    model, code = keys.get(GT_MODEL_TYPE, 0), keys.get(PROJECTED_CRS, keys.get(GEODETIC_CRS, 0))
    if tied and model == GEOGRAPHIC and keys.get(GEODETIC_CRS) == WGS84:
        return ""
    kind = {PROJECTED: "projected coordinates", GEOGRAPHIC: "latitude and longitude"}.get(model, "unknown coordinates")
    system = f"{kind} of " + ("a system of its own" if code in (0, USER_DEFINED) else f"EPSG:{code}")
    return (
        f"the file has {system}{'' if tied else ' on a turned grid'}, which are not read: gdalwarp -t_srs EPSG:4326 "
        "-dstnodata -9999 IN.tif OUT.tif makes a file that is; or give"
    )


def _corners(shape: tuple[int, ...], tags: dict[int, Any], keys: dict[int, int], location: str) -> Corners:
    column, row, _, longitude, latitude = (float(v) for v in tags[TIEPOINT][:5])
    across, down = float(tags[PIXEL_SCALE][0]), float(tags[PIXEL_SCALE][1])
    half = 0.0 if keys.get(GT_RASTER_TYPE) == 2 else 0.5  # PixelIsPoint; PixelIsArea ties the pixel's corner
    west, north = longitude + (half - column) * across, latitude - (half - row) * down
    east, south = west + across * (shape[1] - 1), north - down * (shape[0] - 1)
    if not (-90 <= south < north <= 90 and -360 <= west < east <= 360):
        raise SceneError(
            f"{location}: the tags give latitude {south:g} to {north:g}, longitude {west:g} to {east:g}; correct them"
        )
    return (south, west), (north, east)


def _npy_example() -> tuple[bytes, ...]:
    file = io.BytesIO()
    np.save(file, np.full((EXAMPLE_SIDE, EXAMPLE_SIDE), 40_000, dtype=np.uint16))
    return (file.getvalue(),)


def _image_examples(kind: str, *compressions: str | None) -> tuple[bytes, ...]:
    from PIL import Image

    picture = Image.fromarray(np.full((EXAMPLE_SIDE, EXAMPLE_SIDE), 40_000, dtype=np.uint16))
    files = [io.BytesIO() for _ in compressions]
    for file, compression in zip(files, compressions, strict=True):
        picture.save(file, kind, **({} if compression is None else {"compression": compression}))
    return tuple(file.getvalue() for file in files)


PNG = Format[Raster](
    "png", lambda content: content.startswith(b"\x89PNG\r\n\x1a\n"), partial(_image, "PNG"), partial(_image_examples, "PNG", None)
)  # fmt: skip
NPY = Format[Raster]("npy", lambda content: content.startswith(b"\x93NUMPY"), _npy, _npy_example)
TIFF = Format[Raster](
    "tiff", lambda content: content.startswith((b"II*\0", b"MM\0*")), partial(_image, "TIFF"),
    partial(_image_examples, "TIFF", None, "tiff_lzw", "tiff_adobe_deflate"),
)  # fmt: skip


def raster_from_bytes(content: bytes, name: str, location: str) -> Raster:
    """Returns the samples of a raster file; the ending of `name` gives the format. Raises SceneError at `location`."""
    ending, known = PurePosixPath(name).suffix.lower()[1:], plug_ins.names("rasters")
    if ending not in known:
        endings = ", ".join(f".{ending}" for ending in known)
        raise SceneError(f"{location}: the file name does not end in {endings}; convert it to one of them")
    (kind,) = formats_of(ending, location, "rasters")
    with refusals(kind.name, location):
        if not kind.detect(content):
            raise SceneError(
                f"{location}: this is not a {ending.upper()} file (it begins with {content[:8]!r}); export it again"
            )
        kind.check(content, location)
        raster = Raster(*kind.parse(content, location))
    unknown = ~np.isfinite(raster.samples) if raster.empty is None else ~np.isfinite(raster.samples) & ~raster.empty
    if unknown.any():
        count = int(unknown.sum())
        raise SceneError(f"{location}: {count} samples are not finite numbers; fill them, with -1 for sea")
    return raster
