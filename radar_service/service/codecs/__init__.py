"""Codecs: what a radar sends as the messages of one protocol."""
