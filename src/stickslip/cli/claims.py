"""Commands that prove or check: ``stickslip certify``, ``verify``, ``reproduce`` and ``study``."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import ExitStack
from functools import partial
from math import isfinite
from pathlib import Path
from typing import Annotated, Any, Final

from cyclopts import Parameter

from stickslip.cli.options import (
    OUTPUT,
    CertificateOptions,
    Flag,
    ModelOptions,
    OutputOptions,
    Whole,
)
from stickslip.cli.output import document, new_files, tracked
from stickslip.cli.process import CLAIM_FAILED, DONE, ComputationError, UsageError
from stickslip.files import checked_suffix, read_text
from stickslip.vocabulary import did_you_mean

SPOKEN: Final = {"share": "--basins", "at_least": "--entropy"}
"""Options of `certify` that Python has as arguments of functions of their own."""
CERTIFY_EXAMPLES = """\
stickslip certify --preset coulomb --orbit 0.27739 --period 4 --out S4.json
stickslip certify --preset coulomb --jump 0.279135
stickslip certify --preset coulomb --V 0.036976 --border V \\
    --orbit 0.27943 --period 4
stickslip certify --preset law9 --alpha 1.209859796 --flip alpha \\
    --orbit 0.38274245 --digits 12
stickslip certify --preset coulomb --orbit 0.27739 --period 4 \\
    --along V --range 0.0366 0.0372
stickslip certify --preset coulomb --max-period 1 --json
stickslip certify --preset coulomb --max-period 1 \\
    --along V --range 0.0366 0.0372
stickslip certify --preset coulomb --basins 0.99 --out basins.json
stickslip certify --alpha 3.007 --beta 0.6146 --V 0.0199 \\
    --friction coulomb:mu=0.542 --entropy 0.6
stickslip certify --alpha 3.1 --beta 1.26 --V 0.065 \\
    --friction coulomb:mu=0.061 --chaos 0.27 --out chaos.json
