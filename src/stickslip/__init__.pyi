# The public names, listed once: `__init__.py` serves them from here, each when first used.
from . import examples as examples
from . import status as status
from .analysis.piecewise_map import PiecewiseMap as PiecewiseMap
from .mechanics.eventmap.event_map import event_map as event_map
from .mechanics.flow.trajectory import simulate as simulate
from .mechanics.friction import Coulomb as Coulomb
from .mechanics.friction import FrictionLaw as FrictionLaw
from .mechanics.friction import PoppStelter as PoppStelter
from .mechanics.friction import Stribeck as Stribeck
from .mechanics.friction import friction_law as friction_law
from .mechanics.model.two_block import TwoBlock as TwoBlock

__version__: str
