"""Answers to editors: pure functions from a text and a place to plain data.

    lexemes     a text, right or wrong, as words, numbers and signs
    structure   its statements, and the blocks around each
    phrases     what each word of a statement is there for, and what could stand in its place
    desk        open texts, and what is known of each
    views       what the names in a text stand for

``findings``, ``hover``, ``completion``, ``navigation``, ``colours`` and ``layout`` answer from
these; ``server`` alone knows the protocol. Nothing here fails on a text that is half typed.
``highlighting`` and ``folder`` make the files that highlight texts without a server.
"""
