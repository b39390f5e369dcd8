"""The program ``host-sim``, also as ``python -m bonebeam``."""

import sys

from . import _native


def main() -> int:
    """Runs the program on the arguments of the process; returns its exit status."""
    return _native.main(["host-sim", *sys.argv[1:]])


if __name__ == "__main__":
    sys.exit(main())
