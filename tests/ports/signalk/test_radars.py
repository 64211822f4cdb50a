"""Radars as the Signal K Radar API lists them: ids that its paths can have, and the colours of the legend."""

import re

from radar_service.ports.signalk.radars import Radars, legend
from radar_service.service.radio.station import Station
from tests.service.fake import FakeEngine, factory, scene


def test_ids_have_no_dots_and_slashes_and_the_radars_are_found_by_them() -> None:
    """Dots divide the paths of the stream, slashes those of HTTP."""
    stations = {name: Station(name, FakeEngine(scene()), factory()) for name in ("0", "bow.x/1", "ä b")}
    radars = Radars(stations)
    assert [identity for identity, _ in radars] == sorted(["sim-0", "sim-bow-x-1", "sim---b"])
    assert all(
        re.fullmatch("[A-Za-z0-9-]+", identity) and radars.station(identity) is station for identity, station in radars
    )
    assert radars.station("0") is None


def test_the_legend_goes_from_blue_by_green_to_red() -> None:
    """Red, green and blue of each echo add up to full light, to the rounding of three bytes."""
    colours = [[int(pixel["color"][at : at + 2], 16) for at in (1, 3, 5, 7)] for pixel in legend()["pixels"]]
    assert colours[0] == [0, 0, 0, 0] and colours[-1] == [255, 0, 0, 255] and colours[1][2] > 250
    red, green, blue, opacity = zip(*colours[1:], strict=True)
    assert all(abs(sum(each) - 255) <= 1 for each in zip(red, green, blue, strict=True)) and set(opacity) == {255}
    assert list(red) == sorted(red) and list(blue) == sorted(blue, reverse=True) and max(green) > 250
