"""``nrp conformance`` where nothing is simulated; what it tells of real backends is tested with them."""

import pytest


def test_a_backend_that_is_not_installed_is_named_with_similar_ones(nrp):
    done = nrp("conformance", "brain", "evnt")
    assert done.code == 4
    assert "evnt" in done.err
    assert "event" in done.err


@pytest.mark.parametrize("option", ["tolerance", "=3"])
def test_an_option_without_key_or_value_is_wrong_usage(nrp, option):
    done = nrp("conformance", "brain", "event", "-o", option)
    assert done.code == 2
    assert "KEY=VALUE" in done.err


def test_a_report_that_could_not_be_written_is_refused_before_anything_runs(nrp, tmp_path):
    for report, told in (
        (tmp_path / "no" / "report.json", "the folder does not exist"),
        (tmp_path, "is a folder"),
    ):
        done = nrp("conformance", "brain", "event", "--report", report)
        assert done.code == 2
        assert told in " ".join(done.err.split())


@pytest.mark.parametrize("kind", ["body", ""])
def test_there_are_brains_and_worlds(nrp, kind):
    assert nrp("conformance", kind, "event").code == 2
