"""Leftovers of Python 2 become Python 3 and mean what they meant."""

from __future__ import annotations

import ast
import io
from collections.abc import Callable
from contextlib import redirect_stderr, redirect_stdout
from pathlib import Path

import numpy as np
import pytest
from golden import Golden
from hypothesis import given
from hypothesis import strategies as st
from nrp_legacy.code import Source
from nrp_legacy.convert.python import piece_of
from nrp_legacy.python2 import converted, executable, names
from nrp_legacy.python2_builtins import divide

from nrp_core.errors import TransferFunctionError
from nrp_core.experiment.making.prepare import prepare
from nrp_core.experiment.reading.find import load_experiment


def printed(code: str, **values: object) -> str:
    out = io.StringIO()
    with redirect_stdout(out):
        exec(compile(executable(converted(code)), "code", "exec"), {**names(), **values})
    return out.getvalue()


@pytest.mark.parametrize(
    ("guard", "half"),
    [
        ("try:\n    ask = raw_input\nexcept NameError:\n    ask = input\n", 0.5),
        ("try:\n    ask = raw_input\nexcept (AttributeError, NameError):\n    ask = input\n", 0.5),
        ("import sys\nif sys.version_info[0] < 3:\n    input = raw_input\n", 0.5),
        ("import sys\ntext = unicode if sys.version_info < (3,) else str\n", 0.5),
        ("try:\n    ask = raw_input\nexcept ImportError:\n    ask = input\n", 0),
        ("ask = raw_input\n", 0),
    ],
)
def test_code_for_both_pythons_is_python_3(guard: str, half: float) -> None:
    assert printed(f"{guard}print(1 / 2)") == f"{half}\n"


