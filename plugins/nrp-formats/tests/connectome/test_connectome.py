"""Tables of connectomes become networks: each edge once, its sign and its names."""

import json
import re
from pathlib import Path

import numpy as np
import pyarrow as pa
import pytest
from golden import Golden
from hypothesis import given, settings
from hypothesis import strategies as st
from nrp_experiments import worm
from nrp_experiments.worm.tables import main
from nrp_formats.connectome.network import Connectome, read_connectome
from pyarrow import csv, feather, parquet

from nrp_core.errors import NetworkError
from nrp_core.network.data import Network

ROOT = 720575940600000000
"""An id of FlyWire is longer than a float can hold."""
WRITERS = {".csv": csv.write_csv, ".feather": feather.write_feather, ".parquet": parquet.write_table}


def write(path: Path, **columns: object) -> Path:
    WRITERS[path.suffix](pa.table(columns), str(path))
    return path


def excited(edges: Path, neurons: Path | tuple[Path, ...] = (), **options: object) -> Connectome:
    """Read a connectome whose edges of unknown sign excite."""
    return read_connectome(edges, neurons, unknown="excite", **options)


def edges_of(network: Network) -> set[tuple[int, int, float]]:
    return {
        (int(pre), int(post), round(float(weight), 4))
        for one in network.projections
        for pre, post, weight in zip(one.pre_index, one.post_index, one.weight, strict=True)
    }


@pytest.mark.parametrize("suffix", WRITERS)
@settings(max_examples=10, deadline=None)
@given(
    rows=st.lists(
        st.tuples(st.integers(0, 9), st.integers(0, 9), st.integers(-40, 40)), min_size=1, max_size=30
    )
)
def test_each_edge_arrives_once_with_its_sign(
    rows: list[tuple[int, int, int]], suffix: str, tmp_path_factory: pytest.TempPathFactory
) -> None:
    rows = [row for row in {row[:2]: row for row in rows}.values() if row[2]] or [(0, 1, 1)]
    pre, post, weight = (list(column) for column in zip(*rows, strict=True))
    folder = tmp_path_factory.mktemp("table")
    path = write(
        folder / f"edges{suffix}", pre=[ROOT + i for i in pre], post=[ROOT + i for i in post], weight=weight
    )
    made = excited(path, unit_mv=0.5)
    place = {one: k for k, one in enumerate(sorted({*pre, *post}))}
    assert edges_of(made.network) == {(place[a], place[b], 0.5 * w) for a, b, w in rows}
    assert made.left_out == 0


def test_a_table_of_neurons_gives_order_groups_and_signs(tmp_path: Path) -> None:
    """In the columns of MaleCNS; edges to fragments, which are in no table of neurons, are left out."""
    neurons = write(
        tmp_path / "neurons.feather",
        bodyId=[30, 10, 20], type=["MN9", "GRN", "MN9"], somaSide=["L", "R", "R"],
        consensus_nt=["glutamate", "acetylcholine", None], x=[1.0, 2.0, 3.0], y=[0.0] * 3, z=[0.0] * 3,
    )  # fmt: skip
    edges = write(
        tmp_path / "edges.feather", body_pre=[30, 10, 20, 99], body_post=[10, 20, 30, 10], weight=[3, 4, 5, 6]
    )
    made = excited(edges, neurons)
    assert edges_of(made.network) == {(0, 1, -0.825), (1, 2, 1.1), (2, 0, 1.375)}
    assert (made.left_out, made.unknown) == (1, {"MN9": 1})
    views = {name: ids.tolist() for name, ids in made.network.views.items()}
    assert views["MN9"] == [0, 2]
    assert (views["MN9_left"], views["MN9_right"], views["glutamate"]) == ([0], [2], [0])
    assert made.network.populations["brain"].positions_um is not None
    assert excited(edges, neurons, groups=("GRN*",)).network.views.keys() == {"GRN", "GRN_right"}


