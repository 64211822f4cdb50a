"""Spokes carry the values of their message in SI units."""

import math

import numpy as np
import pytest

from clients.ppi import FeedError, spokes
from clients.ppi.spoke import label_names, spokes_of
from tests.clients.fake_feed import DATA, GREETING, Script, batch, running


def test_spokes_carry_the_values_of_their_message() -> None:
    with running(Script([GREETING, batch(70, 2, heading_deg=40.0)])) as feed:
        received = []
        with pytest.raises(FeedError, match="ended the feed"):
            for spoke in spokes(feed.url, timeout=10.0):
                received.append(spoke)
    assert [s.number for s in received] == [70, 71]
    last = received[1]
    assert (last.epoch, last.scan, last.index, last.time, last.speed) == ("a", 0, 71, 71 / 30.0, 3.5)
    assert last.position == (71.0, -5.0) and not last.blind
    # the wire has whole 1/65536 turns: half of one is 4.8e-5 rad
    assert last.azimuth == pytest.approx(2 * math.pi * 71 / 72, abs=4.8e-5)
    assert last.heading == pytest.approx(math.radians(40.0), abs=4.8e-5)
    assert last.course == pytest.approx(0.5, abs=4.8e-5)
    np.testing.assert_array_equal(last.samples, DATA[71])
    np.testing.assert_allclose(last.range, (np.arange(100) + 0.5) * 20.0, rtol=1e-15)


def test_spokes_have_their_labels_and_powers() -> None:
    plain = batch(0, 2)
    labels = np.arange(2 * plain["bins"], dtype="<u4").reshape(2, -1)
    power = np.arange(4 * plain["bins"], dtype="<f4").reshape(2, 2, -1)
    told = plain | {"labels": labels.tobytes(), "power_sources": [1, 257], "powers": power.tobytes()}
    for k, spoke in enumerate(spokes_of(told)):
        assert spoke.labels is not None and spoke.powers is not None and list(spoke.powers) == [1, 257]
        np.testing.assert_array_equal(spoke.labels, labels[k])
        np.testing.assert_array_equal(spoke.powers[257], power[k, 1])
    assert spokes_of(plain)[0].labels is None and spokes_of(plain)[0].powers is None
    with pytest.raises(ValueError, match="labels: 4 bytes are not 2 rows of 400 bytes"):
        spokes_of(plain | {"labels": b"1234"})
    assert label_names({"sources": [{"number": 1, "name": "sea"}]}) == {1: "sea"} and label_names(GREETING) == {}


def test_a_lost_heading_is_nan() -> None:
    first, second = spokes_of(batch(0, 2, heading_deg=math.nan) | {"heading": [None, 16384]})
    assert math.isnan(first.heading) and second.heading == pytest.approx(math.pi / 2)
