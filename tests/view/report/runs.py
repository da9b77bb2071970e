"""Small scenes whose runs have something of everything, and pages about them."""

from html.parser import HTMLParser
from pathlib import Path

from msgspec import Struct, field

from tissuec.pipeline import compile_request, simulate
from tissuec.results.trajectory import Trajectory
from tissuec.scene.request import Request
from tissuec.view.report.content import ReportContent
from tissuec.view.report.page import render

WORDS = """language 1
about "Words that a <b>vocabulary</b> of its own explains & more."
property hardness from 0 to 1 { evenly = [soft, medium, hard] }
quantity spring constant from 2 N/m to 2000 N/m on log scale {
  evenly = [low, medium, high]
  applies to each spring
}
rules simple {
  if hardness is soft then spring constant is low
  if hardness is medium then spring constant is medium
}
tissue strand {
  about "</script><script>alert(1)</script>"
  described in simple
  hardness is between soft and medium
  viscosity = 0.02 N*s/m; mass = 1 g; breaking force = 0.06 N
}
"""
ROD = """language 1
about "A rod <i>&amp;</i> what tears it."
use "./words"
# </code></pre></script><b>bold</b> "quoted" 'single' & more
param far = 6 mm between 0 mm and 20 mm
param idle = 1 mm
body "<b>rod</b> & co" { mesh is explicit; tissue is strand; rupture is allowed }
table nodes of "<b>rod</b> & co" in mm with columns "id x y z" {
  1 0 0 0; 2 10 0 0; 3 20 0 0; 4 30 0 0
}
table springs of "<b>rod</b> & co" with columns "a b" { 1 2; 2 3; 3 4 }
set left = nodes of "<b>rod</b> & co" where x < 1 mm
set "<i>right</i>" = nodes of "<b>rod</b> & co" where x > 29 mm
environment { gravity = (0, 0, -9.81) m/s^2 }
script {
  at 0 s: fix left
  from 0.05 s to 0.15 s: move "<i>right</i>" by (far, 0 mm, 1 mm) using smooth profile
  when ruptured("<b>rod</b> & co"): stop moving "<i>right</i>"
}
simulate { duration = 0.3 s; tolerance = 1e-4 }
output { trajectory every 10 ms; force of "<i>right</i>" every 5 ms; energy every 10 ms }
expect distance(left, "<i>right</i>") > 29 mm over run
expect ruptured("<b>rod</b> & co") at 0.3 s
expect not ruptured("<b>rod</b> & co") at 0.3 s
author "Ada <b>Weiss</b>"
author "Bo Li"
laboratory "Institute & Co"
licence "CC BY 4.0"
cite "Weiss, Li: Rods. 2026."
"""
#: Nodes alone, of which nothing is recorded.
BARE = """language 1
tissue dust { spring constant = 1 N/m; viscosity = 0 N*s/m; mass = 1 g }
body cloud { mesh is explicit; tissue is dust }
table nodes of cloud in mm with columns "id x y z" { 1 0 0 0; 2 10 0 0 }
environment { gravity = (0, 0, -9.81) m/s^2 }
simulate { duration = 0.1 s }
"""
UNSTABLE = """language 1
tissue strand { spring constant = 40 N/m; viscosity = 0 N*s/m; mass = 1 g }
body rod { mesh is explicit; tissue is strand }
table nodes of rod in mm with columns "id x y z" { 1 0 0 0; 2 11 0 0; 3 20 0 0 }
table springs of rod in mm with columns "a b rest length" { 1 2 10; 2 3 10 }
set left = nodes of rod where x < 1 mm
environment { gravity = (0, 0, -9.81) m/s^2 }
script { at 0 s: fix left }
simulate { duration = 2 s; integrator is velocity verlet; step = 20 ms }
output { trajectory every 20 ms }
expect speed(rod) < 1 m/s at 2 s
"""


def run(folder, text, name="scene", *, companion="off", **options):
    """Return the result of a text, run in a folder, whatever became of it."""
    scene = folder / f"{name}.tis"
    scene.write_text(text, encoding="utf-8")
    (folder / "words.tis").write_text(WORDS, encoding="utf-8")
    request = Request.file(scene, **options)
    compiled, _ = compile_request(request)
    return simulate(
        compiled, folder / f"{name}.vtkhdf", request=request, companion=companion
    ).path


def page_of(path, **options):
    """Return the page about a result."""
    with Trajectory.open(Path(path)) as trajectory:
        return render(ReportContent(trajectory, **options))


class Element(Struct):
    """One element of a page; ``text`` is all that stands in it."""

    tag: str
    attributes: dict
    parent: "Element | None" = None
    text: str = ""
    children: list = field(default_factory=list)

    def all(self, tag=None, class_=None):
        """Return the elements inside with a tag and a class, in order."""
        found = []
        for child in self.children:
            classes = (child.attributes.get("class") or "").split()
            if tag in (None, child.tag) and (class_ is None or class_ in classes):
                found.append(child)
            found += child.all(tag, class_)
        return found


class Page(HTMLParser):
    """A page as a tree; fails on tags that are not closed in their order."""

    def __init__(self, document):
        super().__init__(convert_charrefs=True)
        self.root = self.open = Element("document", {})
        self.feed(document)
        self.close()
        assert self.open is self.root, f"<{self.open.tag}> is never closed"
        self.ids = {e.attributes["id"]: e for e in self.root.all() if "id" in e.attributes}

    def handle_starttag(self, tag, attrs):
        names = [name for name, _ in attrs]
        assert len(set(names)) == len(names), f"<{tag}> has an attribute twice"
        element = Element(tag, dict(attrs), self.open)
        self.open.children.append(element)
        if tag not in ("meta", "br", "img"):
            self.open = element

    def handle_startendtag(self, tag, attrs):
        self.handle_starttag(tag, attrs)
        if tag not in ("meta", "br", "img"):
            self.open = self.open.parent

    def handle_endtag(self, tag):
        assert self.open.tag == tag, f"</{tag}> closes <{self.open.tag}>"
        self.open = self.open.parent

    def handle_data(self, data):
        element = self.open
        while element is not None:
            element.text += data
            element = element.parent

    def section(self, key):
        """Return a part of the page, or None."""
        return self.ids.get(key)

    def line(self, target):
        """Return the text of the line to which a link leads, as its file has it."""
        assert target.startswith("#")
        return self.ids[target[1:]].text.rstrip("\n")
