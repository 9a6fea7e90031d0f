"""Connectomes as they are released: counts and signs of each, and what is said of cells without a sign."""

import json
import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pyarrow as pa
import pytest
from golden import Golden
from hypothesis import given, settings
from hypothesis import strategies as st
from nrp_formats.connectome.network import read_connectome
from pyarrow import feather

from nrp_core.errors import NetworkError
from nrp_core.network.data import Network

ROOT = 720575940600000000
MEANS = ("gaba_avg", "ach_avg", "glut_avg", "oct_avg", "ser_avg", "da_avg")


def write(path: Path, *rows: str) -> Path:
    path.write_text("\n".join(rows) + "\n")
    return path


def edges_of(network: Network) -> set[tuple[str, str, float]]:
    names = {int(ids[0]): name for name, ids in network.views.items() if len(ids) == 1}
    return {
        (names.get(int(pre), str(pre)), names.get(int(post), str(post)), round(float(weight), 4))
        for one in network.projections
        for pre, post, weight in zip(one.pre_index, one.post_index, one.weight, strict=True)
    }


def test_flywires_proofread_connections_have_the_sign_of_the_most_probable_transmitter(
    tmp_path: Path,
) -> None:
    shares = [
        (0.7, 0.1, 0.1, 0.0, 0.1, 0.0),
        (0.1, 0.8, 0.1, 0.0, 0.0, 0.0),
        (0.2, 0.2, 0.5, 0.0, 0.1, 0.0),
        (0.0, 0.1, 0.0, 0.0, 0.2, 0.7),
        (None,) * 6,
    ]
    columns = {name: [row[k] for row in shares] for k, name in enumerate(MEANS)}
    ends = {"pre_pt_root_id": [ROOT + k for k in range(5)], "post_pt_root_id": [ROOT] * 5}
    path = tmp_path / "proofread_connections_783.feather"
    table = {**ends, "neuropil": ["AL_R"] * 5, "syn_count": [1, 2, 3, 4, 5], **columns}
    feather.write_feather(pa.table(table), str(path))
    made = read_connectome(path, unit_mv=1.0, unknown="exclude")
    assert edges_of(made.network) == {("0", "0", -1.0), ("1", "0", 2.0), ("2", "0", -3.0), ("3", "0", 4.0)}
    assert made.unknown == {"without a type": 1}


def test_malecns_has_types_and_transmitters_in_two_tables(tmp_path: Path) -> None:
    tables = {
        "connectome-weights": {"body_pre": [11, 12, 13, 14], "body_post": [10] * 4, "weight": [3, 4, 5, 6]},
        "body-annotations": {
            "bodyId": [10, 11, 12, 13, 14], "type": ["MN9", "A", "B", "C", None],
            "superclass": ["vnc_motor", *["cb_intrinsic"] * 4], "somaSide": ["L", "R", "L", "L", None],
        },
        "body-neurotransmitters": {
            "body": [13, 12, 11, 10], "consensus_nt": ["unclear", "acetylcholine", "gaba", "acetylcholine"],
        },
    }  # fmt: skip
    weights, *neurons = (tmp_path / f"{name}.feather" for name in tables)
    for name, columns in tables.items():
        feather.write_feather(pa.table(columns), str(tmp_path / f"{name}.feather"))
    made = read_connectome(weights, neurons, unit_mv=1.0, unknown="exclude")
    found = [(one.pre_index.tolist(), one.weight.tolist()) for one in made.network.projections]
    assert found == [([2], [4.0]), ([1], [-3.0])]
    assert made.network.views["MN9_left"].tolist() == [0]
    assert made.unknown == {"C": 1, "cb_intrinsic": 1}
    assert list(made.sources) == list(map(str, (weights, *neurons)))


def test_a_second_table_must_have_some_of_the_neurons(tmp_path: Path) -> None:
    texts = {
        "edges": "pre,post,weight\n1,2,5\n", "first": "id,type\n1,A\n2,B\n",
        "part": "id,nt_type,x,y,z\n2,ACH,1,2,3\n", "other": "id,nt_type\n7,GABA\n", "none": "id,nt_type\n",
    }  # fmt: skip
    edges, first, part, other, none = (tmp_path / f"{name}.csv" for name in texts)
    for name, text in texts.items():
        (tmp_path / f"{name}.csv").write_text(text)
    made = read_connectome(edges, [first, part], unknown="excite")
    assert [one.startswith("1 of 2 neurons") for one in made.network.remarks] == [True]
    for path in (other, none):
        with pytest.raises(NetworkError, match=path.name):
            read_connectome(edges, [first, part, path], unknown="excite")


