"""The protocols of a service, a folder each; what a port declares (`port`), who runs them, and the list of all (`registry`)."""
