"""``stickslip verify``: check a certificate again with a second, smaller program."""

from __future__ import annotations

import sys
from pathlib import Path

from stickslip.cli import columns
from stickslip.cli.failure import CLAIM_FAILED, DONE
from stickslip.cli.options import OutputOptions
from stickslip.files import read_text

EXAMPLES = """\
stickslip verify S4.json
"""


def command(certificate: Path, /, *, output: OutputOptions = OutputOptions()) -> int:
    """Check a certificate that `stickslip certify` wrote; exit code 4 if it does not hold.

    The program that checks shares nothing with the one that proves but the ball arithmetic. It
    proves every word of the statement that it prints. What it does not prove, the mechanism of a
    jump, is quoted apart.

    Parameters
    ----------
    certificate
        The file.
    """
    from stickslip.proofs.verify.check import check_text
    from stickslip.proofs.verify.words import Refused

    reason = ""
    try:
        checked = check_text(read_text(certificate))
        told = {"statement": [checked.statement()], "unproven": [checked.remark]}
    except Refused as error:
        reason = str(error)
        told = {"reason": [reason]}
    if output.json:
        result = {"holds": [not reason], **told}
        print(columns.document("verify", {"certificate": str(certificate)}, result), end="")
    elif reason:
        print(f"refused: {reason}", file=sys.stderr)
    else:
        print(f"holds: {checked.statement()}")
        if checked.remark:
            print(f"not checked, the certifier's words for the jump: {checked.remark!r}")
    return CLAIM_FAILED if reason else DONE
