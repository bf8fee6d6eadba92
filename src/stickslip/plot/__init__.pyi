# The public pictures, served by `__init__.py`, each loaded when first used.
from .animation import film as film
from .breaks import mechanism as mechanism
from .law import friction_characteristic as friction_characteristic
from .locus import stick_locus as stick_locus
from .locus import trajectory_in_plane as trajectory_in_plane
from .maps import cobweb as cobweb
from .maps import event_map as event_map
from .maps import mark_orbit as mark_orbit
from .motion import phase_portrait as phase_portrait
from .motion import time_series as time_series
from .sweep_map import sweep as sweep
