"""Tables of numbers as text: separators, columns, and units in the names of columns.

Shared arguments:
    dialect: Separators of the table and where its rows begin.
    text: The text of the table.
"""
