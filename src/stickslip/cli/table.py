"""What the commands share that ask one model and answer with one table."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from cyclopts import Parameter

from stickslip.cli import columns, pictures
from stickslip.cli.files import new_files
from stickslip.cli.options import (
    EngineOptions,
    FileOptions,
    ModelOptions,
    OutputOptions,
    described,
)
from stickslip.files import checked_suffix
from stickslip.results.table import write_table

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from stickslip.study.event_map import EventMap
    from stickslip.study.model_values import Model


@Parameter(name="*")
@dataclass(frozen=True, kw_only=True)
class SystemOptions:
    """A model and how its motions are followed."""

    system: ModelOptions = ModelOptions()
    engine: EngineOptions = EngineOptions()

    def model(self) -> Model:
        """Build the model."""
        return self.system.model()

    def event_map(self, **more: Any) -> EventMap:
        """Build the event map of a model of two blocks, with further settings."""
        import stickslip as ss

        return ss.event_map(self.system.two_blocks(), **self.engine.settings(), **more)

    def described(self, model: Model) -> dict[str, Any]:
        """Everything that was asked for: enough to ask again."""
        return described(model) | self.engine.settings()


@Parameter(name="*")
@dataclass(frozen=True, kw_only=True)
class TableOptions(SystemOptions):
    """A question that one table answers, and where that goes."""

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
        compute: Callable[[], Mapping[str, Any]],
        plot: Callable[[Axes], Axes],
    ) -> Mapping[str, Any]:
        """Compute the table and send it where the options say: a file, stdout, as JSON or CSV.

        The file is opened before the computation: one that cannot be written is said at once.

        Parameters
        ----------
        command : str
            The subcommand.
        model : Model
            What it asks about.
        asked : dict
            Its own options; they stand in the document beside those shared.
        compute : callable
            Returns the columns by name.
        plot : callable
            Draws the answer, once computed, where the file's name is that of a picture.
        """
        if self.file.out is None:
            table = compute()
        else:
            suffix = checked_suffix(self.file.out, ("", ".csv", *pictures.SUFFIXES), "--out")
            with new_files([self.file.out], force=self.file.force) as (temporary,):
                table = compute()
                if suffix in ("", ".csv"):
                    write_table(temporary, table)
                else:
                    pictures.draw(plot, [temporary])
        if self.output.json:
            parameters = self.described(model) | asked
            print(columns.document(command, parameters, table), end="")
        elif self.file.out is None:
            columns.show(table)
        else:
            print(self.file.out)
        return table
