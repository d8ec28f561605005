"""`python -m shockpc`: the same as the `shockpc` command."""

from shockpc.cli.entry import entry

if __name__ == "__main__":
    entry()
