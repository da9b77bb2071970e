"""Independent check of a run with SciPy.

``reference`` solves the plan with equations of its own: ``equations``, ``stepping``,
``crossings``, ``event_queue`` and ``resting`` share no arithmetic with the engine.
``engine_run`` samples the engine, ``compare`` measures the differences, ``validation`` combines
all of it, decides and explains, and ``report`` shows it.
"""
