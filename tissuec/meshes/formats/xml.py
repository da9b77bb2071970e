"""XML from untrusted files: document types are refused, so that no entity is expanded.

A few lines of entity definitions unfold into gigabytes ("billion laughs") or fetch other files;
mesh files have no use for them.
"""

from contextlib import suppress
from typing import NoReturn
from xml.etree.ElementTree import Element, TreeBuilder
from xml.parsers import expat

from tissuec.meshes.formats import FormatError


def parse(data: bytes) -> Element:
    """Return the root element.

    Raises:
        FormatError: The XML is malformed or has a document type.
    """
    builder, parser = TreeBuilder(), _parser()
    parser.StartElementHandler = builder.start
    parser.EndElementHandler = builder.end
    parser.CharacterDataHandler = builder.data
    parser.buffer_text = True
    try:
        parser.Parse(data, True)
    except expat.ExpatError as error:
        raise FormatError(f"it is truncated or not XML: {error}") from None
    return builder.close()


def refuse_document_type(data: bytes) -> None:
    """Raise FormatError if XML, which may be broken further on, has a document type."""
    # Raw bytes in the middle of the text are no XML; what comes first has been seen by then.
    with suppress(expat.ExpatError):
        _parser().Parse(data, True)


def _parser() -> expat.XMLParserType:
    parser = expat.ParserCreate()
    parser.StartDoctypeDeclHandler = _refuse
    return parser


def _refuse(*_: object) -> NoReturn:
    raise FormatError("it defines a document type, which mesh files do not need")
