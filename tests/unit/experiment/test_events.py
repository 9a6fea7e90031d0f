"""Events happen once, in time, in an order that does not depend on how they are written down."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from golden import Golden

from nrp_core.errors import ExperimentError, SceneError, TopicError
from nrp_core.experiment.events.events import Events, action_of, trigger
from nrp_core.experiment.model.event_schema import Event
from nrp_core.experiment.model.section import Place
from nrp_core.findings import Code
from nrp_core.messages.geometry_msgs import Twist, Vector3
from nrp_core.messages.std_msgs import Bool, Float64, Float64MultiArray, String
from nrp_core.observables.observable import Surroundings
from nrp_core.observables.positions import GroundPositions
from nrp_core.world.world import World

GLASS = "/wall/body/glass/color"
MS = 1_000_000


@pytest.fixture
def where(world: World) -> GroundPositions:
    return GroundPositions(world)


Add = Callable[..., None]


@pytest.fixture
def events() -> Events:
    return Events()


@pytest.fixture
def add(events: Events, world: World, where: GroundPositions) -> Add:
    """Add an event as an experiment file writes it."""

    def added(name: str, **fields: Any) -> None:
        event = Event.model_validate(fields)
        actions = [action_of(publish, world) for publish in event.publish]
        events.add(name, trigger(event, Surroundings(world, where)), actions)

    return added


def color_of(world: World) -> Any:
    latest = world.subscribe(GLASS).latest
    assert latest is not None
    return latest.message.r, latest.message.g, latest.message.b


def test_an_event_happens_once_at_the_first_step_not_before_its_time(events: Events, add: Add) -> None:
    add("late", at="30 ms")
    assert [events.fire_due(t * 20 * MS) for t in range(4)] == [[], [], ["late"], []]
    assert events.times == {"late": 40 * MS}


def test_a_publication_of_an_event_acts_from_its_time_on(events: Events, add: Add, world: World) -> None:
    add("red", at="0 s", publish={"topic": GLASS, "value": "Gazebo/RedGlow"})
    assert color_of(world) != (1, 0, 0)
    events.fire_due(0)
    assert color_of(world) == (1, 0, 0)


def test_a_request_that_the_world_rejects_ends_the_run(world: World, golden: Golden) -> None:
    """Otherwise a run would pass that never made the push in its file."""
    at = Place(Path("push.yaml"), 7, 3)
    value = {"model_state": {"model_name": "gone"}}
    publish = {"topic": "/gazebo/set_model_state", "value": value}
    (request,) = Event.model_validate({"at": "0 s", "publish": publish}).publish
    with golden.raises(ExperimentError, match="'gone'") as caught:
        action_of(request, world, at)()
    assert (caught.value.path, caught.value.line) == (at.path, 7)
    action_of(request, world)()  # in an experiment that is not strict it is a warning
    assert Code.NRP280 in [each.code for each in world.warnings]


@pytest.mark.parametrize("service", ["apply_body_wrench", "clear_body_wrenches", "apply_joint_effort"])
def test_a_part_that_a_model_lacks_is_found_before_the_run(
    world: World, service: str, golden: Golden
) -> None:
    """A model that is not there yet may still come; the parts of one that is there do not change."""
    field = "joint_name" if "joint" in service else "body_name"
    for name, is_known in (
        ("wall::glas", False),
        ("later::glas", True),
        ("wall::body", "joint" not in service),
    ):
        publish = {"topic": f"/gazebo/{service}", "value": {field: name}}
        (request,) = Event.model_validate({"at": "0 s", "publish": publish}).publish
        if is_known:
            action_of(request, world)
        else:
            with golden.raises(SceneError, match=name.partition("::")[2]):
                action_of(request, world)


def test_an_event_may_publish_several_messages(events: Events, add: Add, world: World) -> None:
    world.declare("/mood", Float64)
    mood = world.subscribe("/mood")
    add("red", at="0 s", publish=[{"topic": GLASS, "value": "red"}, {"topic": "/mood", "value": 1}])
    events.fire_due(0)
    assert color_of(world) == (1, 0, 0)
    assert mood.latest is not None
    assert mood.latest.message == Float64(1.0)


@pytest.mark.parametrize("order", [("first", "second", "third"), ("third", "second", "first")])
def test_an_event_that_waits_for_another_happens_after_it_wherever_it_stands(
    events: Events, add: Add, order: tuple[str, ...]
) -> None:
    waiting: dict[str, dict[str, Any]] = {
        "first": {"at": "20 ms"},
        "second": {"when": {"event": "first"}},
        "third": {"when": {"event": "second", "after": "40 ms"}},
    }
    for name in order:
        add(name, **waiting[name])
    fired = {t: events.fire_due(t * MS) for t in range(0, 100, 20)}
    assert fired == {0: [], 20: ["first", "second"], 40: [], 60: ["third"], 80: []}


def test_a_model_that_comes_near_a_visual_lets_an_event_happen(
    events: Events, add: Add, world: World, where: GroundPositions
) -> None:
    near = {"model": "husky", "visual": "wall/body/glass", "within": "1 m"}
    add("arrived", when={"near": near})
    drive = world.advertise("/husky/cmd_vel")
    arrived: list[float] = []
    for step in range(1, 200):
        drive.publish(Twist(Vector3(1.0, 0.0, 0.0)))
        world.run_until(step * 20 * MS)
        where.refresh()
        if events.fire_due(world.now_ns):
            arrived.append(where.ground("husky")[0])
    assert arrived == [pytest.approx(1.99, abs=0.02)]


def test_all_conditions_of_an_event_must_hold_at_once(events: Events, add: Add) -> None:
    near = {"model": "husky", "point": [0, 0], "within": "1 m"}
    add("first", at="40 ms")
    add("both", when={"near": near, "event": "first"})
    assert events.fire_due(20 * MS) == []
    assert events.fire_due(40 * MS) == ["first", "both"]


@pytest.mark.parametrize(
    ("condition", "values"),
    [({"above": 0.5}, [0.5, 0.6]), ({"below": 0.5}, [0.5, 0.4]), ({"equals": 2}, [1, 2]),
     ({"above": 0, "below": 1}, [1, 0.5])],
)  # fmt: skip
def test_a_topic_that_says_something_lets_an_event_happen(
    events: Events, add: Add, world: World, condition: dict[str, float], values: list[float]
) -> None:
    world.declare("/mood", Float64)
    add("mood", when={"topic": {"name": "/mood", **condition}})
    assert events.fire_due(0) == []  # nothing has been said yet
    said = world.advertise("/mood")
    fired = []
    for step, value in enumerate(values):
        said.publish(Float64(float(value)))
        fired.append(bool(events.fire_due(step)))
    assert fired == [False, True]


@pytest.mark.parametrize(
    ("kind", "condition", "message"),
    [
        (Float64, {"equals": "fast"}, "'equals'.*'fast'.*'data'.*/mood"),
        (Float64, {"equals": True}, "'equals'.*'data'.*/mood"),
        (Bool, {"equals": 1}, "'equals'.*'data'.*/mood"),
        (Bool, {"above": 0}, "'above'.*'below'.*'data'.*/mood"),
        (String, {"below": 1}, "'above'.*'below'.*'data'.*/mood"),
        (Twist, {"field": "linear", "equals": 0}, "'equals'.*'linear'.*/mood.*Vector3"),
        (Float64MultiArray, {"equals": 0.5}, "'equals'.*0.5.*'data'.*/mood"),
    ],
)
def test_a_message_on_a_topic_is_compared_only_with_its_own_type(
    add: Add, world: World, kind: type, condition: dict[str, Any], message: str, golden: Golden
) -> None:
    world.declare("/mood", kind)
    with golden.raises(TopicError, match=message):
        add("mood", when={"topic": {"name": "/mood", **condition}})


@pytest.mark.parametrize(("kind", "value"), [(Bool, True), (String, "go"), (Float64, 2)])
def test_a_topic_can_be_awaited_to_say_exactly_something(
    events: Events, add: Add, world: World, kind: type, value: Any
) -> None:
    world.declare("/mood", kind)
    add("mood", when={"topic": {"name": "/mood", "equals": value}})
    world.advertise("/mood").publish(kind(float(value) if kind is Float64 else value))
    assert events.fire_due(0) == ["mood"]


@pytest.mark.parametrize(
    ("fields", "error", "message"),
    [
        ({"at": "0 s", "publish": {"topic": "/wall/body/glass/colour", "value": "red"}}, TopicError,
         "'/wall/body/glass/colour'.*'/wall/body/glass/color'"),
        ({"at": "0 s", "publish": {"topic": GLASS, "value": "rde"}}, TopicError, "no material 'rde'"),
        ({"at": "0 s", "publish": {"topic": "/gazebo/model_states", "value": {}}}, TopicError,
         ""),
        ({"when": {"topic": {"name": GLASS, "above": 1}}}, TopicError, "'data'"),
        ({"when": {"topic": {"name": "/husky/cmd_vel", "field": "linear.x", "above": 1}}}, TopicError,
         ""),
        ({"when": {"near": {"model": "hsky", "point": [0, 0], "within": 1}}}, SceneError,
         "'hsky'.*'husky'"),
        ({"when": {"near": {"model": "husky", "other": "crt", "within": 1}}}, SceneError,
         "'crt'.*'cart'"),
        ({"when": {"near": {"model": "husky", "visual": "wall/body/glas", "within": 1}}}, SceneError,
         "'wall/body/glas'.*'wall/body/glass'"),
    ],
)  # fmt: skip
def test_an_event_that_refers_to_a_missing_thing_is_refused(
    add: Add, fields: dict[str, Any], error: type[Exception], message: str, golden: Golden
) -> None:
    with golden.raises(error, match=message):
        add("wrong", **fields)
