"""Options that several subcommands share; the model, the map and the table that they ask for."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from math import inf
from operator import methodcaller
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Final, Literal, TypeVar

from cyclopts import Group, Parameter, Token

from stickslip.cli.output import (
    PICTURE_SUFFIXES,
    document,
    draw_pictures,
    new_files,
    of_file,
    show_table,
)
from stickslip.cli.process import UsageError
from stickslip.files import checked_suffix, write_table

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from stickslip.mechanics.cycle.return_map import LineReturnMap
    from stickslip.mechanics.eventmap.event_map import EventMap
    from stickslip.mechanics.model.arguments import Model

    ModelLine = EventMap | LineReturnMap

Found = TypeVar("Found")

MODEL = Group.create_ordered("Model")
SWEEP = Group.create_ordered("Parameter and range")
ENGINE = Group.create_ordered("Engine")
OUTPUT = Group.create_ordered("Output")

Flag = Annotated[bool, Parameter(negative=(), show_default=False)]
"""A switch that is off; a ``--no-...`` for it would be noise."""

MOST_ROWS: Final = 10**8
"""Of a table: a few gigabytes."""


def _whole(_type: Any, tokens: Sequence[Token]) -> int:
    try:
        return int(tokens[0].value)
    except ValueError:
        from stickslip.checks import shown

        raise ValueError(f"{shown(tokens[0].value)} is not a whole number") from None


Whole = Annotated[int, Parameter(converter=_whole)]
"""A whole number; left to itself the parser takes 1.5 for 2."""


Numbers = Annotated[
    tuple[float, ...], Parameter(negative=(), show_default=False, consume_multiple=True)
]
"""One or several, behind an option that stands once or several times."""
Starts = Annotated[Numbers, Parameter(name=["--d", "-d"])]
"""Relative displacements in global stick."""


def pairs(
    option: str, given: Sequence[str], example: str, read: Callable[[str], Found]
) -> dict[str, Found]:
    """Read NAME=VALUE, each name once; the value by a function that may refuse it."""
    found: dict[str, Found] = {}
    for item in given:
        name, equals, text = (part.strip() for part in item.partition("="))
        if name in found:
            raise UsageError(f"{option} {item}: {name} is given twice")
        try:
            if not (name and equals):
                raise ValueError
            found[name] = read(text)
        except ValueError:
            told = f"{option} {item}: NAME=VALUE is needed, as {option} {example}"
            raise UsageError(told) from None
    return found


def check_equally_spaced(option: str, count: int) -> None:
    """Say so if a count of equally spaced values, both ends included, is none."""
    if not 2 <= count <= MOST_ROWS:
        from stickslip.checks import shown

        told = "both ends count, so at least 2; at most"
        raise UsageError(f"{option} {shown(count)}: {told} {MOST_ROWS}")


@Parameter(name="*", group=MODEL)
@dataclass(frozen=True, kw_only=True)
class ModelOptions:
    """The model: a file, a preset or parameters; parameters change the former two."""

    path: Annotated[Path | None, Parameter(name="--model", metavar="FILE")] = None
    """Model file in TOML; the options below change it."""
    preset: Literal["coulomb", "law9"] | None = None
    """One of the paper's two systems instead of a file."""
    alpha: float | None = None
    """Coupling ratio k12 / k, at least 0."""
    beta: float | None = None
    """Static-friction ratio f_s2 / f_s1, above 0."""
    V: Annotated[float | None, Parameter(name="--V")] = None
    """Driving velocity of the belt, above 0."""
    friction: Annotated[
        tuple[str, ...] | None,
        Parameter(name="--friction", negative=(), metavar="LAW", allow_leading_hyphen=True),
    ] = None
    """Kinetic law, like coulomb:mu=0.22 or "a + (1 - a) * exp(-s), a=0.3"; given several times: one
    for each block."""
    numbers: Annotated[
        tuple[str, ...],
        Parameter(name=["--set", "-p"], negative=(), metavar="NAME=VALUE", show_default=False),
    ] = ()
    """A number of the model by its name, as -p mu=0.3; one that a law's formula leaves open goes
    there."""

    def model(self) -> Model:
        """Build the model; says which options are missing."""
        import stickslip as ss

        numbers = pairs("-p", self.numbers, "mu=0.3", float)
        given: dict[str, Any] = {name: getattr(self, name) for name in ("alpha", "beta", "V")}
        given = {name: value for name, value in given.items() if value is not None}
        if twice := [name for name in given if name in numbers]:
            raise UsageError(f"--{twice[0]} and -p {twice[0]}=... are the same; give one of them")
        if self.friction is not None:
            given["friction"], used = _friction(self.friction, numbers)
            numbers = {name: value for name, value in numbers.items() if name not in used}
        if (model := self._base()) is not None:
            model = model.replace(friction=given.pop("friction")) if "friction" in given else model
            numbers = given | numbers
        else:
            needed = ("alpha", "beta", "V")
            given |= {name: numbers.pop(name) for name in needed if name in numbers}
            if missing := [name for name in (*needed, "friction") if name not in given]:
                raise UsageError(
                    f"the model lacks {', '.join('--' + name for name in missing)}; "
                    "give them, or start from --model FILE, --preset coulomb or --preset law9"
                )
            model = ss.TwoBlock(**given)
        if unknown := [name for name in numbers if name not in model.replaceable]:
            from stickslip.checks import shown
            from stickslip.vocabulary import did_you_mean

            option = f"--{unknown[0]}" if unknown[0] in given else "-p"
            told = f"{option}: {type(model).__name__} has no parameter {shown(unknown[0])}"
            raise UsageError(f"{told}. {did_you_mean(unknown[0], model.replaceable)}")
        return model.replace(**numbers) if numbers else model

    def _base(self) -> Model | None:
        """Return the model to start from, if one is named."""
        if self.path is not None and self.preset is not None:
            raise UsageError("give either --model or --preset")
        if self.path is not None:
            from stickslip.mechanics.model.file import read_model

            with of_file():
                return read_model(self.path)
        if self.preset is not None:
            import stickslip as ss

            preset: Model = getattr(ss.examples, self.preset)()
            return preset
        return None


