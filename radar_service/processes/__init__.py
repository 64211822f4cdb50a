"""Child processes: who starts them, how they talk, what they may use."""
