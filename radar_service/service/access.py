"""Access: two tokens, one-use tickets for websockets, and the host names of this server.

Those who may not know the truth, as a tracker under test, are told nothing that names, counts or places what a scene holds.
"""

import hmac
import secrets
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from ipaddress import ip_address
from typing import Any, Literal

Role = Literal["command", "read"]

TOKEN_LENGTH = (16, 512)  # characters: with a guess each microsecond, 16 random ones are not guessed
TICKET_SECONDS = 30.0
MAX_TICKETS = 1000
BODY = "body "  # how what a choice is about begins, where it is about a body (plan.bodies)
TELLING: Mapping[str, Any] = {
    "caveats": [], "believed": [], "counts": None, "field_db": {}, "costs": None, "realtime_factor": None,
}  # fmt: skip  # parts of a plan that name or count bodies, or say whether these move, and what stands there instead


def checked_token(text: str) -> str:
    """Returns a token that is long enough to protect something. Raises ValueError otherwise, without repeating it."""
    minimum, maximum = TOKEN_LENGTH
    if not minimum <= len(text) <= maximum or not text.isascii() or not text.isprintable() or " " in text:
        raise ValueError(
            f"token: {len(text)} characters; {minimum} to {maximum} printable ASCII ones without spaces are allowed: "
            "take those of `openssl rand -hex 16`"
        )
    return text


def is_loopback(host: str) -> bool:
    """Returns whether only this machine reaches that address."""
    try:
        return ip_address(host).is_loopback
    except ValueError:
        return host.lower() == "localhost"


@dataclass(frozen=True)
class Access:
    """command: the token that is needed to change anything; read: the token to read; None: no token is needed. lossless: whether
    who may read may delay the radar.

    hosts: names that requests may call this server by, None for any. Addresses and localhost are always allowed: a page of
    another site can direct its own name to this server, but not an address.
    """

    command: str | None = None
    read: str | None = None
    hosts: frozenset[str] | None = None
    lossless: bool = False

    def role(self, authorization: str) -> Role | None:
        """Returns the role that an Authorization header gives; None for the rights of everybody."""
        scheme, _, token = authorization.partition(" ")
        given = token.strip().encode() if scheme.lower() == "bearer" else b""
        tokens: tuple[tuple[str | None, Role], ...] = ((self.read, "read"), (self.command, "command"))
        role: Role | None = None
        for secret, its_role in tokens:  # all of them, so that the time does not tell which one matches
            if secret is not None and hmac.compare_digest(given, secret.encode()):
                role = its_role
        return role

    def may(self, role: Role | None, needed: Role) -> bool:
        """Returns whether a client with this role may do what needs that role."""
        if needed == "command":
            return self.command is None or role == "command"
        return self.read is None or role is not None

    def answers_to(self, host: str) -> bool:
        """Returns whether a Host header names this server."""
        name = _host_name(host)
        if self.hosts is None or name == "localhost" or name in self.hosts:
            return True
        try:
            ip_address(name)
        except ValueError:
            return False
        return True


class Tickets:
    """One-time texts that open one websocket each within TICKET_SECONDS, for browsers, which send no headers with a websocket.

    At most MAX_TICKETS are valid at a time. Belongs to the event loop: no locks.
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._roles: dict[str, tuple[Role, float]] = {}  # role, and end of validity

    def __len__(self) -> int:
        return len(self._roles)

    def issue(self, role: Role | None) -> str:
        """Returns a new ticket for a client with this role."""
        now = self._clock()
        for old in [name for name, (_, until) in self._roles.items() if until < now]:
            del self._roles[old]
        while len(self._roles) >= MAX_TICKETS:
            del self._roles[next(iter(self._roles))]
        name = secrets.token_urlsafe(24)
        self._roles[name] = (role or "read", now + TICKET_SECONDS)
        return name

    def redeem(self, ticket: str) -> Role | None:
        """Returns the role of a ticket, once; None for one that is unknown, used or too old."""
        role, until = self._roles.pop(ticket, (None, 0.0))
        return role if until >= self._clock() else None


def _host_name(host: str) -> str:
    """Returns a Host header's name without the port, in lower case; an IPv6 address without its brackets."""
    if host.startswith("["):
        return host[1:].partition("]")[0].lower()
    return host.rpartition(":")[0].lower() if host.count(":") == 1 else host.lower()


def told_plan(plan: Mapping[str, Any], knows_truth: bool) -> dict[str, Any]:
    """Returns a plan as plain data; without the truth, only what it says of methods."""
    if knows_truth:
        return dict(plan)
    hidden = {key: value for key, value in TELLING.items() if key in plan}
    choices = [choice for choice in plan.get("choices", ()) if not choice["what"].startswith(BODY)]
    return {**plan, **hidden, **({"choices": choices} if "choices" in plan else {})}


def told_fields(fields: Mapping[str, Any], is_blind: bool) -> dict[str, Any]:
    """Returns fields of a radar; where it is blind, without seed, scene's name and number of bodies, which tell a known scene."""
    return {**fields, "seed": 0, "scene": {**fields["scene"], "name": "", "bodies": 0}} if is_blind else dict(fields)
