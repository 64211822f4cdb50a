"""The service without its protocols: codecs, fan-out to clients, radars and their groups, commands, controls."""
