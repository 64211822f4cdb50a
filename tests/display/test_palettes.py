"""The palettes: stronger is lighter for every eye, weak echoes stand out, and the page has the same colours."""

import json
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from radar_service.display.palettes import DEFAULT_PALETTE, PALETTES, colour_map

PAGE = Path(__file__).parents[2] / "clients" / "web"
# Machado, Oliveira and Fernandes (2009), severity 1.0: linear RGB as seen with no red, no green, no blue cones
EYES = {
    "normal": np.eye(3),
    "protan": np.array([[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]]),
    "deutan": np.array([[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]]),
    "tritan": np.array([[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.303900]]),
}
# CIE XYZ of linear sRGB over those of its white (IEC 61966-2-1)
XYZ = np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]]) / [[0.9505], [1.0], [1.089]]


def lab(colours: NDArray[np.uint8], eye: str) -> NDArray[np.float64]:
    """CIE L*, a*, b* (N, 3) of sRGB colours (N, 3) as that eye sees them (CIE 15:2004)."""
    c = colours / 255.0
    linear = np.where(c <= 0.04045, c / 12.92, ((c + 0.055) / 1.055) ** 2.4)
    xyz = np.clip(linear @ EYES[eye].T, 0.0, 1.0) @ XYZ.T
    f = np.where(xyz > 216 / 24389, np.cbrt(xyz), (xyz * 24389 / 27 + 16) / 116)
    return np.stack([116 * f[:, 1] - 16, 500 * (f[:, 0] - f[:, 1]), 200 * (f[:, 1] - f[:, 2])], axis=1)


def luminance(colours: NDArray[np.uint8]) -> NDArray[np.float64]:
    """Relative luminance (N,) of sRGB colours (N, 3) (WCAG 2.2)."""
    c = colours / 255.0
    result: NDArray[np.float64] = np.where(c <= 0.04045, c / 12.92, ((c + 0.055) / 1.055) ** 2.4) @ [0.2126, 0.7152, 0.0722]
    return result


@pytest.mark.parametrize("eye", EYES)
@pytest.mark.parametrize("palette", PALETTES)
def test_stronger_is_lighter_for_every_eye(palette: str, eye: str) -> None:
    light = lab(colour_map(palette), eye)[:, 0]
    assert light[0] < 20.0 and light[1] > light[0]  # the sea is dark: day, the lightest, has 17
    # Rounding to 8 bits makes neighbours tie or slip: one count of green, the heaviest channel, is 0.4 L* in the dark.
    assert (np.diff(light[1:]) > -0.4).all()
    assert light[-1] - light[1] > 40.0
    sea, *_, strongest = luminance(colour_map(palette))
    assert (strongest + 0.05) / (sea + 0.05) > 7  # WCAG 2.2, 1.4.6


@pytest.mark.parametrize("eye", EYES)
def test_steps_of_4_db_are_told_apart_in_the_default_palette(eye: str) -> None:
    """16 levels. Side by side, 2.3 in CIE L*a*b* is just noticeable (Mahy, Van Eycken and Oosterlinck 1994)."""
    seen = lab(colour_map(), eye)
    assert (np.linalg.norm(seen[17:] - seen[1:-16], axis=1) > 2.3).all()
    assert (seen[17:, 0] - seen[1:-16, 0] > 1.8).all()  # nearly all of it in lightness, without hue


def test_the_default_palette_has_several_hues() -> None:
    """Blue, blue-green, green, yellow: hue angles fall from 280 to 100 degrees, in three steps of 40 or more."""
    seen = lab(colour_map(), "normal")[[1, 48, 70, 150]]
    hue = np.rad2deg(np.arctan2(seen[:, 2], seen[:, 1])) % 360.0
    assert (np.diff(hue) < -20.0).all() and np.ptp(hue) > 160.0


def test_an_echo_3_db_over_the_threshold_stands_out_of_the_sea() -> None:
    level = luminance(colour_map())
    assert (level[13] + 0.05) / (level[0] + 0.05) > 3.0  # WCAG 2.2, 1.4.11; byte 13 is 3 to 3.25 dB


def test_an_unknown_palette_is_refused() -> None:
    with pytest.raises(ValueError, match='palette: "sepia" is not one of multicolour, dusk'):
        colour_map("sepia")


def test_the_page_has_the_same_palettes() -> None:
    source = (PAGE / "palettes.js").read_text(encoding="utf-8")
    table = json.loads(source.split("PALETTES = ", 1)[1].rstrip().removesuffix(";"))
    assert {name: tuple((level, colour) for level, colour in stops) for name, stops in table.items()} == PALETTES
    assert f'<html lang="en" data-palette="{DEFAULT_PALETTE}">' in (PAGE / "index.html").read_text(encoding="utf-8")
