"""A page about one run, made from its result file alone.

``ReportContent`` collects the content as values; ``head`` and a file for each ``Section`` write
the parts of the page; ``page`` combines them. ``markup`` turns text into HTML and escapes it.
"""
