"""Scene to Network and Plan: meshes built, words turned into arrays, sentences into actions.

Shared arguments:
    scene: The resolved scene.
    network: The network so far.
    environment: The environment of the scene.
    tools: Its tools.
    groups: Sets, bodies and joints by name.
    conditions: Reads conditions of the scene.
    body: The body.
    drawing: A body as drawn.
    tables: Tables of the body.
    scope: Looks up names of expressions.
    laws: Laws of springs and dashpots.
    findings: Takes diagnostics.
    span: Place in the text.
"""
