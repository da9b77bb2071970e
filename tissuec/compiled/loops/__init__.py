"""Loops around what follows from one item, as LLVM's intermediate representation."""