@pytest.mark.parametrize("names", ["AVAL AVAR AVBL AVBR", "a b c d"])
def test_glutamate_of_worms_is_not_silently_that_of_flies(tmp_path: Path, names: str) -> None:
    first, *others = names.split()
    edges = write(tmp_path / "edges.csv", "pre,post,weight", *(f"{one},{first},1" for one in others))
    kinds = ("Glutamate", "acetylcholine", "gaba", "glutamate")
    cells = map(",".join, zip((first, *others), kinds, strict=True))
    neurons = write(tmp_path / "neurons.csv", "name,transmitter", *cells)
    remarks = read_connectome(edges, neurons).network.remarks
    assert [re.findall(r"\d+ glut|glutamate", one) for one in remarks] == (
        [["2 glut", "glutamate"]] if first == "AVAL" else []
    )
    rule = write(tmp_path / "rule.csv", "type,sign", "glutamate,excitatory")
    assert not read_connectome(edges, neurons, unknown=rule).network.remarks


def test_hemibrains_connections_have_the_signs_of_a_table_of_neurons(tmp_path: Path) -> None:
    edges = write(
        tmp_path / "traced-total-connections.csv",
        "bodyId_pre,bodyId_post,weight",
        *("1,2,8", "2,3,4", "3,1,2", "3,,9", ",1,7", "1,3,"),
    )
    neurons = write(
        tmp_path / "traced-neurons.csv",
        "bodyId,type,instance,predicted_nt",
        *("1,R1,R1_L,histamine", "2,KC,KC_R,acetylcholine", "3,DN1,DN1_R,", ",X,X_R,gaba"),
    )
    made = read_connectome(edges, neurons, groups=("R1", "KC", "DN1"), unit_mv=1.0, unknown="excite")
    assert edges_of(made.network) == {("R1", "KC", -8.0), ("KC", "DN1", 4.0), ("DN1", "R1", 2.0)}
    assert (made.empty, made.left_out, made.unknown) == (3, 0, {"DN1": 1})
    assert made.network.remarks == ("1 rows of traced-neurons.csv without an id were left out",)


def test_edges_of_unknown_sign_need_a_rule(tmp_path: Path, golden: Golden) -> None:
    edges = write(
        tmp_path / "edges.csv", "pre,post,weight,nt_type", "1,2,3,ACH", "2,1,4,NEU", "3,1,5,", "3,2,1,"
    )
    neurons = write(tmp_path / "neurons.csv", "id,type", "1,A", "2,KC", "3,MBON")
    with golden.raises(NetworkError, match="3 of 4 edges.*'NEU'.*MBON 2, KC 1"):
        read_connectome(edges, neurons)
    for rule, expected in (
        ("exclude", set()),
        ("excite", {("KC", "A", 4.0), ("MBON", "A", 5.0), ("MBON", "KC", 1.0)}),
        ("kc,inhibitory\nMBON,exclude", {("KC", "A", -4.0)}),
        ("neu,excitatory\nMBON,-1", {("KC", "A", 4.0), ("MBON", "A", -5.0), ("MBON", "KC", -1.0)}),
    ):
        table = write(tmp_path / "rule.csv", "type,sign", rule)
        given_rule = rule if rule.isalpha() else table
        made = read_connectome(edges, neurons, unit_mv=1.0, unknown=given_rule)
        assert edges_of(made.network) == {("A", "KC", 3.0), *expected}, rule
    with golden.raises(NetworkError, match="MBON 2"):
        read_connectome(edges, neurons, unknown=write(tmp_path / "kc.csv", "type,sign", "KC,1"))
    with golden.raises(NetworkError, match="'maybe'"):
        read_connectome(edges, neurons, unknown=write(tmp_path / "maybe.csv", "type,sign", "KC,maybe"))
    with golden.raises(NetworkError, match="'excit'"):
        read_connectome(edges, neurons, unknown="excit")


NUMBERS = st.integers(0, 9)


