"""The radars of a service: pacing, transmitter, the processes of their worlds, commands, changes of state."""
