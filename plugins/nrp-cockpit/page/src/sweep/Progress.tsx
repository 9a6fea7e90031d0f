import { Icon } from "../ui/Icon";
import type { Sweep } from "./store";

/** How many runs there are, how they ended, and what the report of the command says first. */
export function Progress({ sweep }: { sweep: Sweep }) {
  const { runs, ended, failed, passed, not_passed, in_table, design, keys, remarks } = sweep;
  const varied = keys.map(({ short }) => short).join(", ") || "only the seed";
  return (
    <section className="panel sweep-progress" aria-label="Progress">
      <div className="row">
        <b className="num">
          {ended} of {runs} runs
        </b>
        <progress aria-label="Runs that have ended" max={Math.max(runs, 1)} value={ended} />
        {passed > 0 && (
          <span className="ok-t row tight">
            <Icon name="check" small />
            {passed} passed
          </span>
        )}
        {not_passed > 0 && (
          <span className="warn-t row tight">
            <Icon name="close" small />
            {not_passed} not passed
          </span>
        )}
        {failed > 0 && (
          <span className="bad-t row tight">
            <Icon name="error" small />
            {failed} ended by an error
          </span>
        )}
        <span className="grow" />
        <span className="mut cut">
          {design} of {varied}
        </span>
      </div>
      {in_table < ended && (
        <p className="mut">
          The tables hold {in_table} runs; the command adds the others when it ends or is stopped.
        </p>
      )}
      {remarks.map((remark) => (
        <p key={remark} className="warn-t row tight">
          <Icon name="warning" small />
          <span>{remark}</span>
        </p>
      ))}
    </section>
  );
}
