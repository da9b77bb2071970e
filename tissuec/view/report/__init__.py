"""A page about one run, made from its result file alone.

``ReportContent`` collects the content as values; each file of ``sections`` writes one part of
the page; ``page`` combines them. ``markup`` turns text into HTML and escapes it.
"""
