"""What words of the language mean that no schema describes, one sentence each.

Entries that are fields of a class are described there, and verbs, measures, meshes, tools,
laws and methods in their docstrings. The reference and editors show both.
"""

#: What a text is made of.
PARTS = {
    "use": "Takes in what another file declares: a vocabulary, tissues, or a whole scene.",
    "about": "Says in one sentence what the file shows.",
    "hedge": "A word before other words that moves them along their scale, or sharpens them.",
    "property": "What a tissue is described with: a range, and the words for its parts.",
    "quantity": "What rules conclude: a range of a physical quantity, and words for its parts.",
    "rules": "Rules that conclude words of quantities from words of properties.",
    "law": "Laws of springs and dashpots that rows of a table can name.",
    "tissue": "What springs and nodes are made of, in words of a vocabulary, numbers or both.",
    "body": "A mesh made of tissue.",
    "joint": "Springs between bodies, by which they hang on one another or are sewn together.",
    "tool": "An instrument that holds, touches or cuts.",
    "force": "A force on nodes beside springs, such as that of tissue around a body.",
    "learn": "What is learnt from measured data: numbers of tissues, nodes, springs or words.",
    "environment": "What acts everywhere: gravity, contact, damping.",
    "script": "What happens when: times and conditions with orders.",
    "simulate": "How long the run is and how its motion is computed.",
    "output": "What the result file holds.",
    "param": "A number that can be set on the command line, perhaps within limits.",
    "let": "A number that is computed from others.",
    "set": "A name for nodes or springs, chosen on the drawn mesh and fixed for good.",
    "table": "Nodes or springs of an explicit mesh, one in each row.",
    "expect": "What should come out; whatever does not hold is reported after the run.",
}

#: Entries of blocks beside those of a schema, by what the block is.
ENTRIES = {
    "tissue": {
        "about": "Says in one sentence what the tissue is, and where its numbers are from.",
        "described": "Names the rules that know the words of this tissue: described in RULES.",
        "known": "Evidence: what a source says of a quantity, as a range or a number.",
        "spring law": "What replaces the linear springs, by name.",
        "viscosity law": "What replaces the linear dashpots, by name.",
        "spring force": "A formula for the force of a spring of its elongation e.",
        "stress": "A formula for the nominal stress of a bar of its strain.",
        "viscous force": "A formula for the force of a dashpot of its speed w of lengthening, "
        "or of its elongation e and w.",
    },
    "body": {
        "mesh": "Where nodes and springs are.",
        "tissue": "What the body is made of.",
        "region": "A part of the body with a tissue or a prestress of its own.",
        "springs": "Springs with a tissue of their own: springs where CONDITION { … }.",
        "rupture": "Whether springs break beyond their fraction force.",
        "bending": "How a surface resists folding: by springs, or as a wall of its thickness.",
        "fibres": "Along which direction a tissue with a fibre modulus is stiffer.",
    },
    "region": {
        "tissue": "What the region is made of; without it, of what the body is.",
        "prestress": "By which part the springs of the region are drawn too long.",
    },
    "interface": {
        "tissue": "What the springs between two regions are made of.",
        "prestress": "By which part they are drawn too long.",
    },
    "springs": {
        "tissue": "What the chosen springs are made of.",
        "prestress": "By which part they are drawn too long.",
    },
    "joint": {
        "springs": "Which sets or bodies are joined: springs from SET to SET.",
        "tissue": "What the springs are made of.",
        "rupture": "Whether springs break beyond their fraction force.",
    },
    "tool": {"kind": "Which instrument it is."},
    "force": {"kind": "Which force it is.", "acts": "The set or body that it acts on."},
    "surface": {"kind": "How the surface is drawn."},
    "scale": {
        "evenly": "Cuts the range into equal parts, one for each of these words.",
        "applies": "What one value belongs to: a spring, a node, or the whole body.",
        "otherwise": "The word that holds where no rule speaks.",
    },
    "rules": {
        "conjunction": "What becomes of degrees that are joined by and.",
        "disjunction": "What becomes of degrees that are joined by or.",
        "implication": "What the degree of a rule does to the word that it concludes.",
        "result": "How a number is taken from what all rules conclude.",
        "if": "A rule: what follows for quantities from words of properties.",
    },
    "output": {
        "trajectory": "Positions of all nodes, or of some, at regular times.",
        "surface": "A smooth surface through a body at regular times.",
        "precision": "Whether positions are kept with single or double precision.",
        "energy": "Energies of the whole scene, and how far their sum drifts.",
    },
}

#: What places and springs are chosen by.
CONDITIONS = {
    "x": "First coordinate of a node, or of the middle of a spring, as drawn.",
    "y": "Second coordinate of a node, or of the middle of a spring, as drawn.",
    "z": "Third coordinate of a node, or of the middle of a spring, as drawn.",
    "id": "Id of a node or spring.",
    "length": "Drawn length of a spring.",
    "region": "Region of the body: region is NAME.",
    "group": 'Group of the mesh file: group is "NAME".',
    "surface": "True on the surface of the mesh.",
    "bending": "True for springs that resist bending only.",
}

#: Words that end names.
RESERVED = {
    "at": "When something happens, or is expected.",
    "from": "Where or when something begins, or what lets go.",
    "to": "Where or when something ends.",
    "every": "The time between repetitions or samples.",
    "until": "Up to here: a time, or the end of a plateau of a scale.",
    "after": "A time after the beginning of the block around it.",
    "by": "How far, by which factor, by which part the truth may differ, or by which source.",
    "with": "What something is done with: a tool, a force, a knot, columns.",
    "along": "In which direction, or along which path.",
    "across": "Kept for later versions; it cannot stand inside a name.",
    "through": "A point that a plane or an axis goes through, or a nozzle.",
    "facing": "The direction that a plane faces.",
    "of": "What something belongs to, or is measured of.",
    "on": "On what: log scale, each node.",
    "in": "In what: a unit, a vocabulary, a list of ids.",
    "as": "Kept for later versions; it cannot stand inside a name.",
    "like": "The tissue whose entries are taken over first.",
    "per": "The length of spring that a value holds for, or what has a number of its own.",
    "using": "The course in time of a motion or a force, or the column of a table.",
    "over": "Over the whole run: over run.",
    "around": "The axis of a turn, or what was expected of a number.",
    "weighing": "The weight of a rule, above 0 and up to 1, or of a fit.",
    "if": "Begins a rule.",
    "then": "What a rule concludes.",
    "and": "Both; also joins limits and conclusions.",
    "or": "One or the other, or both.",
    "not": "The opposite.",
    "is": "Chooses a word.",
    "where": "A condition that nodes or springs meet.",
    "when": "A condition that the script waits for; it fires once.",
    "within": "No further than a distance from a point.",
    "between": "From a lower limit to an upper one, both included.",
    "language": "The version of the language, on the first line of every text.",
}