@Parameter(name="*", group=SWEEP)
@dataclass(frozen=True, kw_only=True)
class SweepOptions:
    """A parameter of the model over a range of its values."""

    parameter: Annotated[str, Parameter(metavar="NAME")]
    """Parameter that varies, such as alpha, beta, V, mu; its own value does not matter."""
    range: Annotated[tuple[float, float], Parameter(negative=())]
    """Its lowest and highest value."""
    window: Annotated[tuple[float, float] | None, Parameter(negative=())] = None
    """Part of the domain to look at; an orbit ends where it leaves this part."""
    max_period: Whole = 4
    """Longest period of the orbits that are searched."""

    @property
    def ends(self) -> tuple[float, float]:
        """The range, checked."""
        low, high = self.range
        if -inf < low < high < inf:
            return self.range
        raise UsageError(f"--range {low} {high}: finite ends are needed, the lower one first")

    def checked(self, f: Any) -> Any:
        """Return the map, of any dimension, if the window suits it."""
        if f.dimension > 1 and self.window is not None:
            raise UsageError("--window is for maps of one number; leave it out")
        return f

    def asked(self) -> dict[str, Any]:
        """Return the options as they stand in a document."""
        names = ("parameter", "range", "window", "max_period")
        return {name: getattr(self, name) for name in names}


@Parameter(name="*", group=ENGINE)
@dataclass(frozen=True, kw_only=True)
class EngineOptions:
    """How motions are followed."""

    engine: Literal["auto", "exact", "adaptive"] = "auto"
    """Closed form where the law allows it, or adaptive steps."""
    rtol: float = 1e-15
    """Local truncation of the adaptive engine."""
    max_events: Whole | None = None
    """Give up on a motion after so many events."""

    def settings(self) -> dict[str, Any]:
        """Return the options as arguments; without a limit the library has its own."""
        settings: dict[str, Any] = {"engine": self.engine, "rtol": self.rtol}
        return settings if self.max_events is None else {**settings, "max_events": self.max_events}


@Parameter(name="*", group=OUTPUT)
@dataclass(frozen=True, kw_only=True)
class OutputOptions:
    """Where results and messages go."""

    json: Flag = False
    """Print one JSON document to stdout; errors too."""
    quiet: Annotated[Flag, Parameter(name=["--quiet", "-q"])] = False
    """No progress and no notes on stderr."""
    verbose: Annotated[Flag, Parameter(name=["--verbose", "-v"])] = False
    """Show the traceback of an error."""

    def tell(
        self, command: str, asked: Mapping[str, Any], result: Mapping[str, Any], text: str
    ) -> None:
        """Print a result, as one JSON document or as text."""
        print(document(command, asked, result) if self.json else text, end="")


