import type { Comparison } from "../difference/comparison";
import { Tooltip } from "../ui/Tooltip";
import { type Difference, differencesOf, stretchesOf, stretchWords } from "./differences";
import { go } from "./go";
import { here } from "./here";
import { reach } from "./reach";
import { percent, type Span } from "./scale";

/** Where two runs differ: the darker, the farther apart; marks where a difference begins. A click goes there. */
export function DifferenceLane({ comparison, span }: { comparison: Comparison; span: Span }) {
  const marks = differencesOf(comparison);
  return (
    <ul className="timeline-lane" aria-label={`Differences from ${comparison.labels[1]}`}>
      {stretchesOf(comparison).map((stretch) => {
        const from = Math.max(percent(span, stretch.from_s), 0);
        const to = Math.min(percent(span, stretch.to_s), 100);
        if (to <= 0 || from >= 100) return null;
        const look = { left: `${from}%`, width: `${to - from}%`, "--share": stretch.share };
        return (
          <Tooltip key={stretch.from_s} text={stretchWords(stretch)}>
            <li className="timeline-stretch" style={look} data-same={stretch.share === 0 || undefined}>
              <span className="hidden-text">{stretchWords(stretch)}</span>
            </li>
          </Tooltip>
        );
      })}
      {marks.map((mark, at) => {
        const from = percent(span, mark.t_s);
        const next = marks[at + 1];
        const room = (next ? percent(span, next.t_s) : Math.max(from, 100)) - from;
        return <MarkItem key={mark.key} mark={mark} from={from} room={room} />;
      })}
    </ul>
  );
}

function MarkItem({ mark, from, room }: { mark: Difference; from: number; room: number }) {
  const words = `${mark.words}: go there`;
  return (
    <li className="timeline-mark" style={{ left: `${from}%`, maxWidth: `max(10px, ${room}%)` }}>
      <Tooltip text={words}>
        <button type="button" aria-label={words} onClick={() => void go(reach(mark.t_s, here()))}>
          <i className="timeline-diamond timeline-apart" />
          <span className="cut">{mark.name}</span>
        </button>
      </Tooltip>
    </li>
  );
}
