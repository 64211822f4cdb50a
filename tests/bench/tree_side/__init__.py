"""What one work tree computes and sends, kept as files: `compare_trees` runs this package with the interpreter of each tree.

It uses public interfaces alone (the Python of docs/python.md, the commands, REST and the native feed), and has a decoder of its
own for the feed, so that it runs on trees whose insides differ.
"""
