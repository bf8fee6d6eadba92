"""The explorer: a local web server whose page shows a model's map, motions and bifurcations.

Needs the extra ``app``. The page, in ``static``, shows what the public functions compute.
"""

EXTRA = ("starlette", "uvicorn", "websockets")
