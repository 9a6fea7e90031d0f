import { openPlace } from "../state/place";
import { useRun } from "../state/run";
import type { TimelineData } from "../state/types";
import { Icon } from "../ui/Icon";
import { Tooltip } from "../ui/Tooltip";
import { go } from "./go";
import { here } from "./here";
import { reach, seconds } from "./reach";
import { percent, type Span } from "./scale";

type Event = TimelineData["events"][number];
type Intervention = TimelineData["interventions"][number];
type Edit = TimelineData["edits"][number];
type Failure = TimelineData["failures"][number];

const SHAPES = {
  event: "timeline-diamond",
  intervention: "timeline-triangle",
  edit: "timeline-disc",
  failure: "timeline-square",
};

interface Mark {
  key: string;
  t_s: number;
  look: keyof typeof SHAPES;
  name: string;
  /** What it is and what a click does. */
  words: string;
  onClick: () => void;
}

const eventMark = (event: Event & { t_s: number }): Mark => ({
  key: event.name,
  t_s: event.t_s,
  look: "event",
  name: event.name,
  words: `Event ${event.name} at ${seconds(event.t_s)}: go there`,
  onClick: () => void go(reach(event.t_s, here())),
});

const interventionMark = ({ name, t_s }: Intervention, at: number): Mark => ({
  key: `intervention ${at}`,
  t_s,
  look: "intervention",
  name,
  words: `Intervention ${name} at ${seconds(t_s)}: go there`,
  onClick: () => void go(reach(t_s, here())),
});

const editMark = ({ name, t_s }: Edit, at: number): Mark => ({
  key: `edit ${at}`,
  t_s,
  look: "edit",
  name,
  words: `${name} at ${seconds(t_s)}: go there`,
  onClick: () => void go(reach(t_s, here())),
});

const failureMark = (failure: Failure): Mark => ({
  key: `${failure.function} ${failure.t_s}`,
  t_s: failure.t_s,
  look: "failure",
  name: failure.function,
  words: `${failure.function} failed at ${seconds(failure.t_s)}: ${failure.message}. Open it`,
  onClick: () => {
    const of = useRun.getState().functions?.functions.find((one) => one.name === failure.function);
    if (of) openPlace({ file: of.file, line: of.line });
  },
});

const happened = (event: Event): event is Event & { t_s: number } => event.t_s !== null;

/** What is waited for never takes more of the lane, in percent, and no more than half of what follows the last mark. */
const MOST_WAITING = 40;

/** Events as diamonds, interventions as triangles, changes by hand as discs, failures of functions as red squares, and at the right end what is waited for. */
export function EventLane({ data, span }: { data: TimelineData; span: Span }) {
  const waiting = data.events.filter((event) => event.t_s === null);
  const marks = [
    ...data.events.filter(happened).map(eventMark),
    ...data.interventions.map(interventionMark),
    ...data.edits.map(editMark),
    ...data.failures.map(failureMark),
  ].sort((a, b) => a.t_s - b.t_s);
  const places = marks.map(({ t_s }) => percent(span, t_s));
  const last = Math.max(0, ...places.filter((place) => place < 100));
  const kept = waiting.length > 0 ? Math.min(MOST_WAITING, (100 - last) / 2) : 0;
  return (
    <ul className="timeline-lane" aria-label="Events">
      {marks.map((mark, at) => {
        const from = places[at] ?? 0;
        const room = Math.max(from, Math.min(places[at + 1] ?? 100, 100 - kept)) - from;
        return <MarkItem key={mark.key} mark={mark} from={from} room={room} />;
      })}
      {waiting.length > 0 && <Waiting events={waiting} room={kept} />}
    </ul>
  );
}

/** The name of a mark ends where the next mark begins. */
function MarkItem({ mark, from, room }: { mark: Mark; from: number; room: number }) {
  return (
    <li className="timeline-mark" style={{ left: `${from}%`, maxWidth: `max(10px, ${room}%)` }}>
      <Tooltip text={mark.words}>
        <button
          type="button"
          className={mark.look === "failure" ? "bad-t" : undefined}
          aria-label={mark.words}
          onClick={mark.onClick}
        >
          <i className={SHAPES[mark.look]} />
          <span className="cut">{mark.name}</span>
        </button>
      </Tooltip>
    </li>
  );
}

function Waiting({ events, room }: { events: readonly Event[]; room: number }) {
  const [first, ...others] = events.map(({ name, waits_for }) => `${name}: ${waits_for}`);
  return (
    <Tooltip text={[first, ...others].join("; ")}>
      <li className="timeline-waiting" style={{ maxWidth: `max(28px, ${room}%)` }}>
        <Icon name="clock" small />
        <span className="cut">{first}</span>
        {others.length > 0 && <span aria-hidden="true">+{others.length}</span>}
        <span className="hidden-text">{others.join("; ")}</span>
      </li>
    </Tooltip>
  );
}
