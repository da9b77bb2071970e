"""Arithmetic on bare arrays and SI numbers, and its machine code.

Operations are plain loops; those of forces stand in ``forces``. ``engine.codegen`` translates
them into LLVM's intermediate representation, which stands in ``shipped``. ``loading``
optimises that for this processor, once, and keeps it in the user's cache; ``compiled_laws``
translates laws of springs where a scene has some. Stepping code is written once against names
of operations. Where it runs as Python itself, ``engine.backends`` lets it call compiled ones.
"""
