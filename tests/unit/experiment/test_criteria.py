"""Criteria: passed, failed or not decided, and since when."""

from math import hypot
from typing import Any

import pytest
from golden import Golden

from nrp_core.errors import TopicError
from nrp_core.experiment.events.criteria import Judge, Verdict, judge_of
from nrp_core.experiment.events.events import Times
from nrp_core.experiment.events.sentences import near_sentence
from nrp_core.experiment.model.event_schema import Criterion, Near
from nrp_core.messages.geometry_msgs import Twist, Vector3
from nrp_core.messages.std_msgs import Float64
from nrp_core.observables.observable import Surroundings
from nrp_core.observables.positions import GroundPositions, target_of
from nrp_core.scene.model import Joint, Link, Model, Scene
from nrp_core.scene.rigid import Pose
from nrp_core.world.world import World

MS = 1_000_000
TO_GLASS = {"model": "husky", "visual": "wall/body/glass", "within": "1 m"}


def judged(world: World, criterion: dict[str, Any], times: Times, *, speed: float, steps: int = 150) -> Judge:
    """Drive the husky forward for 3 s, look at every step."""
    where = GroundPositions(world)
    judge = judge_of(Criterion.model_validate(criterion), Surroundings(world, where))
    drive = world.advertise("/husky/cmd_vel")
    for step in range(steps):
        judge.evaluate(step * 20 * MS, {k: t for k, t in times.items() if t <= step * 20 * MS})
        drive.publish(Twist(Vector3(speed, 0.0, 0.0)))
        world.run_until((step + 1) * 20 * MS)
        where.refresh()
    return judge


def test_coming_near_in_time_passes_and_reports_when(world: World) -> None:
    criterion = {"near": TO_GLASS, "within_of": {"event": "red", "time": "2 s"}}
    outcome = judged(world, criterion, {"red": 500 * MS}, speed=1.0).outcome
    assert outcome.passed is True
    assert outcome.decided_s == 2.0
    assert outcome.took_s == 1.5
    assert outcome.distance == pytest.approx(0.99)


def test_coming_near_too_late_fails_as_soon_as_the_time_is_over(world: World) -> None:
    criterion = {"near": TO_GLASS, "within_of": {"event": "red", "time": "1 s"}}
    outcome = judged(world, criterion, {"red": 500 * MS}, speed=1.0).outcome
    assert outcome.passed is False
    assert outcome.decided_s == 1.52
    assert outcome.reason.startswith("no nearer than 1.49 m")


def test_the_degree_of_coming_near_is_the_share_of_the_way(world: World) -> None:
    """It starts 2.49 m away, comes within 1.49 m of the glass, and should have come within 1 m."""
    criterion = {"near": TO_GLASS, "within_of": {"event": "red", "time": "1 s"}}
    assert judged(world, criterion, {"red": 500 * MS}, speed=1.0).outcome.degree == pytest.approx(1 / 1.49)
    world.reset()
    assert judged(world, {"near": TO_GLASS}, {}, speed=1.0).outcome.degree == 1.0
    world.reset()
    assert judged(world, {"near": TO_GLASS}, {}, speed=0.0).outcome.degree == 0.0


def test_the_degree_of_staying_is_the_share_of_the_steps_also_after_leaving(world: World) -> None:
    """Of the 51 looks from 0 to 1 s, 26 are within half a metre; the verdict is that of the first beyond."""
    stays = {"stays_within": {"model": "husky", "distance": "0.505 m", "during": {"until": "1 s"}}}
    judge = judged(world, stays, {}, speed=1.0)
    assert judge.outcome.degree == pytest.approx(26 / 51)
    assert (judge.outcome.decided_s, judge.outcome.distance) == (0.52, pytest.approx(0.52))
    saved = judge.save()
    judge.evaluate(world.now_ns, {})
    judge.restore(saved)
    assert judge.outcome.degree == pytest.approx(26 / 51)


