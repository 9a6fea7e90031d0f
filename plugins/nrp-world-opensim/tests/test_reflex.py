"""The circuits of ``reflex_arm`` answer a load on the arm in OpenSim."""

import nrp_core


def test_the_reflex_answers_the_load_and_is_drawn() -> None:
    with nrp_core.open_run("reflex_arm/opensim", ["criteria.holds_still=null", "duration=1.12 s"]) as run:
        run.run()
        assert run.passed
        assert not [each for each in run.problems if each.level is nrp_core.Level.ERROR]
        assert run.show(width=160, height=120).pixels.std() > 10
    assert "reflex_arm/opensim" in nrp_core.shipped()
