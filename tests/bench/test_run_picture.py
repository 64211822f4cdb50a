"""The picture of a run: tracks have colours of their own and are joined, limits have lines, events have marks."""

import base64
import io
import json
import zlib

import numpy as np
import pytest
from PIL import Image

import radar_service as rs
from radar_service.bench.run import simulator_of
from radar_service.bench.run_picture import SIZE, image_of, joined, ppi_at, ppi_of, run_picture, track_colours
from radar_service.bench.scenario import Scenario
from radar_service.display.ppi import image_position
from tests.bench.test_report import EVENT, RUN, TARGET, TRACK
from tests.bench.test_scenario import SMALL
from tests.scenes import point, scene

RADAR = {"azimuths": 180, "beamwidth_deg": 4, "range_max_m": 1500, "bandwidth_hz": 10e6}


def picture(run: dict) -> Image.Image:
    return Image.open(io.BytesIO(base64.b64decode(run_picture(run))))


def grey(run: dict) -> np.ndarray:
    return np.asarray(picture(run).convert("L")).astype(int)


def scan(number: int, **places: float) -> dict:
    """A scan with tracks by name, so far east [m]."""
    tracks = [{**TRACK, "track": name, "east": east} for name, east in places.items()]
    return {**RUN["scans"][0], "scan": number, "time": 2.5 * (number + 1), "plots": [], "tracks": tracks}