def test_being_near_before_the_event_does_not_count(world: World) -> None:
    near = {
        "near": {"model": "husky", "point": [0, 0], "within": "0.5 m"},
        "within_of": {"event": "red", "time": "1 s"},
    }
    assert judged(world, near, {"red": 1000 * MS}, speed=1.0).outcome.passed is False


def test_an_event_that_never_happens_leaves_open_until_a_whole_run_is_over(world: World) -> None:
    criterion = {"near": TO_GLASS, "within_of": {"event": "red", "time": "1 s"}}
    judge = judged(world, criterion, {}, speed=1.0)
    assert judge.outcome.passed is None
    judge.finish(world.now_ns)
    assert judge.outcome == Verdict(
        False, 3.0, None, None, 1.0, "was never evaluated: red did not happen", 0.0
    )


def test_a_criterion_that_begins_after_the_end_says_so_in_seconds(world: World, golden: Golden) -> None:
    stays = {
        "stays_within": {"model": "husky", "distance": "1 m", "of": "start", "during": {"since": "24 s"}}
    }
    judge = judged(world, stays, {}, speed=1.0)
    judge.finish(world.now_ns)
    golden(judge.outcome.reason)


def test_without_an_event_any_time_will_do(world: World) -> None:
    near = {"near": {"model": "husky", "other": "cart", "within": "4.1 m"}}
    assert judged(world, near, {}, speed=0.1).outcome.decided_s == 0.0


def test_never_coming_near_fails_at_the_end(world: World, golden: Golden) -> None:
    judge = judged(world, {"near": TO_GLASS}, {}, speed=0.1)
    assert judge.outcome.passed is None
    judge.finish(world.now_ns)
    assert judge.outcome.passed is False
    golden(judge.outcome.reason)


def test_staying_passes_at_the_end_and_knows_how_far_it_went(world: World) -> None:
    judge = judged(world, {"stays_within": {"model": "husky", "distance": "0.5 m"}}, {}, speed=0.1)
    judge.finish(world.now_ns)
    assert judge.outcome.passed is True
    assert judge.outcome.distance == pytest.approx(0.298)


def test_leaving_fails_at_once(world: World) -> None:
    outcome = judged(world, {"stays_within": {"model": "husky", "distance": "0.51 m"}}, {}, speed=1.0).outcome
    assert outcome.passed is False
    assert outcome.decided_s == 0.52


def test_staying_until_an_event_is_decided_by_it(world: World) -> None:
    stays = {"stays_within": {"model": "husky", "distance": "0.5 m", "during": {"until": "red"}}}
    outcome = judged(world, stays, {"red": 400 * MS}, speed=1.0).outcome
    assert (outcome.passed, outcome.decided_s) == (True, 0.4)


def test_staying_in_a_period_without_a_step_is_not_passed(world: World, golden: Golden) -> None:
    period = {"since": "101 ms", "until": "119 ms"}  # steps are at 100 and 120 ms
    stays = {"stays_within": {"model": "husky", "distance": "0.5 m", "during": period}}
    outcome = judged(world, stays, {}, speed=1.0).outcome
    assert (outcome.passed, outcome.degree) == (False, 0.0)
    golden(outcome.reason)


def test_staying_from_an_event_on_starts_where_the_model_is_then(world: World) -> None:
    stays = {"model": "husky", "distance": "0.5 m", "during": {"since": "red", "until": "1.4 s"}}
    outcome = judged(world, {"stays_within": stays}, {"red": 1000 * MS}, speed=1.0).outcome
    assert outcome.passed is True
    assert outcome.distance == pytest.approx(0.4)


def test_staying_near_a_place_counts_from_that_place(world: World) -> None:
    stays = {"model": "husky", "distance": "0.5 m", "of": [1, 0]}
    assert judged(world, {"stays_within": stays}, {}, speed=0.0, steps=2).outcome.passed is False


