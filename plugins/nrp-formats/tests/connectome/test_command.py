"""``nrp import-connectome`` as it is used."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from golden import Golden

from nrp_core.network.files.network_file import read_network


def test_the_command_writes_a_network_file_and_reports_checksums(
    tmp_path: Path, nrp: Callable[..., Any], monkeypatch: pytest.MonkeyPatch, golden: Golden
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("edges.csv").write_text("pre,post,weight\n1,2,3\n2,1,-1\n2,7,5\n")
    Path("neurons.csv").write_text("id,type\n1,MN9\n2,GRN\n")
    done = nrp("import-connectome", "edges.csv", "--neurons", "neurons.csv", "-o", "brain.nrpnet")
    assert done.code == 0, done.err
    assert "2 neurons, 1 excitatory edges, 1 inhibitory edges, 2 groups" in done.out
    assert done.out.count("sha256") == 2
    golden(done.err)
    network = read_network("brain.nrpnet")
    assert network.populations["brain"].cell_type == "IF_curr_exp_frozen"
    weights = [float(one.weight[0]) for one in network.projections]
    assert weights == pytest.approx([0.825, -0.275], rel=1e-6)
    assert network.views["MN9"].tolist() == [0]


def test_a_table_is_never_overwritten_and_a_missing_folder_is_reported_first(
    tmp_path: Path, nrp: Callable[..., Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("edges.csv").write_text(table := "pre,post,weight\n1,2,3\n")
    for output, message in (
        ("edges.csv", "a network file is called .nrpnet, not 'edges.csv'"),
        ("no/edges.nrpnet", "no: the folder does not exist"),
    ):
        done = nrp("import-connectome", "edges.csv", "-o", output)
        assert done.code == 2
        assert message in " ".join(done.err.split())
    assert Path("edges.csv").read_text() == table


def test_gap_junctions_are_counted_and_have_the_given_conductance(
    tmp_path: Path, nrp: Callable[..., Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("edges.csv").write_text("pre,post,weight,type\n1,2,3,chemical\n2,1,2,electrical\n1,2,2,electrical\n")
    done = nrp("import-connectome", "edges.csv", "--junction-ns", "0.5", "--unknown", "excite")
    assert "2 neurons, 1 excitatory edges, 1 electrical edges" in done.out
    assert [float(one.weight[0]) for one in read_network("edges.nrpnet").projections][1] == pytest.approx(
        1e-3
    )
    assert (
        "electrical"
        not in nrp("import-connectome", "edges.csv", "--junction-ns", "0", "--unknown", "excite").out
    )


def test_a_wrong_table_is_one_error(tmp_path: Path, nrp: Callable[..., Any], golden: Golden) -> None:
    path = tmp_path / "edges.csv"
    path.write_text("from,post,weight\n1,2,3\n")
    done = nrp("import-connectome", path)
    assert done.code != 0
    golden(done.err)
    assert str(path) in done.err


@pytest.mark.parametrize(("option", "name"), [("--unit-mv", "unit_mv"), ("--delay-ms", "delay_ms")])
def test_a_weight_or_delay_of_nothing_is_refused(
    option: str, name: str, tmp_path: Path, nrp: Callable[..., Any]
) -> None:
    (tmp_path / "edges.csv").write_text("pre,post,weight\n1,2,3\n")
    done = nrp("import-connectome", tmp_path / "edges.csv", option, "0")
    assert done.code != 0
    assert f"{name} is 0; it must be above 0" in done.err


def test_a_table_without_synapses_is_refused(tmp_path: Path, nrp: Callable[..., Any]) -> None:
    (tmp_path / "edges.csv").write_text("pre,post,weight\n1,2,0\n2,1,0\n")
    done = nrp("import-connectome", tmp_path / "edges.csv", "-o", tmp_path / "brain.nrpnet")
    assert done.code != 0
    assert "all 2 edges have 0 synapses" in done.err
