"""Tokens, tickets and host names."""

import hmac

import pytest

from radar_service.service import access as access_module
from radar_service.service.access import MAX_TICKETS, TICKET_SECONDS, Access, Tickets, checked_token, is_loopback

COMMAND, READ = "command-" * 3, "reading-" * 3


def test_a_ticket_lasts_only_so_long_and_their_number_is_bounded() -> None:
    now = 0.0
    tickets = Tickets(lambda: now)
    kept, late = tickets.issue("command"), tickets.issue("read")
    now = TICKET_SECONDS
    assert tickets.redeem(kept) == "command" and tickets.redeem(kept) is None
    now += 0.1
    assert tickets.redeem(late) is None
    first = tickets.issue("read")
    for _ in range(MAX_TICKETS):
        tickets.issue("read")
    assert tickets.redeem(first) is None and len(tickets) == MAX_TICKETS
    now *= 3
    tickets.issue(None)
    assert len(tickets) == 1


def test_every_secret_is_compared_in_constant_time(monkeypatch: pytest.MonkeyPatch) -> None:
    seen: list[bytes] = []
    true_compare = hmac.compare_digest

    def compare(a: bytes, b: bytes) -> bool:
        seen.append(b)
        return true_compare(a, b)

    monkeypatch.setattr(access_module.hmac, "compare_digest", compare)
    for given in (COMMAND, READ, "neither"):
        seen.clear()
        Access(COMMAND, READ).role(f"Bearer {given}")
        assert sorted(seen) == sorted([COMMAND.encode(), READ.encode()])


@pytest.mark.parametrize("bad", ["", "short", "x" * 15, "x" * 513, "with space " * 3, "tab\t" * 8, "ünïcödé" * 4])
def test_a_weak_token_is_refused_without_repeating_it(bad: str) -> None:
    with pytest.raises(ValueError, match="^token: ") as caught:
        checked_token(bad)
    assert not bad or bad not in str(caught.value)
    assert checked_token("x" * 16) == "x" * 16


@pytest.mark.parametrize(
    ("host", "only_here"),
    [("127.0.0.1", True), ("127.8.9.1", True), ("::1", True), ("localhost", True), ("0.0.0.0", False), ("::", False),
     ("192.168.1.5", False), ("radar.lan", False), ("", False)],
)  # fmt: skip
def test_loopback_is_known(host: str, only_here: bool) -> None:
    assert is_loopback(host) is only_here
