"""Why a feed cannot be received, in sentences for the user."""

from urllib.parse import urlsplit

from websockets.exceptions import ConnectionClosed, InvalidStatus

REFUSED = range(4400, 4500)  # close codes with which the service refuses a request; the same request fails again


class FeedError(Exception):
    """The feed cannot be opened, or it has ended. retry: another attempt may succeed."""

    def __init__(self, text: str, retry: bool = False) -> None:
        super().__init__(text)
        self.retry = retry


def closed_error(url: str, fault: ConnectionClosed, bye: str | None) -> FeedError:
    """The error for a connection that the service closed. bye: the reason in its last message, None without one."""
    code, message = (fault.rcvd.code, fault.rcvd.reason) if fault.rcvd else (1006, "")
    reason = bye or message or f"no reason given (close code {code})"
    if code in REFUSED:
        return FeedError(f"{url}: the radar refused: {reason}")
    return FeedError(f"{url}: the radar ended the feed: {reason}", retry=True)


def refused_error(url: str, fault: InvalidStatus) -> FeedError:
    """The error for a connection that was refused with an HTTP status."""
    status, body = fault.response.status_code, fault.response.body or b""
    message = body.decode("utf-8", "replace").strip()[:500]
    if status == 404:
        message = f"there is no such radar ({message or 'not found'}); {_radars_address(url)} lists the radars"
    return FeedError(f"{url}: refused with HTTP {status}: {message or 'no reason given'}", retry=status >= 500)


def _radars_address(url: str) -> str:
    parts = urlsplit(url)
    return f"{'https' if parts.scheme == 'wss' else 'http'}://{parts.netloc}/api/radars"
