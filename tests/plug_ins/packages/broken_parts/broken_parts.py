raise RuntimeError("it needs\nanother version")
