"""A revision counts changes."""

from radar_service.numerics.revision import STEADY, Revision


def test_each_change_has_another_number() -> None:
    revision = Revision()
    numbers = [revision.number]
    for _ in range(3):
        revision.change()
        numbers.append(revision.number)
    assert len(set(numbers)) == 4 and STEADY.number == 0
