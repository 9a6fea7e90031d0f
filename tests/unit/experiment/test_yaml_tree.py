"""YAML with positions: what it reads, and one clear error for each thing that is not."""

from pathlib import Path

import pytest
from golden import Golden

from nrp_core.errors import ExperimentError
from nrp_core.experiment.model.section import Place
from nrp_core.experiment.reading.yaml_tree import parse_tree, read_tree

FILE = Place(Path("file.yaml"))


def test_quantities_dates_and_slices_stay_texts() -> None:
    tree = parse_tree("{a: 20 ms, b: 0:5, c: 2024-01-01, d: yes}", FILE)
    assert tree.plain() == {"a": "20 ms", "b": "0:5", "c": "2024-01-01", "d": "yes"}


def test_numbers_truth_and_nothing_are_read_as_yaml_1_2_means_them() -> None:
    tree = parse_tree("[1, 1.5, 1e3, true, null, ~, 0x10]", FILE)
    assert tree.plain() == [1, 1.5, 1000.0, True, None, None, 16]


def test_every_value_and_key_knows_its_line_and_column() -> None:
    tree = parse_tree("a:\n  b: [1,  2]\n", FILE)
    second, followed = tree.nearest(("a", "b", 1))
    assert (second.place.line, second.place.column) == (2, 11)
    assert followed == ("a", "b", 1)
    key = tree.nearest(("a", "b"))[0].key_place
    assert key is not None
    assert (key.line, key.column) == (2, 3)


def test_anchors_and_merge_keys_work_and_own_keys_win() -> None:
    tree = parse_tree("base: &base {a: 1, b: 2}\nmore: {b: 3, <<: *base}", FILE)
    assert tree.plain()["more"] == {"a": 1, "b": 3}


def test_of_several_merged_mappings_the_first_wins() -> None:
    tree = parse_tree("x: &x {a: 1}\ny: &y {a: 2, b: 2}\nmore: {<<: [*x, *y]}", FILE)
    assert tree.plain()["more"] == {"a": 1, "b": 2}


@pytest.mark.parametrize(
    ("text", "where", "what"),
    [
        ("a: 1\nb: 2\na: 3", "file.yaml:3:1", "the key 'a' is given twice"),
        ("a: [1, 2", "file.yaml:1:9", "lacks a comma or its end"),
        ("a: 1\n\tb: 2", "file.yaml:2:1", "a tab, where YAML takes only spaces"),
        ("a: b: c", "file.yaml:1:5", "a second ': ' in one value"),
        ("a: *nobody", "file.yaml:1:4", "there is no anchor '&nobody'"),
        ("a: &x [*x]", "file.yaml:1:4", "aliases make this value endless"),
        ("[1]: 2", "file.yaml:1:1", "a key is a text"),
        (
            "a: !!python/object:os.system x",
            "file.yaml:1:4",
            "the tag '!!python/object:os.system' has no meaning",
        ),
        ("a: {<<: 3}", "file.yaml:1:9", "'<<' takes a mapping"),
        ("a: 1\n---\nb: 2", "file.yaml:2:1", "a second document begins here"),
        ("a: \x00", "file.yaml:1", "the character U+0000 is not allowed"),
        ("[" * 1200, "file.yaml", "nested too deeply"),
    ],
)
def test_text_that_is_not_yaml_gets_one_error_at_its_place(text: str, where: str, what: str) -> None:
    with pytest.raises(ExperimentError) as error:
        parse_tree(text, FILE)
    assert str(error.value).startswith(f"{where}: ")
    assert what in str(error.value)


def test_aliases_that_multiply_without_end_are_refused(golden: Golden) -> None:
    lines = ["a0: &a0 [1, 1, 1, 1, 1, 1, 1, 1, 1, 1]"]
    lines += [f"a{n}: &a{n} [{', '.join([f'*a{n - 1}'] * 10)}]" for n in range(1, 9)]
    with golden.raises(ExperimentError):
        parse_tree("\n".join(lines), FILE)


@pytest.mark.parametrize(
    "content",
    [
        b"",
        b"- 1",
        b"\xff\xfe\x00",
        "name: x\n# caf\u00e9".encode("latin-1"),
    ],
)
def test_a_file_that_holds_no_mapping_is_refused(tmp_path: Path, content: bytes, golden: Golden) -> None:
    path = tmp_path / "file.yaml"
    path.write_bytes(content)
    with golden.raises(ExperimentError) as error:
        read_tree(path)
    assert error.value.path == path


def test_a_byte_that_is_not_utf8_is_named_with_its_line_and_column(tmp_path: Path, golden: Golden) -> None:
    file = tmp_path / "e.yaml"
    file.write_bytes("name: x\n# un caf\u00e9\n".encode("latin-1"))
    with golden.raises(ExperimentError, match="UTF-8") as caught:
        read_tree(file)
    assert (caught.value.line, caught.value.column) == (2, 9)


def test_a_file_with_a_byte_order_mark_and_windows_lines_reads_like_any_other(tmp_path: Path) -> None:
    path = tmp_path / "file.yaml"
    path.write_bytes(b"\xef\xbb\xbfa: 1\r\nb: 2\r\n")
    assert read_tree(path).plain() == {"a": 1, "b": 2}


def test_a_missing_file_is_reported_as_missing(tmp_path: Path, golden: Golden) -> None:
    with golden.raises(ExperimentError):
        read_tree(tmp_path / "nothing.yaml")
