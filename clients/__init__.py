"""Receivers of the feed: a page for browsers and a Python client.

An installation has this package as `radar_service.clients`; in a checkout it is `clients` as well. Modules import each
other by relative names, so that a program which uses one of the two names loads each module once.
"""
