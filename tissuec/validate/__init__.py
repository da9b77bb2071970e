"""Runs compared with SciPy's solvers on equations of motion that were written independently.

``reference`` and what it is made of (``equations``, ``stepping``, ``crossings``, ``calendar``,
``resting``)
share no arithmetic with the engine; ``observing`` watches the engine, ``compare`` holds the one
against the other, ``validation`` decides, ``report`` gathers and ``telling`` words it.
"""
