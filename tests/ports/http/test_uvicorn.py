"""uvicorn promises none of its internals: what the service uses of its classes is there, and the version is bounded."""

import ast
import inspect
import tomllib
from pathlib import Path

import pytest
import uvicorn
from websockets.protocol import State
from websockets.server import ServerProtocol

from radar_service.ports.http.server import LimitedProtocol, Server
from radar_service.ports.http.websocket import OPEN, FramedWebSocket

PYPROJECT = Path(__file__).parents[3] / "pyproject.toml"


def of_self(kind: type, *contexts: type[ast.expr_context]) -> set[str]:
    """Attributes of `self` that the source of one class loads or stores."""
    tree = ast.parse(inspect.getsource(kind))
    return {
        node.attr
        for node in ast.walk(tree)
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id == "self"
        and isinstance(node.ctx, contexts)
    }  # fmt: skip


def names(kind: type) -> set[str]:
    """Attributes that a class itself gives its instances."""
    return of_self(kind, ast.Store) | set(vars(kind))


def overridden(kind: type) -> set[str]:
    """Methods of its parent that the class calls by `super()`."""
    tree = ast.parse(inspect.getsource(kind))
    return {
        node.attr for node in ast.walk(tree)
        if isinstance(node, ast.Attribute) and ast.unparse(node.value) == "super()" and node.attr != "__init__"
    }  # fmt: skip


@pytest.mark.parametrize(
    ("kind", "some"),
    [
        (
            FramedWebSocket,
            {"writable", "disconnected", "close_sent", "conn", "transport", "scope", "run_asgi", "handle_events"},
        ),
        (
            LimitedProtocol,
            {"connections", "client", "conn", "flow", "loop", "transport", "connection_made", "data_received"},
        ),
        (Server, {"servers", "should_exit", "startup", "shutdown"}),
    ],
)
def test_uvicorn_has_what_is_used_of_it(kind: type, some: set[str]) -> None:
    parent = kind.__mro__[1]
    assert parent.__module__.startswith("uvicorn.")
    used = (of_self(kind, ast.Load, ast.Store) - names(kind)) | (of_self(kind, ast.Store) & names(parent)) | overridden(kind)
    assert some <= used, "the test no longer sees what the service uses"
    assert used <= names(parent), f"uvicorn {uvicorn.__version__} has no {parent.__name__}.{used - names(parent)}"


def test_a_connection_that_is_open_has_the_state_that_frames_are_written_in() -> None:
    assert State.OPEN.value == OPEN


def test_a_protocol_keeps_its_frames_as_events_until_they_are_fetched() -> None:
    protocol = ServerProtocol(state=State.OPEN)
    protocol.receive_data(b"\x89\x80abcd\x89\x80abcd")
    assert len(protocol.events) == 2 == len(protocol.events_received()) and not protocol.events


def test_the_version_of_uvicorn_is_the_tested_one() -> None:
    (needed,) = (line for line in tomllib.loads(PYPROJECT.read_text())["project"]["dependencies"] if "uvicorn" in line)
    assert needed == "uvicorn>=0.54,<0.55" and uvicorn.__version__.startswith("0.54.")
