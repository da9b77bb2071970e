"""What the project measures of itself: speed, errors, and where runs may fail.

``python -m benchmarks`` lists the benchmarks; ``python -m benchmarks.NAME`` runs one, in the
folder of the repository.
"""

from tissuec.cli.bench import use_one_thread

use_one_thread()  # before NumPy is loaded
