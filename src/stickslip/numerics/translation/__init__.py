"""Kernels into LLVM's code, straight from their text."""
