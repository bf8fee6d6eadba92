# The public names, listed once: `__init__.py` serves them from here, each when first used.
from . import status as status
from .mechanics.model.two_block import TwoBlock as TwoBlock

__version__: str
