"""How loops written in Python become machine code, and how they are called.

Loops are written once, as plain functions of numbers, flat arrays and records of those: in
``kernels``, ``forces`` and the stepping code of ``engine``. They become machine code in four
steps, of which users do only the last two.

1. **Binding** (``binding``). Stepping code calls operations by global names, such as ``force``.
   For a method, it is copied with these names replaced by what the method and the net need;
   one source serves every combination.
2. **Translation** (``export``, ``numba_types``, ``team``; requires Numba). Numba compiles bound
   functions of one bundle to LLVM's intermediate representation, without optimisation and for
   no processor in particular. Products and sums are fused explicitly (``fusing``), and exp,
   log, pow, sin and cos are those of ``mathematics``. References to Python and to Numba's run
   time are removed; they could only be reached by wrong indices. Loops over nodes and springs
   stay functions of their own. The text is compressed into ``shipped``, beside a digest of the
   syntax of all sources (``sources``), which comments and docstrings do not change.
3. **Loading** (``loading``). A run loads the bundles that its scene needs. LLVM optimises them
   for this processor and the object code is kept in the user's cache, under a digest of the
   text, the processor and the version of LLVM. Laws of springs are translated from their
   formulas when they are needed (``laws``).
4. **Calling** (``calls``, ``record_tables``). A record is passed as the address of a table of
   words: numbers, and addresses and shapes of arrays. A function reads the words that it needs
   for, so its code does not depend on what else a scene has. Functions of different bundles
   call each other by addresses in such tables: the operations of a net, the kernels of its
   forces, the laws of its springs. A kernel that is not shipped, as those of other packages,
   is called back as Python through the same address.

All operations are rounded as IEEE 754 says, and LLVM may change none of them. Sums keep the
order of the source, and loops are divided into parts of fixed sizes (``kernels.thread_loops``),
so results do not depend on the processor, on the number of threads or on what is observed.
Interpreted code may round differently. ``TISSUEC_PROCESSOR`` is another processor, by LLVM's
name, for which code is made.

``engine.codegen`` lists the functions of each bundle and writes them all.
"""
