# The public names, listed once: `__init__.py` serves them from here, each when first used.
from . import examples as examples
from . import status as status
from .analysis.piecewise_map import PiecewiseMap as PiecewiseMap
from .mechanics.cycle.continuation import continue_cycle as continue_cycle
from .mechanics.cycle.equilibria import equilibria as equilibria
from .mechanics.cycle.search import find_cycle as find_cycle
from .mechanics.cycle.stroboscopic import stroboscopic_map as stroboscopic_map
from .mechanics.flow.trajectory import simulate as simulate
from .mechanics.friction import Coulomb as Coulomb
from .mechanics.friction import FrictionLaw as FrictionLaw
from .mechanics.friction import PoppStelter as PoppStelter
from .mechanics.friction import Stribeck as Stribeck
from .mechanics.friction import friction_law as friction_law
from .mechanics.model.blocks import Blocks as Blocks
from .mechanics.model.chain import Chain as Chain
from .mechanics.model.chain import Oscillator as Oscillator
from .mechanics.model.harmonic import Harmonic as Harmonic
from .mechanics.model.two_block import TwoBlock as TwoBlock
from .mechanics.model.units import Units as Units
from .study.bifurcations import bifurcations as bifurcations
from .study.bifurcations import continue_bifurcation as continue_bifurcation
from .study.bifurcations import continue_breakpoint as continue_breakpoint
from .study.bifurcations import continue_orbit as continue_orbit
from .study.diagram import bifurcation_diagram as bifurcation_diagram
from .study.event_map import event_map as event_map
from .study.maps import attractors as attractors
from .study.maps import basins as basins
from .study.maps import branches as branches
from .study.maps import breakpoints as breakpoints
from .study.maps import invariant_density as invariant_density
from .study.maps import lyapunov_exponent as lyapunov_exponent
from .study.maps import periodic_orbits as periodic_orbits
from .study.model_file import read_model as read_model
from .study.model_file import write_model as write_model
from .study.storage import load as load

__version__: str