@settings(max_examples=20, deadline=None)
@given(
    chemical=st.lists(st.lists(NUMBERS, min_size=4, max_size=4), min_size=4, max_size=4),
    electrical=st.lists(st.lists(NUMBERS, min_size=4, max_size=4), min_size=4, max_size=4),
)
def test_a_list_a_matrix_and_a_file_of_cect_of_one_worm_are_one_network(
    chemical: list[list[int]], electrical: list[list[int]], tmp_path_factory: pytest.TempPathFactory
) -> None:
    """In the layouts of Witvliet et al. (2021), of SI 5 of Cook et al. (2019), and of cect."""
    folder, cells = tmp_path_factory.mktemp("worm"), ["AVAL", "DD01", "MDL07", "PVCL"]
    chemical[0][1], electrical[1][3], electrical[2][2] = 3, 2, 4
    layers = {"chemical": chemical, "electrical": electrical}
    rows = [
        f"{cells[i]}\t{cells[j]}\t{kind}\t{n}"
        for kind, matrix in layers.items()
        for i, line in enumerate(matrix)
        for j, n in enumerate(line)
        if n
    ]
    listed = write(folder / "witvliet.tsv", "pre\tpost\ttype\tsynapses", *rows)
    for kind, matrix in layers.items():
        lines = [f"{'INTER' if k == 0 else ''},,{cell}," for k, cell in enumerate(cells)]
        body = [line + ",".join(str(n or "") for n in row) for line, row in zip(lines, matrix, strict=True)]
        write(
            folder / f"{kind}.csv", ",,,INTER,,MUSCLES,", ",,,9,8,7,6", ",,," + ",".join(cells), *body,
            ",,," + ",".join(cells),
        )  # fmt: skip
    cect = write(
        folder / "worm.json",
        json.dumps({"nodes": cells, "connections": {"Generic_CS": chemical, "Generic_GJ": electrical}}),
    )
    every = ",".join(cells)
    write(folder / "all.csv", f",{every}", *(f"{cell},0,0,0,0" for cell in cells))
    made = [
        read_connectome(listed, unit_mv=1.0, unknown="excite"),
        read_connectome(
            folder / "chemical.csv", junctions=folder / "electrical.csv", unit_mv=1.0, unknown="excite"
        ),
        read_connectome(cect, unit_mv=1.0, unknown="excite"),
    ]
    assert edges_of(made[0].network) == edges_of(made[1].network) == edges_of(made[2].network)
    assert made[1].network.digest == made[2].network.digest
    assert made[2].self_junctions == sum(electrical[k][k] > 0 for k in range(4)) == made[0].self_junctions
    assert made[2].network.views["muscle"].tolist() == made[2].network.views["MDL07"].tolist() == [2]


def test_layers_of_cect_have_the_signs_of_their_transmitters(tmp_path: Path, golden: Golden) -> None:
    layers = {"GABA": [[0, 3], [0, 0]], "Acetylcholine": [[0, 0], [2, 0]], "Generic_GJ": [[1, 0], [0, 0]]}
    path = write(tmp_path / "signed.json", json.dumps({"nodes": ["DD1", "DB1"], "connections": layers}))
    made = read_connectome(path, unit_mv=1.0)
    assert edges_of(made.network) == {("DD1", "DB1", -3.0), ("DB1", "DD1", 2.0)}
    assert made.self_junctions == 1
    functional = {"nodes": ["A"], "connections": {"Functional": [[1]]}}
    with golden.raises(NetworkError, match="'Functional'"):
        read_connectome(write(tmp_path / "functional.json", json.dumps(functional)))
    with pytest.raises(NetworkError, match="cect"):
        read_connectome(write(tmp_path / "other.json", "[]"))


def test_the_command_asks_for_a_rule_and_says_what_it_did(
    tmp_path: Path, nrp: Callable[..., Any], monkeypatch: pytest.MonkeyPatch, golden: Golden
) -> None:
    monkeypatch.chdir(tmp_path)
    write(
        Path("edges.tsv"),
        "pre\tpost\ttype\tsynapses",
        "A\tB\tchemical\t3",
        "A\tA\telectrical\t1",
        "A\t\tchemical\t1",
    )
    asked = nrp("import-connectome", "edges.tsv", "-o", "worm.nrpnet")
    assert asked.code != 0
    assert not Path("worm.nrpnet").exists()
    done = nrp("import-connectome", "edges.tsv", "-o", "worm.nrpnet", "--unknown", "excite")
    assert done.code == 0
    golden(asked.err + done.err)


def test_text_without_pyarrow_is_the_same_network(tmp_path: Path) -> None:
    rows = [f"{ROOT + k % 7},{ROOT + k % 5},{k - 9 or ''}" for k in range(40)]
    path = write(tmp_path / "edges.csv", "pre,post,weight", *rows)
    script = (
        "import sys; sys.modules['pyarrow'] = None\n"
        "from pathlib import Path; from nrp_formats.connectome.network import read_connectome\n"
        f"print(read_connectome(Path({str(path)!r})).network.digest)"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == read_connectome(path).network.digest


@pytest.mark.parametrize(("row", "told"), [("4,5", "2"), ("1.5,2,3", "whole numbers"), ("x,2,3", "x|signs")])
def test_a_row_that_does_not_fit_is_an_error(row: str, told: str, tmp_path: Path) -> None:
    with pytest.raises(NetworkError, match=told):
        read_connectome(write(tmp_path / "wrong.csv", "pre,post,weight", "1,2,3", row))


def test_an_excluded_transmitter_of_edges_is_left_out_whatever_its_source(tmp_path: Path) -> None:
    edges, neurons, rule = (tmp_path / name for name in ("edges.csv", "neurons.csv", "rule.csv"))
    edges.write_text("pre,post,weight,nt_type\n1,2,3,SER\n1,2,5,ACH\n2,1,1,GABA\n")
    neurons.write_text("root_id,nt_type\n1,ACH\n2,GABA\n")
    rule.write_text("type,sign\nser,exclude\n")
    made = read_connectome(edges, neurons, unit_mv=1.0, unknown=rule)
    assert sorted(w for one in made.network.projections for w in one.weight) == [-1.0, 5.0]
