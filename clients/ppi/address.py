"""The address of a feed."""

from urllib.parse import parse_qsl, urlencode, urlsplit, urlunsplit

from .errors import FeedError


def feed_url(url: str, **query: str) -> str:
    """Returns the whole address of a feed. `host:port` and `http://host:port` mean the feed of radar 0.

    query: parameters that are added to those of the address, or replace them. Raises FeedError if `url` is no address.
    """
    parts = urlsplit(url if "://" in url else f"ws://{url}")
    scheme = {"http": "ws", "https": "wss"}.get(parts.scheme, parts.scheme)
    if scheme not in ("ws", "wss") or not parts.hostname:
        raise FeedError(f"{url}: not the address of a feed; give ws://HOST:PORT or ws://HOST:PORT/api/radars/ID/feed")
    path = parts.path.rstrip("/") or "/api/radars/0/feed"
    if path.startswith("/api/radars/") and path.count("/") == 3:
        path += "/feed"
    parameters = urlencode(dict(parse_qsl(parts.query)) | query, safe=":")
    return urlunsplit((scheme, parts.netloc, path, parameters, ""))
