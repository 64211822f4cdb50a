"""Who may do what: two tokens, one-use tickets for websockets, and the names that this server answers to."""

import hmac
import secrets
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from ipaddress import ip_address
from typing import Literal

Rank = Literal["command", "read"]

TOKEN_LENGTH = (16, 512)  # characters: a guess a microsecond long finds no 16 random ones
TICKET_SECONDS = 30.0
MAX_TICKETS = 1000


def checked_token(text: str) -> str:
    """A token fit to guard something. Raises ValueError otherwise, without repeating it."""
    least, most = TOKEN_LENGTH
    if not least <= len(text) <= most or not text.isascii() or not text.isprintable() or " " in text:
        raise ValueError(
            f"token: {len(text)} characters; {least} to {most} printable ASCII ones without spaces are allowed: "
            "take those of `openssl rand -hex 16`"
        )
    return text


def is_loopback(host: str) -> bool:
    """Whether only this machine reaches that address."""
    try:
        return ip_address(host).is_loopback
    except ValueError:
        return host.lower() == "localhost"


@dataclass(frozen=True)
class Access:
    """command: the token that changes anything; read: the one without which nothing is seen; None: everybody may.

    hosts: names that requests may call this server by, None any. Addresses and localhost always pass: a page of another
    site can make its own name lead here, but not an address.
    """

    command: str | None = None
    read: str | None = None
    hosts: frozenset[str] | None = None
    _tickets: dict[str, tuple[Rank, float]] = field(default_factory=dict, repr=False, compare=False)

    def rank(self, authorization: str) -> Rank | None:
        """What an Authorization header entitles to beyond what everybody may; None: nothing."""
        scheme, _, token = authorization.partition(" ")
        given = token.strip().encode() if scheme.lower() == "bearer" else b""
        found: Rank | None = None
        for secret, rank in ((self.read, "read"), (self.command, "command")):
            if secret is not None and hmac.compare_digest(given, secret.encode()):
                found = "command" if rank == "command" else "read"
        return found

    def may(self, rank: Rank | None, wanted: Rank) -> bool:
        """Whether who has that rank may do that."""
        if wanted == "command":
            return self.command is None or rank == "command"
        return self.read is None or rank is not None

    def ticket(self, rank: Rank | None, clock: Callable[[], float]) -> str:
        """A word that opens one websocket within TICKET_SECONDS, for browsers, which send no headers with it."""
        now = clock()
        for old in [name for name, (_, until) in self._tickets.items() if until < now]:
            del self._tickets[old]
        while len(self._tickets) >= MAX_TICKETS:
            del self._tickets[next(iter(self._tickets))]
        name = secrets.token_urlsafe(24)
        self._tickets[name] = (rank or "read", now + TICKET_SECONDS)
        return name

    def redeem(self, ticket: str, clock: Callable[[], float]) -> Rank | None:
        """The rank that a ticket stands for, once; None for one that is unknown, used or old."""
        rank, until = self._tickets.pop(ticket, (None, 0.0))
        return rank if until >= clock() else None

    def answers_to(self, host: str) -> bool:
        """Whether a Host header names this server."""
        name = _host_name(host)
        if self.hosts is None or name == "localhost" or name in self.hosts:
            return True
        try:
            ip_address(name)
        except ValueError:
            return False
        return True

    def as_dict(self) -> Mapping[str, bool]:
        """What is guarded, in plain data."""
        return {"command": self.command is not None, "read": self.read is not None}


def _host_name(host: str) -> str:
    """Without the port, lower case; of an IPv6 address without its brackets."""
    if host.startswith("["):
        return host[1:].partition("]")[0].lower()
    return host.rpartition(":")[0].lower() if host.count(":") == 1 else host.lower()
