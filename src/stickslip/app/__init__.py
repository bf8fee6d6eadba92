"""The explorer: a local web server whose page shows a model's map, motions and bifurcations.

Needs the extra ``app`` (starlette, uvicorn, websockets). The page is in ``static``; everything it
shows is computed by the package's public functions.
"""

EXTRA = ("starlette", "uvicorn", "websockets")
