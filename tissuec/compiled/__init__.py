"""Compiled code: kernels as they are shipped, made into machine code for this processor.

``tissuec.building`` translates kernels into LLVM's intermediate representation, which stands in
``shipped``. Here it is optimised for the processor, once, and kept in the user's cache; laws of
springs are translated where a scene has some.
"""