@pytest.mark.parametrize("column", ["nt", "neurotransmitter", "predicted_nt"])
def test_other_names_of_the_column_of_transmitters_say_the_signs_as_well(tmp_path: Path, column: str) -> None:
    path = write(
        tmp_path / "edges.csv",
        pre=[ROOT, ROOT + 1],
        post=[ROOT + 1, ROOT],
        weight=[2, 4],
        **{column: ["GABA", "ACH"]},
    )
    assert edges_of(read_connectome(path).network) == {(0, 1, -0.55), (1, 0, 1.1)}


def test_cells_with_names_are_wired_by_them(tmp_path: Path, golden: Golden) -> None:
    """In the columns of the worm's table (Cook et al. 2019), with blanks around the names."""
    edges = write(
        tmp_path / "edges.csv",
        Source=["DD01 ", "AVAL ", "AVAL ", "AVAL"], Target=["AVAL", "DD01", "PVCL", "muscle"],
        Weight=[2, 3, 5, 7], Type=["chemical", "chemical", "electrical", "chemical"],
    )  # fmt: skip
    alone = excited(edges, unit_mv=1.0)
    assert {name: ids.tolist() for name, ids in alone.network.views.items()} == {
        "AVAL": [0], "DD01": [1], "PVCL": [2], "muscle": [3],
    }  # fmt: skip
    assert edges_of(alone.network) == {(1, 0, 2.0), (0, 1, 3.0), (0, 3, 7.0), (0, 2, 0.0005)}
    assert [one.synapse_type for one in alone.network.projections] == ["static", "electrical"]
    assert alone.left_out == 0
    neurons = write(
        tmp_path / "neurons.feather", name=["PVCL", "DD01", "AVAL"], transmitter=[None, "GABA", None]
    )
    made = excited(edges, neurons, unit_mv=1.0, junction_ns=0.0)
    assert edges_of(made.network) == {(1, 2, -2.0), (2, 1, 3.0)}
    assert made.left_out == 1
    assert made.network.views["AVAL"].tolist() == [2]
    twice = write(tmp_path / "twice.feather", name=["DD01", "AVAL", "DD01"])
    with golden.raises(NetworkError, match="DD01.*'name'"):
        read_connectome(edges, twice)


def junctions_of(path: Path) -> set[tuple[int, int, float]]:
    network = excited(path, junction_ns=1000.0).network
    (electrical,) = [one for one in network.projections if one.is_electrical]
    assert not electrical.delay_ms.any()
    found = zip(electrical.pre_index, electrical.post_index, electrical.weight, strict=True)
    return {(int(pre), int(post), float(weight)) for pre, post, weight in found}


def test_a_gap_junction_is_one_whether_a_table_has_it_from_one_cell_or_both(tmp_path: Path) -> None:
    """In columns of WormAtlas, where both cells of a synapse have a row, and of White et al., with tabs."""
    atlas = write(
        tmp_path / "atlas.csv",
        **{
            "Neuron 1": ["A", "B", "A", "A", "B", "B", "A", "C"],
            "Neuron 2": ["B", "A", "B", "B", "A", "A", "C", "C"],
            "Type": ["EJ", "EJ", "S", "Sp", "R", "Rp", "EJ", "EJ"],
            "Nbr": [4, 5, 1, 2, 1, 2, 3, 9],
        },
    )
    assert junctions_of(atlas) == {(0, 1, 5.0), (0, 2, 3.0)}
    chemical = [one for one in excited(atlas, unit_mv=1.0).network.projections if not one.is_electrical]
    assert [(one.pre_index.tolist(), one.post_index.tolist(), one.weight.tolist()) for one in chemical] == [
        ([0], [1], [3.0])
    ]
    white = tmp_path / "white.csv"
    white.write_text("pre\tpost\ttype\tsynapses\nB\tA\telectrical\t4\nA\tC\tElectrical\t1\nA\tC\tgap\t2\n")
    assert junctions_of(white) == {(0, 1, 4.0), (0, 2, 3.0)}
    signed = write(
        tmp_path / "signed.parquet",
        pre=["A", "A", "B"], post=["B", "B", "A"], weight=[1, 2, 3],
        type=["gap junction", "chemical", "chemical"], nt_type=[None, "GABA", "ACH"],
    )  # fmt: skip
    assert junctions_of(signed) == {(0, 1, 1.0)}