"""

CLAIM_FIELDS = ("key", "figure", "statement", "verdict", "evidence")
STANDS = {"holds", "holds with a correction"}


def certify(
    *,
    model: ModelOptions = ModelOptions(),
    orbit: float | None = None,
    period: Whole | None = None,
    border: str | None = None,
    flip: str | None = None,
    fold: str | None = None,
    along: str | None = None,
    range: Annotated[tuple[float, float] | None, Parameter(negative=())] = None,
    jump: float | None = None,
    max_period: Whole | None = None,
    basins: float | None = None,
    entropy: float | None = None,
    chaos: float | None = None,
    digits: Whole | None = None,
    file: CertificateOptions = CertificateOptions(),
    output: OutputOptions = OutputOptions(),
) -> int:
    """Prove in ball arithmetic what floating point found, for parameters exactly as written.

    Prints the theorem and its enclosures, or why nothing is proven; then the exit code is 1.
    `--out` and `--json` give the certificate that `stickslip verify` checks again. Orbits of a map
    of your own are proven in Python: `ss.certify_orbits(ss.PiecewiseMap("r*x*(1 - x)", ...))`.

    Parameters
    ----------
    orbit
        Prove the periodic orbit through a point near this d.
    period
        Its period, 1 if not given.
    border
        Prove instead that this orbit reaches a jump as this parameter varies, near the model's
        own value of it.
    flip
        Prove instead that the multiplier of this orbit passes -1 as this parameter varies.
    fold
        Prove instead that this orbit meets another one and vanishes as this parameter varies.
    along
        Prove it for every value of this parameter in a range: that an orbit exists, alone in a
        tube, or up to where it is lost at a jump, and that it is lost there; a list; basins.
    range
        The lowest and highest value; the model's own is between them if an orbit is followed.
    jump
        Prove the jump of the map near this d.
    max_period
        Prove the complete list of periodic orbits up to this period.
    basins
        Prove which starts tend to which orbits, for at least this share of the domain.
    entropy
        Prove chaos of some orbits: that the topological entropy of the map is at least this.
    chaos
        Prove chaos of all: that the orbit of this d stays where every orbit is unstable.
    digits
        Significant digits of the enclosures, 30 if not given; those that are computed with, or 12,
        for --basins, --entropy and --chaos.
    """
    from stickslip.mechanics.model.arguments import two_blocks
    from stickslip.proofs import certify

    options = {"--border": border, "--flip": flip, "--fold": fold, "--along": along}
    named = [(option, name) for option, name in options.items() if name is not None]
    if len(named) > 1:
        raise UsageError("give one of --border, --flip, --fold and --along")
    if named and along is None and orbit is None:
        raise UsageError(f"{named[0][0]} needs the orbit: --orbit D --period P")
    asked = [value is not None for value in (orbit, jump, max_period, basins, entropy, chaos)]
    if sum(asked) != 1:
        raise UsageError(
            "give one of --orbit, --jump, --max-period, --basins, --entropy and --chaos"
        )
    for option, d in (("--orbit", orbit), ("--jump", jump), ("--chaos", chaos)):
        if d is not None and not isfinite(d):
            raise UsageError(f"{option} {d}: a finite number is needed")
    if period is not None and orbit is None:
        raise UsageError("--period goes with --orbit")
    if along is not None and all(each is None for each in (orbit, max_period, basins)):
        raise UsageError("--along goes with --orbit, --max-period or --basins alone")
    if (along is None) != (range is None):
        raise UsageError("--along and --range go together: --along V --range 0.0366 0.0372")
    period = 1 if period is None else period
    precise: dict[str, Any] = {} if digits is None else {"digits": digits}
    why = "Proofs are about two equal blocks without damping."
    system = two_blocks(model.model(), why=why)
    for option, name in named:
        if name not in system.parameters:
            known = did_you_mean(name, system.parameters)
            raise UsageError(f"{option} {name}: the model has no such parameter. {known}")
    with ExitStack() as stack:
        files = []
        if file.out is not None:
            checked_suffix(file.out, ("", ".json"), "--out")
            files = stack.enter_context(new_files([file.out], force=file.force))
        if jump is not None:
            proof = certify.certify_jump(system, jump, **precise)
        elif max_period is not None:
            proof = certify.certify_orbits(system, max_period, along=along, range=range, **precise)
        elif basins is not None:
            proof = certify.certify_basins(system, basins, along=along, range=range, **precise)
        elif entropy is not None:
            proof = certify.certify_entropy(system, entropy, **precise)
        elif chaos is not None:
            proof = certify.certify_chaos(system, chaos, **precise)
        elif orbit is not None and along is not None and range is not None:
            proof = certify.certify_branch(system, orbit, period, along, range, **precise)
        elif orbit is not None and named:
            ((option, name),) = named
            kind = "border_collision" if option == "--border" else option.removeprefix("--")
            proof = certify.certify_bifurcation(system, kind, orbit, period, name, **precise)
        else:
            assert orbit is not None
            proof = certify.certify_orbit(system, orbit, period, **precise)
        if not proof:
            raise ComputationError(proof.statement)
        for path in files:
            proof.save(path)
    print(proof.text() if output.json else f"{proof}\n", end="")
    return DONE


VERIFY_EXAMPLES = """\
stickslip verify S4.json
"""


def verify(certificate: Path, /, *, output: OutputOptions = OutputOptions()) -> int:
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
        print(document("verify", {"certificate": str(certificate)}, result), end="")
    elif reason:
        print(f"refused: {reason}", file=sys.stderr)
    else:
        print(f"holds: {checked.statement()}")
        if checked.remark:
            print(f"not checked, the certifier's words for the jump: {checked.remark!r}")
    return CLAIM_FAILED if reason else DONE


REPRODUCE_EXAMPLES = """\
stickslip reproduce
stickslip reproduce 5 17 --out figures
stickslip reproduce --check
"""


def reproduce(
    *figures: Whole,
    out: Annotated[Path, Parameter(group=OUTPUT)] = Path("out"),
    check: Flag = False,
    output: OutputOptions = OutputOptions(),
) -> int:
    """Compute figures of Galvanetto (2001), and check what the paper prints and claims.

    Writes figNN.svg, .pdf and .png, values.json and values.md, report.json and report.md,
    and replaces those of an earlier run; other files in the folder stay. Prints their names,
    then a line for each claim that belongs to the figures: does it hold, and if not, why.

    Parameters
    ----------
    figures
        Numbers of figures; all that there are if not given.
    out
        Folder to write to; made if it is not there.
    check
        Exit with code 4 unless every claim holds, as it is printed or with a correction.
    """
    from stickslip.studies.sources import GALVANETTO

    return _deliver("reproduce", GALVANETTO, figures, out, check=check, output=output)


def _deliver(
    command: str,
    source: str,
    figures: tuple[int, ...],
    out: Path,
    *,
    check: bool,
    output: OutputOptions,
) -> int:
    """Compute a study, write its files, and print what became of its claims."""
    from stickslip import studies

    _check_folder(out, "figures")

    track = partial(tracked, what="figures")
    done = studies.reproduce(figures or None, out, source=source, track=track)
    written = [str(path) for path in done.files]
    claims = done.report.claims
    result = {"file": written}
    result |= {name: [getattr(claim, name) for claim in claims] for name in CLAIM_FIELDS}
    asked = {} if command == "reproduce" else {"name": source}
    text = "\n".join(written) + (f"\n\n{done.report.text()}" if claims else "\n")
    output.tell(command, {**asked, "figures": figures}, result, text)
    failed = any(claim.verdict not in STANDS for claim in claims)
    return CLAIM_FAILED if check and failed else DONE


def _check_folder(out: Path, what: str) -> None:
    if out.exists() and not out.is_dir():
        raise UsageError(f"--out {out} is a file; {what} go to a folder")


STUDY_EXAMPLES = """\
stickslip study --list
stickslip study leine1998
stickslip study quasistatic 1 --out figures --check
stickslip study galvanetto2001 --proven
"""


def study(
    name: str | None = None,
    *figures: Whole,
    list: Flag = False,
    proven: Flag = False,
    out: Annotated[Path | None, Parameter(group=OUTPUT)] = None,
    check: Flag = False,
    output: OutputOptions = OutputOptions(),
) -> int:
    """Compute a study of the literature: figures, and published numbers beside computed ones.

    Writes figNN.svg, .pdf and .png, values.json and values.md, report.json and report.md,
    and replaces those of an earlier run; other files in the folder stay. Prints their names,
    then a line for each claim: does it hold, and if not, why.

    Parameters
    ----------
    name
        Of the study.
    figures
        Numbers of figures; all that there are if not given.
    list
        List the studies instead.
    proven
        Prove the study's bifurcation diagram instead: certificates that `stickslip verify` checks,
        a table of what is proven and what is not, and a picture, in out/NAME-proven. Takes minutes.
    out
        Folder to write to, out/NAME if not given; made if it is not there.
    check
        Exit with code 4 unless every claim holds, as it is stated or with a correction; or unless
        all parts are proven.
    """
    from stickslip import studies

    if list:
        known = studies.sources()
        rows = {
            field: [getattr(item, field) for item in known] for field in ("name", "source", "title")
        }
        lines = (f"{item.name:16s}  {item.source}: {item.title}\n" for item in known)
        output.tell("study", {}, rows, "".join(lines))
        return DONE
    if name is None:
        raise UsageError("name a study; stickslip study --list names them all")
    if proven:
        if figures:
            raise UsageError("--proven takes no figure numbers: it is about one diagram")
        return _prove(name, out or Path("out") / f"{name}-proven", check=check, output=output)
    folder = out or Path("out") / name
    return _deliver("study", name, figures, folder, check=check, output=output)


def _prove(name: str, out: Path, *, check: bool, output: OutputOptions) -> int:
    """Prove a study's diagram, one part after the other, and print what is proven and what not."""
    from stickslip.studies import proven

    _check_folder(out, "certificates")

    def track(proofs: Iterator[proven.Proof]) -> Iterator[proven.Proof]:
        for each in proofs:
            if not output.quiet:
                print(each.text(), file=sys.stderr)
            yield each

    done = proven.prove(name, out, track=track)
    result = {
        "file": [str(path) for path in done.files],
        "part": [each.name for each in done.proofs],
        "proven": [bool(each.certificate) for each in done.proofs],
        "from": [float(each.low) for each in done.proofs],
        "to": [float(each.high) for each in done.proofs],
        "what": [each.what for each in done.proofs],
        "not_proven": [*done.unproven],
    }
    output.tell("study", {"name": name, "proven": True}, result, done.text())
    failed = not all(each.certificate for each in done.proofs)
    return CLAIM_FAILED if check and failed else DONE