def test_a_moment_that_is_not_on_a_step_cuts_before_the_next_one(world: World) -> None:
    stays = {"model": "husky", "distance": "0.51 m", "during": {"until": "510 ms"}}
    outcome = judged(world, {"stays_within": stays}, {}, speed=1.0).outcome
    assert (outcome.passed, outcome.distance) == (True, pytest.approx(0.5))


CALM = {"name": "/level", "below": 0.5}


@pytest.mark.parametrize(
    ("since", "level", "passed", "reason"),
    [
        ("20 ms", 0.2, True, "/level stayed below 0.5"),
        ("20 ms", 0.7, False, "/level was 0.7 at 0.04 s, not below 0.5"),
        ("0 ms", 0.2, False, "/level was without a value at 0 s, not below 0.5"),
        ("start", 0.2, True, "/level stayed below 0.5"),  # from the first message on
        ("start", 0.7, False, "/level was 0.7 at 0.04 s, not below 0.5"),
    ],
)
def test_a_topic_that_stays_within_its_range_passes(
    world: World, since: str, level: float, passed: bool, reason: str
) -> None:
    world.declare("/level", Float64)
    criterion = {"topic_stays": CALM | {"during": {"since": since, "until": "60 ms"}}}
    where = GroundPositions(world)
    judge = judge_of(Criterion.model_validate(criterion), Surroundings(world, where))
    says = world.advertise("/level")
    for step, value in enumerate((0.1, level, 0.1, 9.0)):  # after the last moment anything may be said
        judge.evaluate(step * 20 * MS, {})
        says.publish(Float64(value))
        world.run_until((step + 1) * 20 * MS)
    judge.finish(world.now_ns)
    assert (judge.outcome.passed, judge.outcome.reason) == (passed, reason)


def test_a_topic_that_never_carries_a_message_does_not_stay_in_its_range(world: World) -> None:
    world.declare("/level", Float64)
    judge = judge_of(
        Criterion.model_validate({"topic_stays": CALM}), Surroundings(world, GroundPositions(world))
    )
    for step in range(3):
        judge.evaluate(step * 20 * MS, {})
    assert judge.outcome.passed is None
    judge.finish(60 * MS)
    assert (judge.outcome.passed, judge.outcome.reason) == (False, "/level never carried a message")


@pytest.mark.parametrize(
    ("wrong", "message"), [({"name": "/levle"}, "'/level'"), ({"field": "x"}, "no field 'x'")]
)
def test_a_missing_topic_or_field_is_refused(world: World, wrong: dict[str, str], message: str) -> None:
    world.declare("/level", Float64)
    around = Surroundings(world, GroundPositions(world))
    with pytest.raises(TopicError, match=message):
        judge_of(Criterion.model_validate({"topic_stays": CALM | wrong}), around)


def test_distances_to_a_moving_visual_follow_its_model(world: World) -> None:
    near = Near.model_validate({"model": "cart", "visual": "husky/base/glass", "within": "1 m"})
    where = GroundPositions(world)
    distance = near_sentence(near, Surroundings(world, where)).observable
    assert distance.value(0) == pytest.approx(3.0)
    world.advertise("/husky/cmd_vel").publish(Twist(Vector3(40.0, 0.0, 0.0)))
    world.run_until(100 * MS)
    where.refresh()
    assert distance.value(world.now_ns) == pytest.approx(hypot(3.0, 4.0 - 0.01))


def test_a_visual_that_a_joint_moves_has_no_known_distance(room: Scene, golden: Golden) -> None:
    (visual,) = room.model("cart").links[0].visuals
    links = (Link("base"), Link("arm", visuals=(visual,)), Link("hand", visuals=(visual,)))
    joints = (Joint("elbow", "revolute", "base", "arm"), Joint("wrist", "fixed", "arm", "hand"))
    scene = room.with_model(Model("crane", links, joints, pose=Pose((9.0, 0.0, 0.0))))
    near = Near.model_validate({"model": "husky", "visual": "crane/hand/glass", "within": "1 m"})
    assert near.visual is not None
    with golden.raises(ValueError, match="'crane/hand'.*'elbow'"):
        target_of(near.visual, scene)