def test_flywires_tables_have_signs_of_their_own(tmp_path: Path) -> None:
    codex = {"pre_root_id": [ROOT, ROOT + 1], "post_root_id": [ROOT + 1, ROOT]}
    path = write(
        tmp_path / "codex.csv", **codex, neuropil=["A", "B"], syn_count=[2, 4], nt_type=["GABA", "ACH"]
    )
    assert edges_of(read_connectome(path).network) == {(0, 1, -0.55), (1, 0, 1.1)}
    index = {"Presynaptic_Index": [0, 1], "Postsynaptic_Index": [1, 0], "Connectivity": [2, 4]}
    shiu = {"Presynaptic_ID": [ROOT, ROOT + 1], "Postsynaptic_ID": [ROOT + 1, ROOT], "Excitatory": [-1, 1]}
    path = write(tmp_path / "shiu.parquet", **shiu, **index, **{"Excitatory x Connectivity": [-2, 4]})
    assert edges_of(read_connectome(path).network) == {(0, 1, -0.55), (1, 0, 1.1)}


def test_signs_in_a_column_of_their_own_are_used(tmp_path: Path, golden: Golden) -> None:
    """Shiu's table without the column of the products; of its counts alone nothing is known."""
    ends = {"Presynaptic_ID": [1, 2], "Postsynaptic_ID": [2, 1], "Connectivity": [2, 4]}
    signed = write(tmp_path / "signed.parquet", **ends, Excitatory=[-1, 1])
    assert edges_of(read_connectome(signed).network) == {(0, 1, -0.55), (1, 0, 1.1)}
    counted = write(tmp_path / "counted.parquet", **ends)
    assert edges_of(excited(counted).network) == {(0, 1, 0.55), (1, 0, 1.1)}
    twice = write(tmp_path / "twice.parquet", **{**ends, "Connectivity": [-2, 4]}, Excitatory=[-1, 1])
    with golden.raises(NetworkError, match="'Connectivity'.*-2"):
        read_connectome(twice)


def test_missing_positions_are_reported(tmp_path: Path) -> None:
    edges = write(tmp_path / "edges.csv", pre=[1, 2], post=[2, 1], weight=[3, 4])
    for x, told in (([1.0, None], ("1 of 2 neurons have no position; theirs is 0, 0, 0",)), ([1.0, 0.0], ())):
        placed = write(tmp_path / "placed.parquet", id=[1, 2], x=x, y=[2.0, 3.0], z=[0.0, 0.0])
        assert excited(edges, placed).network.remarks == told


@pytest.mark.parametrize(
    ("columns", "message"),
    [
        (
            {"prae": [1], "post": [2], "weight": [1]},
            "",
        ),
        (
            {"pre": [1.5], "post": [2], "weight": [1]},
            "'pre'",
        ),
        (
            {"pre": np.array([1, 2**64 - 1], np.uint64), "post": [2, 3], "weight": [1, 1]},
            "'pre'.*18446744073709551615",
        ),
        ({"pre": [1, -1], "post": [2, 3], "weight": [1, 1]}, "'pre'.*-1"),
        (
            {"pre": [1], "post": [2], "weight": ["many"]},
            "'weight'",
        ),
        ({"pre": [1], "post": [2], "weight": [float("inf")]}, "'weight'"),
        (
            {"pre": [1], "post": [2], "weight": [1], "nt_type": ["ABBA"]},
            "'ABBA'",
        ),
    ],
)
def test_each_wrong_table_is_one_error_with_the_file_and_the_column(
    columns: dict[str, list[object]], message: str, tmp_path: Path, golden: Golden
) -> None:
    path = write(tmp_path / "wrong.parquet", **columns)
    with golden.raises(NetworkError, match=message) as raised:
        read_connectome(path)
    assert "wrong.parquet" in str(raised.value)


