"""Levels; the tables of commands are tried by those of each set."""

from radar_service.ports.dialect.announcements import Announcements, Senders
from radar_service.ports.dialect.dialect import STANDBY, TRANSMIT, levels
from radar_service.ports.garmin_xhd.datagrams import XHD
from tests.ports.kept import Kept


def test_levels_are_even_from_the_weakest_to_the_strongest() -> None:
    """Bytes of video above 0 are in steps of 254 / (highest - lowest), to half of a level."""
    for weakest, strongest in ((39, 254), (1, 15)):
        got = levels(weakest, strongest)
        assert got[0] == 0 and got[1] == weakest and got[255] == strongest
        assert all(abs(got[b] - weakest - (b - 1) * (strongest - weakest) / 254) <= 0.5 for b in range(1, 256))


# announcements: what a radar of another maker sends by the clock, at changes and when it is looked for: an xHD, and a HALO.


def test_heartbeats_and_reports_come_by_the_clock_and_states_in_their_order() -> None:
    senders, now = Senders(Kept(), Kept(), Kept()), [0.0]
    beats, reports, spokes = (sender.pieces for sender in senders)  # type: ignore[attr-defined]
    announced = Announcements(XHD, "172.16.2.0", senders, lambda: now[0])
    announced.what_is_due("0")
    assert len(beats) == 1 and not reports  # no controls are known yet
    announced.report(controls={"transmit": True}, range=500, range_max=1000.0)
    size = len(reports)
    for now[0], count in ((0.4, 1), (0.5, 2), (0.9, 2), (1.0, 3)):
        announced.what_is_due("0")
        assert len(reports) == count * size
    assert len(beats) == 2
    announced.what_is_due("0", sought=True)
    assert len(beats) == 3
    announced.what_is_due("0", at_once=True)
    assert len(reports) == 4 * size
    announced.become(STANDBY)
    assert len(reports) == 4 * size  # as before
    announced.spokes([b"12345678x"])
    announced.become(TRANSMIT)
    announced.become(STANDBY)
    announced.spokes([b"12345678x"], transmits=False)  # the last ones, after it went to standby
    states = [each[8] for each in reports[4 * size :] if each[:2] == b"\x92\x09"]
    assert states == [4, 5, 3] and len(spokes) == 2
