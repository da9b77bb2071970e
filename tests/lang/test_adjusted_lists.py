"""Several parameters in one ``adjust``, and limits in the words of other sentences."""

import pytest

from tests.every import every
from tissuec.core.errors import CompileError
from tissuec.core.source import Source
from tissuec.lang.parser import parse

FORMS = {
    "adjust stiffness and damping": "adjust = [stiffness, damping]",
    "adjust [stiffness, damping]": "adjust = [stiffness, damping]",
    "adjust stiffness, damping and mass": "adjust = [stiffness, damping, mass]",
    "adjust = stiffness and damping": "adjust = [stiffness, damping]",
    "adjust = [Young's modulus] and [density]": "adjust = [Young's modulus, density]",
    "adjust [stiffness, damping] of bed": "adjust stiffness of bed; adjust damping of bed",
    "adjust a of x and b of y": "adjust a of x; adjust b of y",
    "adjust a of x, b of x from 1 to 2": "adjust a of x from 1 to 2; adjust b of x from 1 to 2",
    "adjust a of x between 1 Pa and 9 Pa": "adjust a of x from 1 Pa to 9 Pa",
    "adjust a around 1 Pa 10 %": "adjust a around 1 Pa by 10 %",
}


@every(("written", "right"), FORMS.items())
def test_what_is_meant_is_proposed(written, right):
    text = f"language 1\nlearn gum {{\n  {written}\n}}\n"
    with pytest.raises(CompileError) as error:
        parse(Source("scene.tis", text))
    (finding,) = error.value.diagnostics
    (edit,) = (one.at(finding.span) for one in finding.hint.edits)
    mended = text[: edit.span.start] + edit.text + text[edit.span.end :]
    assert mended == text.replace(written, right)
    assert parse(Source("scene.tis", mended))