def test_a_neuron_that_is_there_twice_and_a_file_that_is_none_are_errors(
    tmp_path: Path, golden: Golden
) -> None:
    edges = write(tmp_path / "edges.csv", pre=[1], post=[2], weight=[1])
    twice = write(tmp_path / "neurons.csv", id=[1, 2, 1])
    with golden.raises(NetworkError, match="'id'"):
        read_connectome(edges, twice)
    (tmp_path / "text.parquet").write_text("not a table")
    for name, message in (
        ("text.parquet", "cannot be read"),
        ("none.csv", "no such file"),
        ("a.xlsx", "not a table"),
    ):
        with pytest.raises(NetworkError, match=message):
            read_connectome(tmp_path / name)
    with golden.raises(NetworkError, match="'MN8'"):
        excited(edges, write(tmp_path / "more.csv", id=[1, 2], type=["MN9", "MN9"]), groups=("MN8",))


@pytest.mark.parametrize("suffix", WRITERS)
def test_a_column_that_is_there_twice_is_refused_where_it_is_read(
    tmp_path: Path, suffix: str, golden: Golden
) -> None:
    columns, path = [pa.array([1, 2]) for _ in range(5)], tmp_path / f"edges{suffix}"
    WRITERS[suffix](pa.Table.from_arrays(columns, names=["pre", "post", "weight", "x", "weight"]), str(path))
    with golden.raises(NetworkError, match="'weight'"):
        read_connectome(path)
    WRITERS[suffix](pa.Table.from_arrays(columns, names=["pre", "post", "weight", "x", "x"]), str(path))
    assert excited(path).network.projections[0].size == 2


def test_names_of_the_middle_are_one_side(tmp_path: Path) -> None:
    edges = write(tmp_path / "edges.csv", pre=[1], post=[2], weight=[1])
    sides = ["L", "rigth", "left", "", "centre", "Central", "centered", "M"]
    network = excited(edges, write(tmp_path / "sides.csv", id=[*range(1, 9)], side=sides)).network
    views = {name: ids.tolist() for name, ids in network.views.items()}
    assert views == {"left": [0, 2], "rigth": [1], "center": [4, 5, 6, 7]}


# of the pharynx (Albertson and Thomson 1976), of the mechanosensory and command cells (White et al. 1986)
CLASSES = {"I[1-6]": 8, "M[1-5]": 7, "MC": 2, "MI": 1, "NSM": 2, "ALM": 2, "PLM": 2, "AV[ABDE]": 8, "CAN": 2}


def test_the_worm_that_ships_has_the_neurons_of_its_anatomy():
    folder = Path(worm.__file__).parent
    read = excited(folder / "edges.csv", folder / "neurons.csv")
    (cells,) = read.network.populations.values()
    assert cells.size == 302
    names = set(read.network.views) - {"gaba"}
    assert len(names) == 302
    for form, count in CLASSES.items():
        assert sum(re.fullmatch(f"{form}[LR]?", name) is not None for name in names) == count, form
    assert len(read.network.views["gaba"]) == 26  # McIntire et al. (1993)
    assert "C. elegans, Cook et al. (2019)" in read.sources[str(folder / "edges.csv")]
    assert read.left_out == 0


def test_the_tables_of_the_worm_are_the_neurons_and_chemical_synapses_of_its_source(tmp_path):
    nodes = ["AVAL", "VD1", "MDL01", "GLRL", "hmc", "ASHL"]
    synapses = [[0, 3, 4, 0, 5, 0], [0, 0, 0, 0, 2, 0], *[[0] * 6] * 3, [15, 0, 0, 1, 0, 0]]
    source = {"nodes": nodes, "connections": {"Generic_CS": synapses, "Generic_GJ": [[9] * 6] * 6}}
    (tmp_path / "worm.json").write_text(json.dumps(source))
    main(tmp_path / "worm.json", tmp_path)
    assert (tmp_path / "edges.csv").read_text() == "pre,post,weight\nAVAL,VD1,3\nASHL,AVAL,15\n"
    found = (tmp_path / "neurons.csv").read_text().split()
    assert found == ["name,transmitter", "ASHL,", "AVAL,", "CANL,", "CANR,", "VD1,gaba"]
