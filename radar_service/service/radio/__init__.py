"""The radars of a service: pacing, transmitter, the processes of their scenes, commands, changes of state."""