@pytest.mark.parametrize(
    ("code", "text"),
    [
        ('print "a"', "a\n"),
        ('print "a", 1', "a 1\n"),
        (
            "n = 1\ndef f():\n    for i in n, 3:\n        if i: pass; global n\n    n = i / 2\nf()\nprint n",
            "1\n",
        ),
        ("n = 1\nglobal n\ndef f():\n    global n\n    def n(): return 4\nf()\nprint(n() / 8)", "0\n"),
        ("print", "\n"),
        ('print "%d %s" % (1, "b")', "1 b\n"),
        ('print ("a"), "b"', "a b\n"),
        ('print ("a" + "b") * 2', "abab\n"),
        ('if 1: print "a"; print "b"', "a\nb\n"),
        ('print "a",\nprint "b"', "a b\n"),
        ("print [i for i in (1, 2)][0]", "1\n"),
        ('print "a \\\nb"', "a b\n"),
        ('print {"a": 1}["a"] # print this', "1\n"),
        ('x = 1\nif x <> 2: print "ne"', "ne\n"),
        ("print 0777, 10L", "511 10\n"),
        ("print sorted([(1, 2), (2, 1)], key=lambda (a, b): b)[0], (lambda (a): a)(3)", "(2, 1) 3\n"),
        ("f, g = lambda (a, b): [a, b] if a else {a: b}, 1\nprint f((0, [2]))", "{0: [2]}\n"),
        ('try:\n  raise ValueError, "no"\nexcept (KeyError, ValueError), e:\n  print e', "no\n"),
        ("d = {1: 2}\nprint sorted(d.iteritems()), d.has_key(1)", "[(1, 2)] True\n"),
        ("print 7 / 2, 7.0 / 2, 7 // 2", "3 3.5 3\n"),
        ("print round(2.5), round(-0.5), round(2.675, 2), round(1234.5, -2)", "3.0 -1.0 2.67 1200.0\n"),
        ("print [x for x in 1, 2], [x for y in (1, 2), [3] for x in y if x in y]", "[1, 2] [1, 2, 3]\n"),
        ("print [max(a, b) for a in 1, 2 for b in 3, 4], 2 in [1, 2]", "[3, 4, 3, 4] True\n"),
        ("from __future__ import division\nprint 7 / 2", "3.5\n"),
        ("print list(xrange(2)), unicode(1), long(2), reduce(max, [1, 3])", "[0, 1] 1 2 3\n"),
        ("if 1:\n\tx = 1\n        print x", "1\n"),
        ("print `1 + 1`, 'a `b` 1L 07 <> print'", "2 a `b` 1L 07 <> print\n"),
        ("exec 'x = 1'\nd = {}\nexec 'y = 2' in d\nexec('z = 3')\nprint x, d['y'], z", "1 2 3\n"),
        ("try: raise KeyError, 'k'  # no, 'x'\nexcept KeyError, e: print e", "'k'\n"),
        (
            "import sys\ntry:\n  try: 1 % 0\n  except: raise KeyError, 'k', sys.exc_info()[2]\n"
            "except KeyError, e: print e.args",
            "('k',)\n",
        ),
        ("d = {1: 2}\nk = d.keys()\nk.sort()\nprint k, d.items()[0]", "[1] (1, 2)\n"),
        (
            "print map(None, [1])[0], filter(str.isdigit, 'a1'), zip([1], [2])[0], range(2) + [2]",
            "1 1 (1, 2) [0, 1, 2]\n",
        ),
        (
            "l = [1, 2]\nl.sort(lambda a, b: b - a)\nprint l, sorted(l, cmp), sorted(l, cmp=cmp)",
            "[2, 1] [1, 2] [1, 2]\n",
        ),
        ("print iter([5]).next(), ur'a', ord(97), cmp(1, 2), int('11', 2)", "5 a 97 -1 3\n"),
        ("x = 7\nx /= 2\nprint x", "3\n"),
        ("print 0l, apply(max, (1, 2)), filter(None, (0, 1))", "0 2 (1,)\n"),
        ("print 'az'.encode('hex'), u'a'.encode('utf-8'), 'a'.decode('utf-8')", "617a a a\n"),
        ("class A:\n  def __nonzero__(self): return False\nprint bool(A())", "False\n"),
        ("class A:\n  def __div__(self, other): return 4\nprint A() / 2", "4\n"),
        (
            "class A:\n  def __init__(self, x): self.x = x\n"
            "  def __cmp__(self, other): return cmp(self.x, other.x)\nprint A(1) < A(2), A(1) == A(1)",
            "True True\n",
        ),
        (
            "class A:\n  n = 0\n  def __iter__(self): return self\n  def next(self):\n"
            "    self.n += 1\n    if self.n > 2: raise StopIteration\n    return self.n\nprint list(A())",
            "[1, 2]\n",
        ),
    ],
)
def test_a_leftover_keeps_its_meaning(code: str, text: str) -> None:
    assert printed(code) == text


def test_print_to_a_stream_goes_there() -> None:
    error = io.StringIO()
    with redirect_stderr(error):
        printed('import sys\nprint >>sys.stderr, "a", 1')
    assert error.getvalue() == "a 1\n"


def test_code_of_python_3_stays_as_it_is() -> None:
    code = 'print("a", 1 / 2)\nx = {"print": 3}\n'
    result = converted(code)
    assert ast.unparse(result.tree) == ast.unparse(ast.parse(code))
    assert result.changes == ()


def test_lines_keep_their_numbers() -> None:
    tree = converted('x = 1\n\nprint "a"\nprint x').tree
    assert [statement.lineno for statement in tree.body] == [1, 3, 4]


def test_quotients_of_whole_numbers_can_be_indices_in_code_that_may_be_of_either_python() -> None:
    code = "w = 7\nprint(w / 2, list(range(9))[w / 2 + 1], [0] * 0, 'abcdefgh'[:(w - 1) / 2])"
    assert printed(code) == "3.5 4 [] abc\n"


def test_numbers_in_arrays_of_one_are_numbers() -> None:
    assert printed("print(int(a), float(a), float('2'))", a=np.array([[3]])) == "3 3.0 2.0\n"


def test_three_results_of_contours_are_an_image_and_two() -> None:
    code = "import cv2\nfirst, contours, _ = cv2.findContours(image, cv2.RETR_TREE, cv2.CHAIN_APPROX_NONE)\n"
    image = np.zeros((5, 5), np.uint8)
    image[1:3, 1:3] = 1
    assert printed(code + "print(first is image, len(contours))", image=image) == "True 1\n"


