"""Checks of a loaded scene: settings outside the valid region of a method, and bodies in unusual positions."""
