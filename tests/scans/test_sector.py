"""A sector has the bytes that its azimuths have in a whole scan, and costs its share."""

from functools import cache

import numpy as np
import pytest

import radar_service as rs
from radar_service.echo.echoes import AzimuthTimes
from radar_service.engine import pipeline
from radar_service.engine.preparation import Prepared
from radar_service.numerics.types import Profiles
from radar_service.scans.sector import Sector
from tests.scenes import point, scene

MADE = scene(
    [point("a", 30, 900, swerling=1), point("b", -60, 1200, course_deg=90, speed_kn=15), point("c", 900, 0)],
    radar={"azimuths": 360, "beamwidth_deg": 3, "range_max_m": 2000, "blind_sectors_deg": [[5, 9]]},
    environment={"noise": True, "sea_state": 3, "rain_mm_h": 2},
)
DEGREE = np.pi / 180.0


@cache
def whole_scans(fidelity: str) -> tuple[rs.Scan, ...]:
    """The first two scans without a sector."""
    whole = rs.Simulator(MADE, fidelity, 5)
    return whole.scan(), whole.scan()


@pytest.mark.sample(5)
@pytest.mark.parametrize("ends", [(10, 28), (350, 20), (-10, 20), (0, 359), (90, 90.5), (200, 199)])
@pytest.mark.parametrize("fidelity", ["fast", "documented"])
def test_its_bytes_are_those_of_a_whole_scan(ends: tuple[float, float], fidelity: str) -> None:
    sector = ends[0] * DEGREE, ends[1] * DEGREE
    part = rs.Simulator(MADE, fidelity, 5, sector=sector)
    for expected in whole_scans(fidelity):
        made = part.scan()
        inside = (np.arange(360) - ends[0]) % 360 <= (ends[1] - ends[0]) % 360
        np.testing.assert_array_equal(~np.isnan(made.time), inside)
        assert made.field[inside].tobytes() == expected.field[inside].tobytes()
        assert made.power[inside].tobytes() == expected.power[inside].tobytes()
        for name in ("time", "heading", "position", "course", "speed"):
            np.testing.assert_array_equal(getattr(made, name)[inside], getattr(expected, name)[inside])
            assert np.isnan(getattr(made, name)[~inside]).all()
        np.testing.assert_array_equal(made.azimuth, expected.azimuth)
        assert np.isnan(made.field[~inside]).all() and made.number == expected.number


def test_a_sector_across_north_comes_in_two_stretches_of_blocks() -> None:
    sim = rs.Simulator(MADE, "fast", sector=(-4 * DEGREE, 6 * DEGREE))
    blocks = list(sim.blocks(scans=2, size=5))
    assert [(block.scan, block.index, len(block)) for block in blocks] == [
        (scan, *stretch) for scan in range(2) for stretch in ((0, 5), (5, 2), (356, 4))
    ]
    assert [block.first for block in blocks[:3]] == [0, 5, 356]


def test_other_tiles_are_not_computed(monkeypatch: pytest.MonkeyPatch) -> None:
    computed: list[int] = []
    profiles = pipeline.profiles

    def counted(prepared: Prepared, azimuths: AzimuthTimes) -> Profiles:
        computed.append(int(azimuths.number[0]))
        return profiles(prepared, azimuths)

    monkeypatch.setattr(pipeline, "profiles", counted)
    rs.Simulator(MADE, "fast", sector=(90 * DEGREE, 100 * DEGREE)).scan()
    assert 1 <= len(computed) <= 2


@pytest.mark.parametrize("sector", [(0.0, np.nan), (1.0,), (0.0, 1.0, 2.0)])
def test_what_is_no_sector_is_refused(sector: tuple[float, ...]) -> None:
    with pytest.raises(ValueError, match="two angles"):
        rs.Simulator(MADE, "fast", sector=sector)  # type: ignore[arg-type]


def test_the_rest_of_a_sector_begins_at_an_azimuth() -> None:
    radar = MADE.radar
    whole, part = Sector(radar, None), Sector(radar, (10 * DEGREE, 20.5 * DEGREE))
    assert whole.after(0) is whole and whole.requested is None
    assert np.flatnonzero(whole.after(350).requested).tolist() == list(range(350, 360))
    assert np.flatnonzero(part.after(15).requested).tolist() == list(range(15, 21)) and part.requested is not None
    assert np.flatnonzero(part.requested).tolist() == list(range(10, 21))
