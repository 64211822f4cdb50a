"""Levels; the tables of commands are tried by those of each set."""

from radar_service.ports.dialect.dialect import levels


def test_levels_are_even_from_the_weakest_to_the_strongest() -> None:
    """Bytes of video above 0 are in steps of 254 / (highest - lowest), to half of a level."""
    for weakest, strongest in ((39, 254), (1, 15)):
        got = levels(weakest, strongest)
        assert got[0] == 0 and got[1] == weakest and got[255] == strongest
        assert all(abs(got[b] - weakest - (b - 1) * (strongest - weakest) / 254) <= 0.5 for b in range(1, 256))
