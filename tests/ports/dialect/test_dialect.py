"""What tables of commands are made of, and levels."""

import pytest

from radar_service.ports.dialect.dialect import Commands, IgnoredError, Setting, follow, levels, one_of, percent, ranged

SHOWN = Setting(range=500, range_max=6000.0)
TABLE: Commands = {
    (1, 1): one_of({0: {"transmit": False}, 1: {"transmit": True}}),
    (2, 2): percent("gain", 1000, gain_auto=False),
    (3, 4): lambda value, of: ranged(value / 10.0, of),
}


def test_commands_are_followed_by_their_number_and_size() -> None:
    assert follow(TABLE, 1, b"\1", SHOWN) == {"transmit": True}
    assert follow(TABLE, 2, b"\xfa\0", SHOWN) == {"gain": 25.0, "gain_auto": False}
    for content, metres in ((b"\x10\x27\0\0", 1000.0), (b"\xff\xff\xff\xff", 6000.0), (b"\1\0\0\0", 10.0)):
        assert follow(TABLE, 3, content, SHOWN) == {"range_m": metres}
    follow(TABLE, 1, b"\1", SHOWN).clear()
    assert follow(TABLE, 1, b"\1", SHOWN)  # what is returned is the caller's


@pytest.mark.parametrize(
    ("number", "value", "word"),
    [(9, b"\1", "unknown"), (1, b"", "form"), (1, b"\1\0", "form"), (1, b"\2", "value"), (2, b"\xe9\3", "value")],
)
def test_what_is_not_followed_has_a_word(number: int, value: bytes, word: str) -> None:
    with pytest.raises(IgnoredError, match=f"^{word}$"):
        follow(TABLE, number, value, SHOWN)


def test_levels_are_even_from_the_weakest_to_the_strongest() -> None:
    """Bytes of video above 0 are in steps of 254 / (highest - lowest), to half of a level."""
    for weakest, strongest in ((39, 254), (1, 15)):
        got = levels(weakest, strongest)
        assert got[0] == 0 and got[1] == weakest and got[255] == strongest
        assert all(abs(got[b] - weakest - (b - 1) * (strongest - weakest) / 254) <= 0.5 for b in range(1, 256))
