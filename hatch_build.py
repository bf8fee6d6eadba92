"""Put prepared kernels into the wheel: machine code of the laws that ship, for processor levels.

    STICKSLIP_PREPARE=x86-64-v3,x86-64-v4 python -m build --wheel --no-isolation

Each level must be one that this machine has: its kernels run once, to be compiled. Without the
variable the wheel has none, and kernels are compiled where they are first asked for.
"""

from __future__ import annotations

import os
import subprocess
import sys
import sysconfig
import tempfile
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface


class PreparedKernels(BuildHookInterface):  # type: ignore[type-arg]
    """Hatchling's hook: asks one question of each kind at each level, and packs the cache."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Compile for the levels in ``$STICKSLIP_PREPARE``; names the wheel by its machine."""
        levels = os.environ.get("STICKSLIP_PREPARE", "").split(",")
        if version != "standard" or not any(levels):
            return
        self._folder = tempfile.TemporaryDirectory()
        folder = Path(os.path.realpath(self._folder.name))
        for level in levels:
            # Of the level alone: numba would add what else this processor can do.
            machine = {"NUMBA_CPU_NAME": level, "NUMBA_CPU_FEATURES": ""}
            places = {
                "STICKSLIP_CACHE_DIR": str(folder),
                "PYTHONPATH": str(Path(self.root, "src")),
            }
            command = [sys.executable, "-m", "stickslip", "warmup", "--quiet"]
            subprocess.run(command, env={**os.environ, **machine, **places}, check=True)
        for made in filter(Path.is_dir, Path(folder, "numba").iterdir()):
            build_data["force_include"][str(made)] = f"stickslip/prepared/{made.name}"
        build_data["pure_python"] = False
        platform = sysconfig.get_platform().replace("-", "_").replace(".", "_")
        build_data["tag"] = f"cp{sys.version_info[0]}{sys.version_info[1]}-none-{platform}"

    def finalize(self, version: str, build_data: dict[str, Any], artifact_path: str) -> None:
        """Remove the folder once its files are in the wheel."""
        if hasattr(self, "_folder"):
            self._folder.cleanup()
