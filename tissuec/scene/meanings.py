"""What words of the language mean that no schema describes, one sentence each.

Entries that are fields of a class are described there, and verbs, measures, meshes, tools,
laws and methods in their docstrings. The reference and editors show both.
"""

#: What a text is made of.
PARTS = {
    "use": "Includes the definitions of another file: a vocabulary, tissues, or a whole scene.",
    "about": "Describes the file in one sentence.",
    "author": "Names an author of the file; one sentence for each author.",
    "laboratory": "Names the institution of the authors.",
    "licence": "States the licence of the file.",
    "cite": "States how work that uses the file should cite it.",
    "hedge": "A modifier of words that shifts them along their scale or sharpens them.",
    "property": "A property that describes a tissue: a range, and words for its parts.",
    "quantity": "A physical quantity that rules conclude: a range, and words for its parts.",
    "rules": "Rules that conclude words of quantities from words of properties.",
    "law": "Laws of springs and dashpots for use in rows of a table.",
    "tissue": "A material of springs and nodes, given by words of a vocabulary, numbers or "
    "both.",
    "body": "A mesh made of tissue.",
    "joint": "Springs that join bodies.",
    "tool": "An instrument that holds, touches or cuts.",
    "force": "An additional force on nodes, such as that of tissue around a body.",
    "learn": "Fits numbers of tissues, nodes, springs or words to measured data.",
    "study": "Many runs of the scene: what varies, and what is measured.",
    "environment": "Global conditions: gravity, contact, damping.",
    "script": "Actions at given times or conditions.",
    "simulate": "Duration and numerical method of the run.",
    "output": "Contents of the result file.",
    "param": "A number that can be set on the command line, optionally with limits.",
    "let": "A number computed from others.",
    "set": "A named set of nodes or springs, selected on the mesh as drawn.",
    "table": "Nodes or springs of an explicit mesh, one per row.",
    "expect": "An expected result; a failed expectation is reported after the run.",
}

#: Entries of blocks beside those of a schema, by what the block is.
ENTRIES = {
    "tissue": {
        "about": "Describes the tissue and the source of its numbers in one sentence.",
        "described": "The rules that define the words of this tissue: described in RULES.",
        "colour": 'The colour in pictures, in hexadecimal digits: colour = "#7a3b34".',
        "gloss": "How much it shines in pictures, from 0 to 1.",
        "known": "Evidence from a source on a quantity or a curve, as ranges or a number.",
        "spring law": "The law of the springs by name, instead of linear springs.",
        "viscosity law": "The law of the dashpots by name, instead of linear dashpots.",
        "solid law": "The law of bodies made of elements by name, instead of neo-Hookean ones.",
        "spring force": "A formula for the force of a spring as a function of its "
        "elongation e.",
        "stress": "A formula for the nominal stress of a bar as a function of its strain.",
        "viscous force": "A formula for the force of a dashpot as a function of its rate of "
        "elongation w, "
        "or of its elongation e and w.",
    },
    "body": {
        "mesh": "The mesh of nodes and springs.",
        "made": "Whether a solid consists of finite elements or of springs: made of elements.",
        "tissue": "The tissue of the body.",
        "region": "A part of the body with its own tissue or prestress.",
        "springs": "Springs with their own tissue: springs where CONDITION { … }.",
        "rupture": "Whether springs and elements break above their limits.",
        "bending": "Bending resistance of a surface: by springs, or elastic like a wall of "
        "its thickness.",
        "fibres": "The stiffer direction of a tissue with a fibre modulus.",
        "second fibres": "The direction of a second family of fibres, in a body of elements.",
        "prestress": "The direction in which a body of elements is prestressed, or the normal "
        "of the plane in which it is.",
    },
    "environment": {
        "symmetric about plane": "A plane of symmetry: the scene is one side of it.",
    },
    "region": {
        "tissue": "The tissue of the region; by default that of the body.",
        "prestress": "Initial strain of the springs or elements of the region.",
    },
    "interface": {
        "tissue": "The tissue of the springs between two regions.",
        "prestress": "Initial strain of these springs.",
    },
    "springs": {
        "tissue": "The tissue of the selected springs.",
        "prestress": "Initial strain of these springs.",
    },
    "joint": {
        "springs": "The sets or bodies that are joined: springs from SET to SET.",
        "tissue": "The tissue of the springs.",
        "rupture": "Whether springs and elements break above their limits.",
    },
    "tool": {"kind": "The kind of instrument."},
    "force": {"kind": "The kind of force.", "acts": "The set or body that it acts on."},
    "surface": {"kind": "The kind of surface."},
    "scale": {
        "evenly": "Divides the range into equal parts, one for each word.",
        "applies": "The object that one value belongs to: a spring, a node, or the whole body.",
        "otherwise": "The fallback word if no rule fires.",
    },
    "rules": {
        "conjunction": 'The operator for "and".',
        "disjunction": 'The operator for "or".',
        "implication": "How the degree of a rule modifies the word that it concludes.",
        "result": "How a number is computed from the conclusions of all rules.",
        "if": "A rule from words of properties to words of quantities.",
    },
    "output": {
        "trajectory": "Positions of all or some nodes at regular times.",
        "surface": "A smooth surface through a body at regular times.",
        "precision": "Whether positions are stored with single or double precision.",
        "compress": "Makes frames and surfaces smaller, without loss.",
        "blocks": "A file for ParaView with the parts of bodies, beside the result.",
        "energy": "Energies of the whole scene and the drift of their sum.",
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
    "at": "The time of an action or an expectation.",
    "from": "A start point or time, or the tool that releases.",
    "to": "An end point or time.",
    "every": "The time between repetitions or samples.",
    "until": "An end time, or the end of a plateau of a scale.",
    "after": "A time relative to the start of the surrounding block.",
    "by": "A distance, a factor, an expected deviation, or a source.",
    "with": "A tool, a force, a knot or columns.",
    "along": "A direction or a path.",
    "across": "The normal of a plane.",
    "through": "A point on a plane or an axis, or a nozzle.",
    "facing": "The normal direction of a plane.",
    "of": "The object that something belongs to or is measured on.",
    "on": "on log scale, or on each node.",
    "in": "A unit, a vocabulary, or a list of ids.",
    "as": "Reserved for later versions; not allowed in names.",
    "like": "The tissue whose entries are inherited.",
    "per": "The spring length that a value is given for, or the parts with separate numbers.",
    "using": "The time profile of a motion or a force, or the column of a table.",
    "over": "Over the whole run: over run.",
    "around": "The axis of a turn, or the expected value of a number.",
    "weighing": "The weight of a rule (above 0, at most 1) or of a fit; a density.",
    "if": "Begins a rule.",
    "then": "What a rule concludes.",
    "and": "Logical and; also joins limits and conclusions.",
    "or": "Logical or.",
    "not": "Logical not.",
    "is": "Chooses a word.",
    "where": "A condition on nodes or springs.",
    "when": "A condition that triggers an action once.",
    "within": "Within a distance from a point.",
    "between": "Between two limits, both included.",
    "language": "The version of the language, on the first line of every text.",
}
