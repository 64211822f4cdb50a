"""The states of a transmitter and what leads from one to the next: TRANSITIONS has all of it.

Standby, a pause and a radar that is held are no states: they are settings, which a radar obeys while it sends. A spoke
source that waits to take over and an order to stop are no states either: they come from other threads, and an event follows
when the transmitter's thread gets to them.
"""

from enum import Enum
from typing import NamedTuple


class State(Enum):
    """What a transmitter does. The value is a sentence for the documents."""

    READY = "has no thread yet, and waits for `start`"
    SENDING = "sends the spokes of the running spoke source when they are due; in standby it drops them then"
    RESTARTING = "has another spoke source made in place of the one that failed"
    FAILED = "has told all sinks why, and waits for another scene"
    STOPPED = "has ended"


class Event(Enum):
    """What has come of a state. The value is a sentence for the documents."""

    START = "`start` was called"
    TAKEN_OVER = "another spoke source has taken over"
    FAILURE = "the spoke source or a sink has failed"
    RESTARTED = "another spoke source has the next scan ready"
    GIVEN_UP = "no other spoke source may be made, or the radar stops"
    STOP = "`stop` was called"


class Next(NamedTuple):
    """The state that follows, and what that means."""

    state: State
    meaning: str


TRANSITIONS: dict[tuple[State, Event], Next] = {
    (State.READY, Event.START): Next(State.SENDING, "The first epoch is open on every sink."),
    (State.SENDING, Event.TAKEN_OVER): Next(
        State.SENDING, "A new epoch: another scene, at once or when its scan had ended, or another rate of rotation."
    ),
    (State.SENDING, Event.FAILURE): Next(State.RESTARTING, "The rest of the scan is given up."),
    (State.SENDING, Event.STOP): Next(State.STOPPED, "Nothing more is sent."),
    (State.RESTARTING, Event.RESTARTED): Next(State.SENDING, "The same epoch: it goes on after a gap."),
    (State.RESTARTING, Event.TAKEN_OVER): Next(State.SENDING, "A new epoch: a spoke source was ready already."),
    (State.RESTARTING, Event.GIVEN_UP): Next(State.FAILED, "The radar has a fault."),
    (State.FAILED, Event.TAKEN_OVER): Next(State.SENDING, "A new epoch: another scene has ended the fault."),
    (State.FAILED, Event.STOP): Next(State.STOPPED, "The fault stays."),
}


class TransitionError(Exception):
    """An event came in a state that has no place for it: the transmitter's code is wrong."""


class TransmitterState:
    """The state of one transmitter. Any thread may read it; `start`, and then the transmitter's thread alone, write it.

    now: the present state. reason: of the last failure. fault: why the radar has failed, from FAILED until a spoke source
    takes over, also where it stops meanwhile; None while it runs.

    Each attribute is replaced whole. `fault` changes just before `now`.
    """

    def __init__(self) -> None:
        self.now = State.READY
        self.reason = ""
        self.fault: str | None = None

    def allows(self, event: Event) -> bool:
        """Whether the event has a place in the present state."""
        return (self.now, event) in TRANSITIONS

    def fail(self, reason: str) -> Event:
        """Notes why the spoke source or a sink has failed; returns the event."""
        self.reason = reason
        return Event.FAILURE

    def on(self, event: Event) -> None:
        """Passes to the next state. Raises TransitionError where the event has no place in the present one."""
        if not self.allows(event):
            events = ", ".join(each.name for state, each in TRANSITIONS if state is self.now) or "none"
            raise TransitionError(f"{event.name} in state {self.now.name}, which has {events}; see TRANSITIONS")
        if event is Event.GIVEN_UP:
            self.fault = self.reason
        elif event is Event.TAKEN_OVER:
            self.fault = None
        self.now = TRANSITIONS[self.now, event].state