@Parameter(name="*", group=OUTPUT)
@dataclass(frozen=True, kw_only=True)
class FileOptions:
    """The file that a table goes to."""

    out: Path | None = None
    """Write a CSV file, or a picture if the name ends in .svg, .pdf or .png."""
    force: Flag = False
    """Replace the file if it exists."""


@Parameter(name="*", group=OUTPUT)
@dataclass(frozen=True, kw_only=True)
class CertificateOptions(FileOptions):
    """The file that a certificate goes to."""

    out: Path | None = None
    """Write the certificate, a JSON file that `stickslip verify` checks."""


def _friction(written: tuple[str, ...], numbers: Mapping[str, float]) -> tuple[Any, set[str]]:
    """Return one law or several, and the names of the numbers that they took."""
    from stickslip.mechanics.friction.values import parse_law, taken

    laws = tuple(parse_law(text, numbers) for text in written)
    used = set[str]().union(*(taken(text, numbers) for text in written))
    return laws[0] if len(laws) == 1 else laws, used


@Parameter(name="*")
@dataclass(frozen=True, kw_only=True)
class SystemOptions:
    """A model and how its motions are followed."""

    system: ModelOptions = ModelOptions()
    engine: EngineOptions = EngineOptions()

    def model(self) -> Model:
        """Build the model."""
        return self.system.model()

    def map(self, **more: Any) -> Any:
        """Build the map of a model, of any dimension, with further settings."""
        from stickslip.mechanics.eventmap.of_model import map_of

        found = map_of(self.model(), **self.engine.settings(), **more)
        if getattr(found, "domain", ()) is None:
            raise UsageError(
                f"the model is a {type(found.model).__name__} of {found.model.size}, whose map has "
                f"{found.dimension} numbers and no bounds within which to search. stickslip cycles "
                "looks for its limit cycles, stickslip simulate follows it in time; in Python "
                "return_map takes a domain"
            )
        return found

    def event_map(self, **more: Any) -> ModelLine:
        """Build the map of a model that has one of the line, with further settings."""
        found = self.map(**more)
        if found.dimension > 1:
            raise UsageError(
                "this command asks about a map of one number, such as d = X_2 - X_1 of two blocks "
                f"or the phase of a shaken one; the model is a {type(found.model).__name__} of "
                f"{found.model.size}, whose map has {found.dimension}. stickslip orbits, "
                "basins, bifurcations and diagram take it; stickslip simulate follows any model "
                "in time"
            )
        line: ModelLine = found
        return line

    def described(self, model: Model) -> dict[str, Any]:
        """Everything that was asked for: enough to repeat the question."""
        laws = model.friction if isinstance(model.friction, tuple) else (model.friction,)
        named = {**model.parameters, "friction": [str(law) for law in laws]}
        return named | self.engine.settings()


def _plotted(found: Any, ax: Axes) -> Any:
    return found.plot(ax)


@Parameter(name="*")
@dataclass(frozen=True, kw_only=True)
class TableOptions(SystemOptions):
    """A question that one table answers, and where the table goes."""

    file: FileOptions = FileOptions()
    output: OutputOptions = OutputOptions()

    @property
    def quiet(self) -> bool:
        """Whether nothing is to be said beside the result."""
        return self.output.quiet

    def deliver(
        self,
        command: str,
        model: Model,
        asked: dict[str, Any],
        compute: Callable[[], Found],
        *,
        table: Callable[[Found], Mapping[str, Any]] = methodcaller("table"),
        plot: Callable[[Found, Axes], Axes] = _plotted,
    ) -> Found:
        """Compute a result; send its table where the options say: a file, stdout, JSON or CSV."""
        # The file is opened before the computation: one that cannot be written is said at once.
        # What was `asked`, the command's own options, stands in the document beside the options
        # shared.
        if self.file.out is None:
            found = compute()
            columns = table(found)
        else:
            suffix = checked_suffix(self.file.out, ("", ".csv", *PICTURE_SUFFIXES), "--out")
            with new_files([self.file.out], force=self.file.force) as (temporary,):
                found = compute()
                columns = table(found)
                if suffix in ("", ".csv"):
                    write_table(temporary, columns)
                else:
                    draw_pictures(partial(plot, found), [temporary])
        if self.output.json:
            parameters = self.described(model) | asked
            print(document(command, parameters, columns), end="")
        elif self.file.out is None:
            show_table(columns)
        else:
            print(self.file.out)
        return found
