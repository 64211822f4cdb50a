"""The command `hello`: says a word."""

import argparse


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("word")


def run(options: argparse.Namespace) -> int:
    print(f"hello {options.word}")
    return 0
