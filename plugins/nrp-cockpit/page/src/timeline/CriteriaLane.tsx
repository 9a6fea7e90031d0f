import type { CSSProperties } from "react";
import { notify } from "../state/notices";
import { addTrace } from "../state/traces";
import type { TimelineData } from "../state/types";
import { Icon, type IconName } from "../ui/Icon";
import { Tooltip } from "../ui/Tooltip";
import { seconds } from "./reach";
import { percent, type Span } from "./scale";
import { stack } from "./stack";

const looks = {
  true: { look: "ok", icon: "check", words: "met" },
  false: { look: "bad", icon: "error", words: "not met" },
  null: { look: "open", icon: "clock", words: "not decided yet" },
} as const satisfies Record<string, { look: string; icon: IconName; words: string }>;

/** So many may have a row each. */
const FEW = 4;
/** The words of a bar that begins later, in percent of the lane, reach to the left. */
const LATE = 60;

/** The stretch that a failed criterion and the words beside it take: no other one is below them. */
function withWords({ from_s, to_s }: Span, span: Span): Span {
  return percent(span, from_s) > LATE ? { from_s: span.from_s, to_s } : { from_s, to_s: span.to_s };
}

/** Says why a criterion is not met, and shows what it measures as a curve. */
function explain({ name, from_s, to_s, text, curve }: TimelineData["criteria"][number]): void {
  notify(`${name}, not met at ${seconds(to_s)}, watched from ${seconds(from_s)}: ${text}`);
  if (curve) addTrace({ topic: curve.topic, path: curve.path });
}

/**
 * Criteria as bars over the time that they watch; hatched while they are not decided. The more overlap, the thinner.
 * Those that are not met say why, also beside a short bar; a click on them goes to no other time.
 */
export function CriteriaLane({ criteria, span }: { criteria: TimelineData["criteria"]; span: Span }) {
  const few = criteria.length <= FEW;
  const rows = stack(criteria.map((one) => (few && one.passed === false ? withWords(one, span) : one)));
  const count = Math.max(1, ...rows.map((row) => row + 1));
  return (
    <ul
      className="timeline-lane timeline-criteria"
      aria-label="Criteria"
      style={{ "--rows": count } as CSSProperties}
      data-few={criteria.length < 2}
      data-many={criteria.length > 3}
    >
      {criteria.map((one, at) => {
        const { name, passed, from_s, to_s, text } = one;
        const { look, icon, words } = looks[`${passed}`];
        const from = Math.max(percent(span, from_s), 0);
        const to = Math.min(percent(span, to_s), 100);
        if (to < 0 || from > 100) return null;
        const place = { left: `${from}%`, width: `${to - from}%`, "--row": rows[at] };
        const failed = passed === false;
        const Bar = failed ? "button" : "div";
        return (
          <Tooltip key={name} text={`${name}: ${text || words}`}>
            <li className={`timeline-criterion timeline-${look}`} style={place} data-late={from > LATE}>
              <Bar
                type={failed ? "button" : undefined}
                className="timeline-bar"
                onClick={failed ? () => explain(one) : undefined}
              >
                <Icon name={icon} small />
                <span className="cut">
                  {name}
                  <span className={failed ? undefined : "hidden-text"}>
                    , {words}: {text}
                  </span>
                </span>
              </Bar>
            </li>
          </Tooltip>
        );
      })}
    </ul>
  );
}
