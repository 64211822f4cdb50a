"""Effects: each declares its keys in a scene and adds to spokes; a new one is a folder here and a line in `registry`."""
