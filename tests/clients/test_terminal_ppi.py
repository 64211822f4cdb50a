"""The PPI draws targets at their positions, marks missing azimuths, and becomes text for a terminal."""

import math

import numpy as np
import pytest

from clients.ppi.terminal_ppi import TerminalPpi, half_blocks
from radar_service.display.picture import UNSEEN
from tests.clients.fake_feed import GREETING, TARGETS, batch, hello
from tests.clients.received import ppi_of


@pytest.mark.parametrize("head_up", [False, True])
def test_targets_are_at_their_bearings_and_ranges(head_up: bool) -> None:
    size, image = 80, ppi_of(GREETING, batch(0, 72, heading_deg=70.0), head_up=head_up).image(80)
    lit = image.astype(int).sum(axis=2) > 300
    for bearing_deg, distance in TARGETS:
        angle, far = math.radians(bearing_deg - 70.0 * head_up), distance / 2000.0 * size / 2
        y, x = size / 2 - far * math.cos(angle), size / 2 + far * math.sin(angle)
        i0, j0 = max(0, int(y) - 3), int(x) - 3
        assert lit[i0 : i0 + 7, j0 : j0 + 7].any()
        lit[i0 : i0 + 7, j0 : j0 + 7] = False
    assert not lit.any()  # rings and heading line are darker


def test_azimuths_without_a_spoke_are_grey_and_a_new_epoch_begins_empty() -> None:
    half = ppi_of(GREETING, batch(0, 36))
    image = half.image(60)
    assert image[30, 10].tolist() == list(UNSEEN) and image[30, 50].tolist() != list(UNSEEN)
    half.take(hello("b", bins=50))
    assert (half.image(60)[25:35, 46] == UNSEEN).all()
    assert not TerminalPpi().image(10).any() and TerminalPpi().caption == "no radar yet"


def test_half_blocks_show_two_pixels_each() -> None:
    image = np.arange(5 * 3 * 3, dtype=np.uint8).reshape(5, 3, 3)
    lines = half_blocks(image)
    assert len(lines) == 3 and lines[0].startswith("\x1b[38;2;0;1;2;48;2;9;10;11m\u2580\x1b[38;2;3;4;5;")
    assert lines[2].endswith("\x1b[38;2;42;43;44;48;2;0;0;0m\u2580\x1b[0m")
    assert half_blocks(np.zeros((2, 9, 3), np.uint8)) == ["\x1b[38;2;0;0;0;48;2;0;0;0m" + "\u2580" * 9 + "\x1b[0m"]


def test_a_lost_heading_stays_as_it_was_last_reported() -> None:
    ppi = ppi_of(GREETING, batch(0, 36, heading_deg=70.0), batch(36, 36, heading_deg=math.nan), head_up=True)
    assert "heading 070.0" in ppi.caption and ppi.image(40).any()
