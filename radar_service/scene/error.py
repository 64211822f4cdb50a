"""The one error a scene can raise."""


class SceneError(ValueError):
    """A scene that cannot be run. Its text names the place, the value, what is allowed and what to do, a line each.

    problems: one line per fault, each starting with its place, e.g. `body[3].position_m[1]: ...`.
    """

    def __init__(self, *problems: str) -> None:
        self.problems = problems
        super().__init__("\n".join(problems))
