"""An executor that stands for another process, at none of its cost."""

import pickle
from concurrent.futures import Future
from typing import Any


class Pickling:
    """Does each job at once, with what is left of it after pickling, and so its result."""

    def __init__(self) -> None:
        self.calls = 0

    def submit(self, function: Any, /, *arguments: Any) -> "Future[Any]":
        self.calls += 1
        function, arguments = pickle.loads(pickle.dumps((function, arguments)))
        future: Future[Any] = Future()
        future.set_result(pickle.loads(pickle.dumps(function(*arguments))))
        return future
