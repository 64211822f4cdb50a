"""Measures a screenshot of the radar picture: centre, rim and echoes, and the positions where theory puts them."""

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import ndimage

from tests.clients.chromium import CHROMIUM, Page
from tests.clients.fake_radar import Picture

BROWSER = [
    pytest.mark.browser,
    pytest.mark.skipif(not CHROMIUM.exists(), reason=f"{CHROMIUM} is absent: install the Debian package chromium"),
]

TARGETS = ((30.0, 900.0), (120.0, 1500.0), (250.0, 600.0))  # degrees from north, m; no two alike, none on a symmetry
BARE = "rings=off&headline=off&sweep=off&afterglow=0&palette=dusk"  # echoes alone, at full strength, in yellow
DRAWN = "document.getElementById('scope').dataset.drawn === '{}'"  # epoch and next sequence number
# A blob's centroid errs by half a pixel, so does each edge of the ring that gives centre and scale, whose outermost
# pixel the frame of the scope may hide.
PIXELS = 1.5


def box(page: Page) -> tuple[float, float, float]:
    """Left and top edge of the scope and its side, in pixels."""
    x, y, side = page.ask("(({x, y, width}) => [x, y, width])(document.getElementById('scope').getBoundingClientRect())")
    return x, y, side


def seen(page: Page) -> NDArray[np.int16]:
    """The screen (height, width, 3), black outside the scope; without the banner, which on a busy machine says what is late."""
    page.ask("document.getElementById('banner').style.visibility = 'hidden'")
    x, y, side = box(page)
    inside = slice(int(np.ceil(y)), int(y + side)), slice(int(np.ceil(x)), int(x + side))
    screen = page.look()
    scope = np.zeros_like(screen)
    scope[inside] = screen[inside]
    return scope


def echoes(screen: NDArray[np.int16]) -> NDArray[np.bool_]:
    """Pixels of a strong echo in the dusk palette: bright and yellow, which no overlay is."""
    inside: NDArray[np.bool_] = (screen[..., 0] > 150) & (screen[..., 0] - screen[..., 2] > 40)
    return inside


def blobs(screen: NDArray[np.int16]) -> tuple[NDArray[np.float64], list[tuple[slice, slice]]]:
    """Centroids (n, 2) of all connected echoes, x and y in pixels, and the boxes about them."""
    labels, count = ndimage.label(ndimage.binary_closing(echoes(screen)), np.ones((3, 3)))
    centroids = [ndimage.center_of_mass(labels == i + 1)[::-1] for i in range(count)]
    return np.array(centroids), ndimage.find_objects(labels)


def measure(screen: NDArray[np.int16]) -> tuple[NDArray[np.float64], float, NDArray[np.float64]]:
    """Centre (x, y) and radius of the picture by its full ring, and centroids (n, 2) of the spots inside, all in pixels."""
    centroids, boxes = blobs(screen)
    ring = max(range(len(boxes)), key=lambda i: boxes[i][0].stop - boxes[i][0].start)
    rows, columns = boxes[ring]
    centre = np.array([columns.start + columns.stop - 1, rows.start + rows.stop - 1]) / 2
    radius = (rows.stop - rows.start + columns.stop - columns.start) / 4
    return centre, radius, np.delete(centroids, ring, axis=0)


def expected(picture: Picture, centre: NDArray[np.float64], radius: float, up_deg: float) -> NDArray[np.float64]:
    """Expected pixels of TARGETS (n, 2), computed independently of the page: clockwise from the top of the screen, y downward."""
    bearing, distance = np.deg2rad(np.array(TARGETS)[:, 0] - up_deg), np.array(TARGETS)[:, 1]
    cell = (np.floor(distance / picture.step) + 0.5) * picture.step
    return centre + (cell / picture.range * radius)[:, None] * np.stack([np.sin(bearing), -np.cos(bearing)], axis=-1)


def off_by(centres: NDArray[np.float64], expected_at: NDArray[np.float64]) -> float:
    """The greatest distance from an expected position to the nearest spot [pixels]; both hold as many points."""
    assert centres.shape == expected_at.shape
    return float(np.linalg.norm(centres[:, None] - expected_at, axis=-1).min(axis=0).max())
