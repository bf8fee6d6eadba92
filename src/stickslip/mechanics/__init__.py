"""Blocks, belt and friction: models, motions and their event map."""
