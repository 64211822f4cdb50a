"""The service without its protocols: codecs of the feed, the fan-out to clients, radars and their groups, commands, controls."""
