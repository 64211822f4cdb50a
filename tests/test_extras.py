"""Packages that a plain installation lacks."""

from radar_service.extras import MissingExtra


def test_the_message_says_how_to_install_it() -> None:
    error = MissingExtra("recordings", "record", ModuleNotFoundError("no", name="mcap"))
    assert str(error) == 'recordings need the package mcap; install it: pip install "radar-service[record]"'
    assert error.name == "mcap" and isinstance(error, ModuleNotFoundError)
