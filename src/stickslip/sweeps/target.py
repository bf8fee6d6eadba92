"""What results depend on besides their description: kernels, and the kind of machine."""

from __future__ import annotations

import platform
from functools import cache
from typing import Any

from llvmlite import binding

from stickslip.numerics.gpu import gpu_name
from stickslip.numerics.targets import config, source_hash


@cache
def _cpu() -> tuple[str, str]:
    name = config.CPU_NAME or binding.get_host_cpu_name()
    features = config.CPU_FEATURES
    if features is None:
        features = binding.get_host_cpu_features().flatten()
    return str(name), ",".join(part for part in sorted(features.split(",")) if part[:1] == "+")


def target(device: str = "cpu") -> dict[str, str]:
    """Tell what compiled code this process runs, and for which processor or GPU."""
    # ``features`` are those that code may use, so also what NUMBA_CPU_NAME and NUMBA_CPU_FEATURES
    # set; ``kernels`` is a hash over the sources of all kernels and the version of the compiler.
    if device == "cuda":
        return {
            "device": device,
            "machine": platform.machine(),
            "gpu": gpu_name(),
            "kernels": source_hash(),
        }
    name, features = _cpu()
    return {
        "device": device,
        "machine": platform.machine(),
        "cpu": name,
        "features": features,
        "kernels": source_hash(),
    }


def difference(stored: dict[str, Any], here: dict[str, str]) -> str:
    """Tell in words where two targets differ; empty if they do not."""
    if stored.get("device") != here["device"]:
        return f"device {stored.get('device')} there, {here['device']} here"
    told = []
    for key in here:
        if stored.get(key) == here[key]:
            continue
        if key == "features":
            theirs, ours = (set(str(each).split(",")) for each in (stored.get(key), here[key]))
            change = " ".join(sorted(f"-{x[1:]}" for x in theirs - ours) + sorted(ours - theirs))
            told.append(f"processor features {change}")
        else:
            told.append(f"{key} {stored.get(key)} there, {here[key]} here")
    return "; ".join(told)
