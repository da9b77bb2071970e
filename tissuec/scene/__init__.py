"""Module to Scene: names bound, numbers in SI units, presets merged, every finding reported.

Shared arguments:
    declarations: Everything that the program declares.
    program: The modules of the text and its imports.
    main: The module of the text itself.
    constants: Parameters and derived numbers.
    vocabulary: Properties, quantities and rules.
    hedges: Hedges by name.
    tissues: Tissues by lower-case name.
    laws: Laws of tissues by lower-case name.
    known: What is declared, to choose hints from.
    name: The name as written.
    item: Sentence, block or assignment to be read.
    scope: Looks up names of expressions.
    findings: Takes diagnostics.
    code: Code of the diagnostic.
    message: What is wrong.
    span: Place in the text.
    hint: How to fix it.
    notes: Other places that matter.
    dimension: Dimension of the number.
    what: Name in messages.
    example: An example of the right form, for hints.
"""
