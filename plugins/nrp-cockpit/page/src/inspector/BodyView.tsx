import { useRecorded, useRun } from "../state/run";
import { Icon } from "../ui/Icon";
import { Empty } from "../ui/Panel";
import { PlaceBody, PushBody } from "./BodyActions";
import { BodyColor } from "./BodyColor";
import { BodyTopics } from "./BodyTopics";
import { Title } from "./Facts";
import { LivePose } from "./LivePose";
import { StaticPlace } from "./StaticPlace";

/** A body of the world: where it is, what it publishes, and what may be done with it. */
export function BodyView({ name }: { name: string }) {
  const body = useRun((run) => run.experiment?.bodies.find((one) => one.name === name));
  const robot = useRun((run) => run.experiment?.robots.includes(name));
  const recorded = useRecorded();
  if (!body) return <Empty>The run has no body '{name}' any more.</Empty>;
  return (
    <>
      <Title name={name}>
        {robot ? "robot " : "body "}
        {body.static && (
          <span className="tag">
            <Icon name="lock" small /> static
          </span>
        )}
      </Title>
      {!recorded && <BodyColor key={name} body={body} />}
      {body.static ? <StaticPlace body={name} /> : <LivePose body={name} />}
      <BodyTopics names={body.topics} />
      {!recorded && <PlaceBody key={`place ${name}`} body={name} />}
      {!recorded && !body.static && <PushBody key={`push ${name}`} body={name} />}
      {!recorded && body.static && <p className="panel-section dim f12">A static body cannot be pushed.</p>}
    </>
  );
}
