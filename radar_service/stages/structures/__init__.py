"""Own ship's structures near the antenna: what they take from the beam, and the indirect echoes that they reflect."""
