"""Results in files, of models and of maps."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from stickslip.analysis.maps.protocol_nd import MapND
from stickslip.mechanics.model.belt_model import BeltModel
from stickslip.mechanics.model.two_block import TwoBlock
from stickslip.results.files import load as _load
from stickslip.results.files import register_part
from stickslip.study import quasistatic  # noqa: F401 (registers its maps)
from stickslip.study.event_map import event_map
from stickslip.study.maps import as_map
from stickslip.study.model_values import model_of_values, model_values

if TYPE_CHECKING:
    import os


def load(path: str | os.PathLike[str], system: Any = None) -> Any:
    """Read a result from a file that `save`, or the ``save`` of a result, has written.

    Parameters
    ----------
    path : str or path
    system : model or map, optional
        What the result is one of, where no file can hold that: a `PiecewiseMap`, or a model
        with a friction law of the user's own. Parameter values are taken from the file.

    Returns
    -------
    object
        Equal to what was saved. A map that the file does not hold and that is not given
        is None: the numbers are there, but nothing can be solved anew.

    Raises
    ------
    ValueError
        The file is none of this program's, or of a newer version of it; or ``system`` has
        other parameters than that of the file.
    OSError
        The file cannot be read.
    """
    if isinstance(system, BeltModel):
        system = event_map(system)
    f: Any = system if system is None or isinstance(system, MapND) else as_map(system, "system")
    return _load(path, f)


register_part("model", (TwoBlock, BeltModel), model_values, model_of_values)