def pixels_of(run: dict, colour: tuple[int, int, int], right: bool = False) -> int:
    """How many pixels of the map, or of the chart on the right, have a colour."""
    image = np.asarray(picture(run).convert("RGB")).astype(int)
    half = image[:, image.shape[1] // 2 :] if right else image[:, : image.shape[1] // 2]
    return int((np.abs(half - colour).max(axis=2) < 12).sum())  # 12: what smoothing leaves inside of a line


C0, C1, C3 = (0x1F, 0x77, 0xB4), (0xFF, 0x7F, 0x0E), (0xD6, 0x27, 0x28)


def test_tracks_have_colours_by_name_and_are_joined() -> None:
    scans = [scan(0, one=0.0), scan(1, one=50.0, two=10.0), scan(2, two=-50.0)]
    assert track_colours(scans) == {"one": "C0", "two": "C1"}
    assert np.array_equal(joined(scans, "one")[:, 0], [0.0, 50.0, np.nan], equal_nan=True)
    run = {**RUN, "events": [], "scans": scans}
    apart = {**run, "scans": [scan(0, one=0.0), scan(1), scan(2, one=50.0)]}
    assert pixels_of(run, C0) > pixels_of(apart, C0) + 20 and pixels_of(run, C1) > 20


def test_states_that_are_too_old_are_drawn_dashed() -> None:
    fresh = scan(0, one=0.0), scan(1, one=60.0), scan(2, one=120.0)
    stale = [{**one, "tracks": [{**one["tracks"][0], "stale": k == 1}]} for k, one in enumerate(fresh)]
    assert np.array_equal(joined(stale, "one")[:, 0], [0.0, np.nan, 120.0], equal_nan=True)
    assert np.array_equal(joined(stale, "one", stale=True)[:, 0], [0.0, 60.0, 120.0])
    solid, dashed, gap = (
        pixels_of({**RUN, "events": [], "scans": scans}, C0) for scans in (fresh, stale, (fresh[0], scan(1), fresh[2]))
    )
    assert gap + 10 < dashed < solid - 10


def test_the_chart_of_distances_has_the_colour_of_the_track_that_follows_and_a_limit() -> None:
    followed = [{**scan(k, one=0.0), "targets": [{**TARGET, "track": "one"}]} for k in range(3)]
    alone = [{**scan(k, one=0.0), "targets": [TARGET]} for k in range(3)]
    runs = [{**RUN, "events": [], "scans": scans} for scans in (followed, alone)]
    assert pixels_of(runs[0], C0, right=True) > pixels_of(runs[1], C0, right=True) + 100
    assert all(pixels_of(run, C3, right=True) > 100 for run in runs)


def test_events_are_marked_on_map_and_chart() -> None:
    run = {**RUN, "events": []}
    changed = grey({**run, "events": [EVENT]}) != grey(run)
    middle = changed.shape[1] // 2
    assert changed[:, :middle].sum() > 100 and changed[:, middle:].sum() > 100


def test_a_run_without_tracks_or_targets_is_drawn() -> None:
    empty = [{**RUN["scans"][0], "tracks": [], "targets": [], "plots": []}]
    assert grey({**RUN, "events": [], "scans": empty}).size


@pytest.mark.parametrize("targets", [1, 40])
def test_any_number_of_targets_leaves_room_for_the_map(targets: int) -> None:
    """A legend of forty names left nothing of it."""
    many = [{**TARGET, "body": f"a target with a long name {k}"} for k in range(targets)]
    tracks = [{**TRACK, "track": f"a track with a long name {k}"} for k in range(targets)]
    pixels = grey({**RUN, "events": [], "scans": [{**RUN["scans"][0], "targets": many, "tracks": tracks}]})
    frame = (pixels[:, : pixels.shape[1] // 2] < 60).sum(axis=0).max()  # the left edge of the map
    assert frame > pixels.shape[0] / 3


def test_tracks_stand_on_the_ppi_of_the_last_scan() -> None:
    """An echo all over the north-east darkens that quarter of the map alone, whose middle is own ship's."""
    echo = np.zeros((SIZE, SIZE), dtype=np.uint8)
    echo[: SIZE // 2, SIZE // 2 :] = 255
    ppi = {"pixels": base64.b64encode(zlib.compress(echo.tobytes())).decode(), "range": 5000.0}
    pixels = []
    for run in (RUN, {**RUN, "ppi": ppi}):
        pixels.append(grey(run))
    changed = np.argwhere(pixels[1] < pixels[0] - 50)
    left, right = np.nonzero((pixels[0] < 60).sum(axis=0) > pixels[0].shape[0] / 3)[0][:2]  # the edges of the map
    assert len(changed) > 1000 and left + 0.4 * (right - left) < changed[:, 1].min() < changed[:, 1].max() <= right


def test_plots_are_seen_on_a_ppi_of_noise_alone() -> None:
    """Noise fills the picture of a last scan from which all targets have gone, and its brightness is half of the scale."""
    noise = np.full((SIZE, SIZE), 150, dtype=np.uint8)
    ppi = {"pixels": base64.b64encode(zlib.compress(noise.tobytes())).decode(), "range": 5000.0}
    plots = [[[east, 40.0] for east in np.linspace(-80.0, 80.0, 30)], []]
    with_plots, without = (
        grey({**RUN, "events": [], "ppi": ppi, "scans": [{**scan(0, one=0.0), "plots": some}]}) for some in plots
    )
    assert (without - with_plots).max() > 80


def test_the_chart_has_all_times_where_no_track_is_near() -> None:
    """An event at scan 2 of 40 is marked in the left half of the chart."""
    scans = [{**scan(k), "targets": [{**TARGET, "nearest": None}]} for k in range(40)]
    run = {**RUN, "events": [], "scans": scans}
    changed = grey({**run, "events": [{**EVENT, "scan": 2, "last": 2}]}) != grey(run)
    width = changed.shape[1]
    line = width // 2 + int(np.argmax(changed[:, width // 2 :].sum(axis=0)))
    assert 0.5 * width < line < 0.65 * width


def test_an_echo_stands_at_its_bearing_and_range() -> None:
    scan = rs.Simulator(scene([point("p", 600, -800)], radar=RADAR), "fast").scan()
    ppi = json.loads(json.dumps(ppi_of(scan), allow_nan=False))
    image = image_of(ppi)
    assert image.shape == (SIZE, SIZE) and image.max() == 1.0
    row, column = (index.mean() for index in np.nonzero(image == 1.0))
    expected = image_position(np.array(1000.0), np.arctan2(600.0, -800.0), SIZE, ppi["range"])
    apart = np.hypot(row - expected[0], column - expected[1]) * 2.0 * ppi["range"] / SIZE
    assert apart < 20.0  # m; a spoke is 35 m wide there


def test_a_scan_without_echoes_is_black() -> None:
    scan = rs.Simulator(scene([point("p", 600, -800, start_s=1000.0)], radar=RADAR), "fast").scan()
    assert image_of(ppi_of(scan)).max() == 0.0


def test_a_later_scan_alone_is_that_of_the_run() -> None:
    simulator = simulator_of(Scenario(**SMALL), 2)
    scans = [ppi_of(simulator.scan()) for _ in range(3)]
    assert ppi_at(Scenario(**SMALL), 2, 2) == scans[2] != scans[1]
