"""The protocols of a service, each in a folder of its own: see `stream.ports.port`."""
