"""``stickslip verify``: check a certificate again with a second, smaller program."""

from __future__ import annotations

import sys
from pathlib import Path

from stickslip.cli import columns
from stickslip.cli.failure import CLAIM_FAILED, DONE
from stickslip.cli.options import OutputOptions

EXAMPLES = """\
stickslip verify S4.json
"""


def command(certificate: Path, /, *, output: OutputOptions = OutputOptions()) -> int:
    """Check a certificate that `stickslip certify` wrote; exit code 4 if it does not hold.

    The program that checks shares nothing with the one that proves but the ball arithmetic.

    Parameters
    ----------
    certificate
        The file.
    """
    from stickslip.proofs.verify.check import Refused, check_text

    try:
        holds, told = True, check_text(certificate.read_text(encoding="utf-8"))
    except (Refused, UnicodeDecodeError) as error:
        holds, told = False, str(error)
    if output.json:
        result = {"holds": [holds], "statement" if holds else "reason": [told]}
        print(columns.document("verify", {"certificate": str(certificate)}, result), end="")
    else:
        print(f"holds: {told}" if holds else f"refused: {told}", file=None if holds else sys.stderr)
    return DONE if holds else CLAIM_FAILED
