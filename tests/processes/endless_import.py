"""A module that never ends to be imported."""

import threading

threading.Event().wait()
