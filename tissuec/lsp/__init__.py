"""Answers to editors: pure functions from a text and a position to plain data.

    tokens      a text, correct or not, as words, numbers and signs
    structure   its statements, and the blocks around each
    context     the role of each word of a statement, and what is allowed in its place
    documents   open texts, and what is known of each
    views       what the names in a text refer to

``findings``, ``hover``, ``completion``, ``navigation``, ``semantic_tokens`` and ``positions``
answer from these; only ``server`` knows the protocol. Nothing here fails on a text that is
incomplete. ``highlighting`` and ``vscode`` write the files of editors that highlight texts
without a server.
"""
