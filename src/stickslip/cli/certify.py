"""``stickslip certify``: prove an orbit, a bifurcation, a jump or a complete list."""

from __future__ import annotations

from contextlib import ExitStack

from stickslip.cli.failure import DONE, ComputationError, UsageError
from stickslip.cli.files import new_files
from stickslip.cli.options import FileOptions, ModelOptions, OutputOptions, Whole
from stickslip.files import checked_suffix

EXAMPLES = """\
stickslip certify --preset coulomb --orbit 0.27739 --period 4 --out S4.json
stickslip certify --preset coulomb --jump 0.279135
stickslip certify --preset coulomb --V 0.036976 --border V \\
    --orbit 0.27943 --period 4
stickslip certify --preset law9 --alpha 1.209859796 --flip alpha \\
    --orbit 0.38274245 --digits 12
stickslip certify --preset coulomb --max-period 1 --json
"""


def command(
    *,
    model: ModelOptions = ModelOptions(),
    orbit: float | None = None,
    period: Whole = 1,
    border: str | None = None,
    flip: str | None = None,
    fold: str | None = None,
    jump: float | None = None,
    max_period: Whole | None = None,
    digits: Whole = 30,
    file: FileOptions = FileOptions(),
    output: OutputOptions = OutputOptions(),
) -> int:
    """Prove in ball arithmetic what floating point found; the numbers given count exactly.

    Prints the theorem and its enclosures, or why nothing is proven; then the exit code is 1.
    `--out` and `--json` give the certificate that `stickslip verify` checks again.

    Parameters
    ----------
    orbit
        Prove the periodic orbit through a point near this d.
    period
        Its period.
    border
        Prove instead that this orbit reaches a jump as this parameter varies, near the model's
        own value of it.
    flip
        Prove instead that the multiplier of this orbit passes -1 as this parameter varies.
    fold
        Prove instead that this orbit meets another one and vanishes as this parameter varies.
    jump
        Prove the jump of the map near this d.
    max_period
        Prove the complete list of periodic orbits up to this period.
    digits
        Significant digits of the enclosures.
    """
    from stickslip.proofs import certify

    asked = [value is not None for value in (orbit, jump, max_period)]
    if sum(asked) != 1:
        raise UsageError("give one of --orbit, --jump and --max-period")
    kinds = {"border_collision": border, "flip": flip, "fold": fold}
    varied = {kind: name for kind, name in kinds.items() if name is not None}
    if len(varied) > 1:
        raise UsageError("give one of --border, --flip and --fold")
    if varied and orbit is None:
        raise UsageError("--border, --flip and --fold need the orbit: --orbit D --period P")
    system = model.two_blocks()
    with ExitStack() as stack:
        files = []
        if file.out is not None:
            checked_suffix(file.out, ("", ".json"), "--out")
            files = stack.enter_context(new_files([file.out], force=file.force))
        if jump is not None:
            proof = certify.certify_jump(system, jump, digits=digits)
        elif max_period is not None:
            proof = certify.certify_orbits(system, max_period, digits=digits)
        elif orbit is not None and varied:
            ((kind, name),) = varied.items()
            proof = certify.certify_bifurcation(system, kind, orbit, period, name, digits=digits)
        else:
            assert orbit is not None
            proof = certify.certify_orbit(system, orbit, period, digits=digits)
        if not proof:
            raise ComputationError(proof.statement)
        for path in files:
            proof.save(path)
    print(proof.text() if output.json else f"{proof}\n", end="")
    return DONE
