"""The command line as ``python -m stickslip``."""

from stickslip.cli import main

main()
