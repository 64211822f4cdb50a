"""The error for scenes that cannot be used."""


class SceneError(ValueError):
    """Raised for a scene that cannot be used. Each line of its text gives the key, the value, the allowed range, the remedy.

    problems: the lines; each starts with its key path, e.g. `body[3].position_m[1]: ...`.
    """

    def __init__(self, *problems: str) -> None:
        self.problems = problems
        super().__init__("\n".join(problems))
