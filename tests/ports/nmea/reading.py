"""A reader of NMEA 0183 that shares nothing with the writer: the checksum is counted bit by bit."""


def read(line: bytes) -> str:
    """What stands between `$` or `!` and `*`. Raises ValueError for another form or a wrong checksum."""
    text = line.decode("ascii")
    if text[0] not in "$!" or text[-5] != "*" or text[-2:] != "\r\n":
        raise ValueError(f"not a sentence: {text!r}")
    body, given = text[1:-5], int(text[-4:-2], 16)
    counted = sum((sum(ord(character) >> bit & 1 for character in body) % 2) << bit for bit in range(7))
    if counted != given:
        raise ValueError(f"checksum {given:02X} of {body!r} is {counted:02X}")
    return body


def fields_of(line: bytes) -> tuple[str, list[str]]:
    """Talker with type, and the fields."""
    kind, *fields = read(line).split(",")
    return kind, fields
