"""``stickslip plot``: a map drawn from the store of a sweep."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from stickslip.cli import pictures
from stickslip.cli.failure import UsageError
from stickslip.cli.files import new_files
from stickslip.cli.options import OUTPUT, Flag, OutputOptions
from stickslip.files import checked_suffix

if TYPE_CHECKING:
    import xarray

EXAMPLES = """\
stickslip plot coulomb.zarr --out map.png
stickslip plot coulomb.zarr --variable lyapunov_exponent \\
    --curve fold.json --out map.pdf
stickslip plot s3://bucket/map --at beta=1.3 --out map.svg
"""


def command(
    store: str,
    *,
    out: Annotated[Path, Parameter(group=OUTPUT)],
    variable: str | None = None,
    at: Annotated[tuple[str, ...], Parameter(negative=(), metavar="NAME=VALUE")] = (),
    curve: Annotated[tuple[Path, ...], Parameter(negative=(), metavar="FILE")] = (),
    force: Annotated[Flag, Parameter(group=OUTPUT)] = False,
    output: OutputOptions = OutputOptions(),
) -> None:
    """Draw a variable of a sweep over two of its axes, finished or not.

    Kinds and periods have a colour each, other numbers a scale that is even to the eye. Curves of
    bifurcations, saved by `continue_bifurcation(...).save(FILE)`, are drawn over the map.

    Parameters
    ----------
    store
        Folder, .zip file or URL of a sweep.
    out
        Write the picture; the name ends in .svg, .pdf or .png.
    variable
        What to draw; by default the first variable of the store.
    at
        The value of an axis that is not drawn, the nearest of those computed; for each.
    curve
        File with a bifurcation curve in the two parameters that are drawn; for each.
    force
        Replace the picture if it exists.
    """
    from stickslip.plot.sweep_map import SweepMap
    from stickslip.study.storage import load
    from stickslip.sweeps.sweep import open_sweep

    checked_suffix(out, pictures.SUFFIXES, "--out")
    curves = tuple(map(load, curve))
    picture = SweepMap(_cut(open_sweep(store), at), variable, curves)
    with new_files([out], force=force) as (temporary,):
        pictures.draw(picture.plot, [temporary])
    if output.json:
        from stickslip.cli import columns

        print(columns.document("plot", {"store": store}, {"file": [str(out)]}), end="")
    else:
        print(out)


def _cut(dataset: xarray.Dataset, at: tuple[str, ...]) -> xarray.Dataset:
    """Choose values of axes, those that were computed nearest to what is asked for."""
    for given in at:
        name, _, value = given.partition("=")
        if name not in dataset.dims or name not in dataset.coords:
            raise UsageError(f"--at {given}: the axes are {', '.join(map(str, dataset.coords))}")
        try:
            number = float(value)
        except ValueError:
            raise UsageError(f"--at {given}: write NAME=VALUE with a number") from None
        dataset = dataset.sel({name: number}, method="nearest")
    return dataset
