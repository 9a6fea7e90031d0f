"""Every misspelt or misplaced element and attribute of an old experiment is reported."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from xml.etree import ElementTree as ET

import pytest
from nrp_legacy.document_checks import check_documents
from nrp_legacy.documents import read_bibi, read_experiment

from nrp_core.findings import Code

_FREE = ("somethingNew", "cameraPose", "connectors", "device", "deviceGroup", "returnValue")
"""Unknown elements, those without an effect, and building blocks, which are refused when they are read."""
_TOLERATED = ("somethingNew", "inside", "processes", "schemaLocation")


def _said(exc: Path, bibi: Path) -> list[str]:
    return [f"{one.code}: {one.message}" for one in check_documents(read_experiment(exc), read_bibi(bibi))]


def _misspelt(name: str) -> str:
    """Return a name without its second last letter; a short one with two exchanged, or twice."""
    space, brace, word = name.rpartition("}")
    wrong = word[:-2] + word[-1] if len(word) > 3 else word[::-1] if len(word) > 1 else word * 2
    return space + brace + wrong


def _places(root: ET.Element) -> Iterator[tuple[int, str]]:
    """Yield the number of each element outside of building blocks, with no attribute and with each one."""
    parents = {child: parent for parent in root.iter() for child in parent}
    for number, element in enumerate(root.iter()):
        above, names = element, [element.tag.rpartition("}")[2]]
        while above in parents:
            above = parents[above]
            names.append(above.tag.rpartition("}")[2])
        if not {*names} & {*_FREE}:
            yield from ((number, attribute) for attribute in ("", *element.attrib))


@pytest.mark.parametrize("folder", ["students_2018", "screens_2016", "floreano_2018", "p3dx_2018"])
def test_every_misspelt_element_and_attribute_of_old_documents_is_reported(corpus: Path, folder: str) -> None:
    (exc,), (bibi,) = ((corpus / folder).glob(pattern) for pattern in ("*.exc", "*.bibi"))
    before, tried, silent = _said(exc, bibi), 0, []
    for document in (exc, bibi):
        original = document.read_bytes()
        for number, attribute in _places(ET.fromstring(original)):
            root = ET.fromstring(original)
            element = list(root.iter())[number]
            name = attribute or element.tag
            if name.rpartition("}")[2] in _TOLERATED or "}" in attribute:  # xsi:type is a word of XML
                continue
            if attribute:
                element.attrib[_misspelt(name)] = element.attrib.pop(name)
            else:
                element.tag = _misspelt(name)
            document.write_bytes(ET.tostring(root))
            tried += 1
            if not {*_said(exc, bibi)} - {*before}:
                silent.append(f"{document.name}: <{element.tag} {attribute}>")
        document.write_bytes(original)
    assert tried > 20
    assert silent == []


_EXC = """<ExD><name>n</name><timeout>1</timeout>
  <environmentModel src="r.sdf"><robotPose x="0"/></environmentModel><bibiConf src="b.bibi"/>{}</ExD>"""
_BIBI = """<bibi xmlns:t="urn:t">{}<bodyModel>h.sdf</bodyModel>
  <transferFunction t:type="PythonTransferFunction" src="f.py"/></bibi>"""


def _doubts(folder: Path, exc: str = _EXC.format(""), bibi: str = _BIBI.format("")) -> list[tuple[Code, str]]:
    (folder / "e.exc").write_text(exc)
    (folder / "b.bibi").write_text(bibi)
    found = check_documents(read_experiment(folder / "e.exc"), read_bibi(folder / "b.bibi"))
    return [(one.code, one.message) for one in found]


@pytest.mark.parametrize(
    ("old", "new", "code", "said"),
    [
        ("<brainModel>", "<brainModel><flie>b.py</flie>", Code.NRP216,
         "<flie> is ignored; did you mean <file>?"),
        ("<brainModel>", "<file>b.py</file><brainModel>", Code.NRP216,
         "<file> in <bibi> is ignored; it belongs in <environmentModel> or <brainModel> or <bodyModel>"),
        (">h.sdf<", ">h.sdf<brainModel/><", Code.NRP269,
         "<brainModel> in <bodyModel> is ignored; it belongs in <bibi>"),
        ('src="f.py"/>', 'src="f.py"><transferFunction src="g.py"/></transferFunction>', Code.NRP272,
         "<transferFunction> in <transferFunction> is ignored; it belongs in <bibi>"),
        ('src="f.py"', 'scr="f.py"', Code.NRP216, "the attribute 'scr' is ignored; did you mean 'src'?"),
        (' src="f.py"', "", Code.NRP272,
         "the transfer function is left out: it names no file and holds no code"),
        ("PythonTransferFunction", "PytonTransferFunction", Code.NRP216,
         "the type of <transferFunction> is 'PytonTransferFunction'; did you mean 'PythonTransferFunction'?"),
        ("<brainModel>", "<mode>SynchronuosPynnNestSimulation</mode><brainModel>", Code.NRP216,
         "the <mode> 'SynchronuosPynnNestSimulation' is not known: is 'Synchronuos' meant as 'Synchronous'?"),
        ("bibi xm", "ibbi xm", Code.NRP216, "the document begins with <ibbi>; did you mean <bibi>?"),
    ],
)  # fmt: skip
def test_a_slip_in_a_bibi_document_is_reported(
    tmp_path: Path, old: str, new: str, code: Code, said: str
) -> None:
    text = _BIBI.format("<brainModel></brainModel>").replace(old, new)
    found = _doubts(tmp_path, bibi=text.replace("</bibi", "</ibbi") if "ibbi" in new else text)
    assert any(one is code and said in message for one, message in found), found


@pytest.mark.parametrize(
    "other",
    [
        "<mode>SynchronousPynnNestSimulation</mode>",
        "<mode>AsynchronousSpinnakerSimulation</mode>",
        "<mode>DistributedNestSimulation</mode>",
        "<configuration type='retina' src='r.py'/><extRobotController>x.sh</extRobotController>",
        "<brainModel customAsset='1' assetPath='b.zip'><file/></brainModel><gain>1</gain>",
        "<connectors name='c' weights='1'/><synapseDynamics name='d' u='1'/>",
        "<transferFunction>pass</transferFunction><transferFunctionInline>pass</transferFunctionInline>",
    ],
)
def test_what_documents_of_any_year_hold_is_not_reported(tmp_path: Path, other: str) -> None:
    assert _doubts(tmp_path, bibi=_BIBI.format(other)) == []


def test_an_empty_value_of_a_start_pose_is_reported(tmp_path: Path) -> None:
    (found,) = _doubts(tmp_path, exc=_EXC.format("").replace('x="0"', 'x="0" yaw=""'))
    assert found == (Code.NRP216, "'yaw' of a start pose is empty: not used")
    more = "<cameraPose><cameraPosition x='1'/></cameraPose><visualModel src='v' scale='1'/><own><x/></own>"
    assert _doubts(tmp_path, exc=_EXC.format(more)) == []
