"""The command about measurements: ``stickslip fit``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Final, Literal

from cyclopts import Parameter

from stickslip.cli.options import (
    OUTPUT,
    Flag,
    ModelOptions,
    Numbers,
    OutputOptions,
    Starts,
    Whole,
    pairs,
)
from stickslip.cli.output import document, draw_pictures, new_folder, note, show_table
from stickslip.cli.process import COMPUTATION_FAILED, DONE, UsageError

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from stickslip.identification.fit import Fit
    from stickslip.mechanics.model.arguments import Model
    from stickslip.mechanics.model.units import Units

FIT_EXAMPLES = """\
stickslip simulate --preset coulomb -d 0.1 --t-end 60 --out run.csv
stickslip fit run.csv --preset coulomb --V 0.037 --parameters mu V
stickslip fit record.csv --model mine.toml --parameters mu speed \\
    --columns "t=time [s]" "x=position [m]" --units m=2 k=800 fs1=4 \\
    --sigma 1e-5 --out fitted
"""
TABLES: Final = ("fit.csv", "fit.json", "model.toml")
PICTURES: Final = ("fit.svg", "fit.pdf", "fit.png")

Words = Annotated[
    tuple[str, ...], Parameter(negative=(), consume_multiple=True, show_default=False)
]
"""Several words after one option."""


def fit(
    records: Annotated[tuple[Path, ...], Parameter(negative=(), metavar="RECORD")],
    /,
    *,
    system: ModelOptions = ModelOptions(),
    parameters: Words,
    columns: Words = (),
    units: Words = (),
    sigma: float | None = None,
    sigma_v: float | None = None,
    speeds: Numbers = (),
    bounds: Words = (),
    priors: Words = (),
    pieces: Whole | None = None,
    loss: Literal["linear", "soft_l1", "huber", "cauchy"] = "linear",
    n_starts: Whole = 1,
    max_evaluations: Whole = 200,
    any_units: Flag = False,
    free_zero: Flag = False,
    x0: Numbers = (),
    v0: Numbers = (),
    d: Starts = (),
    free_start: Flag = False,
    out: Annotated[Path | None, Parameter(group=OUTPUT, metavar="FOLDER")] = None,
    force: Annotated[Flag, Parameter(group=OUTPUT)] = False,
    output: OutputOptions = OutputOptions(),
) -> int:
    """Fit parameters of a model to measurements in CSV files.

    The model is where the search starts. Prints a row for each parameter: its value, standard
    error, 95 per cent interval, and where the search began; what was compared and what the data
    cannot tell is said on stderr. The exit code is 1 if the search has not converged, if the
    model does not tell the data, or the data cannot tell a parameter.

    Parameters
    ----------
    records
        CSV files whose first line names the columns: t with x or v (x_1, x_2, ... of several
        blocks), or speed and force, or d and value (points of the event map).
    parameters
        What to fit, such as mu or V.
    columns
        Columns that are called otherwise: t=time x=position v= (an empty name for none).
    units
        Units of the files, such as SI: m=2 k=800 fs1=4, or `model` for the model file's own;
        numbers are those of the model if not given.
    sigma
        Standard error of a measured value, in the units of the files; without it those of a column
        of that name, or estimated from the scatter about the fit.
    sigma_v
        That of a velocity.
    speeds
        Speed of the belt in each of the files, in their units, where these differ; a column V
        tells it, too.
    bounds
        Ranges to search: mu=0.1:0.9.
    priors
        What is known besides: V=0.2:0.001, mean and standard error.
    pieces
        Cut records into so many pieces, for long or chaotic motions.
    loss
        Least squares, or one that feels outliers less.
    n_starts
        Look at so many values of the parameters first, spread over the bounds.
    max_evaluations
        Of the model, in each approach of the search.
    any_units
        Take data whose size is out of all proportion to the model's motions.
    free_zero
        Sensors of displacements count from unknown places, which are estimated, too.
    x0
        Where all blocks start, in the units of the files: needed where some are not measured, and
        by times of events.
    v0
        Velocities that belong to --x0.
    d
        Instead: the global stick phase that the motion starts from.
    free_start
        The start given is a guess, which is estimated, too.
    out
        Write to this folder: the table (fit.csv), all of the result (fit.json, for
        stickslip.load), the fitted model (model.toml) and a picture (fit.svg, .pdf, .png).
    force
        Replace the files of an earlier run.
    """
    import stickslip as ss

    model = system.model()
    names = _names(columns)
    ranges = pairs("--bounds", bounds, "mu=0.1:0.9", _two)
    known = pairs("--priors", priors, "V=0.2:0.001", _two)
    scales = _units(units, model)
    errors = {"sigma": sigma, "sigma_v": sigma_v}
    settings: dict[str, Any] = {name: value for name, value in errors.items() if value is not None}
    more = {"free_zero": free_zero, "free_start": free_start, "x0": x0, "v0": v0, "d": d}
    settings |= {name: value for name, value in more.items() if value}
    if speeds and len(speeds) != len(records):
        raise UsageError(f"--speeds has {len(speeds)} numbers, and there are {len(records)} files")
    own: list[dict[str, Any]] = [{"V": speed} for speed in speeds] or [{}] * len(records)
    data = [
        ss.read_measurements(path, names, units=scales, **settings, **its)
        for path, its in zip(records, own, strict=True)
    ]

    def found() -> Fit:
        return ss.fit(
            model,
            data,
            parameters,
            bounds=ranges,
            priors=known,
            pieces=pieces,
            loss=loss,
            n_starts=n_starts,
            max_evaluations=max_evaluations,
            check_units=not any_units,
        )

    if out is None:
        fitted = found()
    else:
        with new_folder(out, (*TABLES, *PICTURES), force=force) as files:
            fitted = found()
            _write(fitted, files)
    asked = {"records": list(map(str, records))} | ({"speeds": speeds} if speeds else {})
    _tell(fitted, model, asked, out, output)
    good = fitted.converged and fitted.tells and not fitted.undetermined
    return DONE if good else COMPUTATION_FAILED


def _tell(
    found: Fit, model: Model, more: Mapping[str, Any], out: Path | None, output: OutputOptions
) -> None:
    if output.json:
        laws = [str(law) for law in model.laws]
        asked = {**model.parameters, "friction": laws, **more}
        print(document("fit", asked, found.table()), end="")
    elif out is not None:
        print("\n".join(str(out / name) for name in (*TABLES, *PICTURES)))
    else:
        show_table(found.table())
    for text in (*found.matched, found.misfit_in_words):
        note(text, quiet=output.quiet)
    if found.message != "converged":
        note(found.message, quiet=output.quiet)


def _write(found: Fit, files: Sequence[Path]) -> None:
    """Write table, result, model and pictures."""
    from stickslip.mechanics.model.file import write_model

    found.save(files[0])
    found.save(files[1])
    write_model(found.model, files[2])
    draw_pictures(found.plot, files[3:])


def _names(columns: Sequence[str]) -> dict[str, list[str]]:
    """Names of columns; several blocks have several, with commas between."""
    return {
        name: [each.strip() for each in text.split(",") if each.strip()]
        for name, text in pairs("--columns", columns, "t=time x=position", str).items()
    }


def _two(text: str) -> tuple[float, float]:
    low, high = map(float, text.split(":"))
    return low, high


def _units(given: Sequence[str], model: Model) -> Units | None:
    if not given:
        return None
    if tuple(given) == ("model",):
        own: Units | None = getattr(model, "units", None)
        if own is None:
            raise UsageError("--units model: the model has no [units]; give m=2 k=800 fs1=4")
        return own
    from stickslip.mechanics.model.units import Units

    numbers = pairs("--units", given, "m=2 k=800 fs1=4", float)
    if set(numbers) != {"m", "k", "fs1"}:
        raise UsageError(f"--units {' '.join(given)}: m, k and fs1 are needed: m=2 k=800 fs1=4")
    return Units(**numbers)
