"""The server that all HTTP and websocket protocols share: roles, limits, documentation."""