def test_lists_of_python_2_can_still_be_iterators() -> None:
    """They are not iterators for libraries, such as Matplotlib, which refuses those that end."""
    assert (
        printed("m = map(str, [1, 2])\nprint(next(m), next(m), m[0], next(zip([3], [4])))")
        == "1 2 1 (3, 4)\n"
    )
    assert printed("print(next(range(0), 5), next(iter([6])), [x for x in range(2)])") == "5 6 [0, 1]\n"
    code = "from collections.abc import Iterator\nprint(isinstance(range(3), Iterator))"
    assert printed(code) == "False\n"


def test_code_that_is_not_python_is_refused() -> None:
    with pytest.raises(SyntaxError):
        converted("def f(:\n  pass")


@given(st.integers(-100, 100), st.integers(-100, 100).filter(bool))
def test_integers_divide_downwards_and_anything_else_truly(left: int, right: int) -> None:
    assert divide(left, right) == left // right
    assert divide(float(left), right) == left / right


@pytest.mark.parametrize(
    ("code", "text"),
    [
        ("k = {2: 0, 1: 0}.keys()\nk.sort()\nprint(k)", "[1, 2]\n"),
        ("try:\n    raise ValueError('no')\nexcept ValueError as e:\n    print(e.message)", "no\n"),
        ("x = None\nprint(x < 3, 3 > x, x > 3, x <= None)", "True True False True\n"),
        ("print(np.zeros(2, np.uint8).tostring())", "b'\\x00\\x00'\n"),
        ("a = np.zeros((2, 2))\na.itemset((0, 1), 3)\na.itemset(3, 4)\nprint(a.sum(), a.ptp())", "7.0 4.0\n"),
        ("print(ord(np.uint8(97)), ord('a'))", "97 97\n"),
    ],
)
def test_code_may_use_features_of_old_libraries_and_python_2(code: str, text: str) -> None:
    assert printed(code, np=np) == text


def test_code_that_stays_unreadable_is_refused_at_its_line() -> None:
    with pytest.raises(SyntaxError) as error:
        converted("print 'a'\nx = = 3\n")
    assert error.value.lineno == 2


def test_an_import_rounds_as_python_2_did(tmp_path: Path) -> None:
    path = tmp_path / "tf.py"
    path.write_text("print 1\nx = round(2.5)\n")
    piece = piece_of(Source.of_file(path))
    assert not piece.lacks
    scope: dict[str, object] = {}
    exec(piece.text, scope)
    assert scope["x"] == 3.0


def test_a_repeated_argument_is_refused_with_its_line_where_code_is_read(
    tmp_path: Path, golden: Golden
) -> None:
    file = tmp_path / "functions.py"
    file.write_text("import numpy\n\n\ndef drive(t, eye, eye):\n    print eye\n")
    with golden.raises(TransferFunctionError, match="'eye'") as caught:
        Source.of_file(file).tree(lambda *_note, **_about: None)
    assert (caught.value.path, caught.value.line) == (file, 4)


@pytest.mark.parametrize(("bounds", "is_right"), [("0:5 / 2", True), ("5 / 3:5", True), ("0:5 / 2.0", False)])
def test_a_quotient_of_whole_numbers_chooses_neurons_without_a_warning(
    written: Callable[..., Path], bounds: str, is_right: bool
) -> None:
    """It did in Python 2; the quotient of another number did not."""
    brain = "import pyNN.nest as sim\ncircuit = sim.Population(5, sim.IF_cond_alpha())\n"
    functions = f"""import hbp_nrp_cle.tf_framework as nrp
@nrp.MapSpikeSource('noise', nrp.brain.circuit[{bounds}], nrp.poisson)
@nrp.Neuron2Robot()
def drive(t, noise):
    noise.rate = 100.0
"""
    found = prepare(load_experiment(written(brain, functions))).warnings
    assert is_right != any("slice indices must be integers" in one.message for one in found)
