import { stepBack } from "../state/commands";
import { baseName, sameFile } from "../state/paths";
import { openPlace } from "../state/place";
import { useBlocked, useMissing, useRun } from "../state/run";
import type { Status } from "../state/types";
import { Button } from "../ui/Button";
import { Icon } from "../ui/Icon";

type RunError = NonNullable<Status["error"]>;

/** The message without the place that stands beside it. */
const withoutPlace = ({ message, file, line }: RunError) => {
  const place = `${file}:${line}: `;
  return message.startsWith(place) ? message.slice(place.length) : message;
};

/** What stopped the run: the error, its place, and the two ways on. */
export function ErrorBanner() {
  const error = useRun((run) => run.status?.error ?? null);
  const source = useRun((run) =>
    error?.file ? run.functions?.files.find((one) => sameFile(one.path, error.file ?? ""))?.path : undefined,
  );
  const blocked = useBlocked();
  const noWayBack = useMissing("step_back");
  if (!error) return null;
  return (
    <div className="note note-bad timeline-error" role="alert">
      <Icon name="error" />
      <p className="grow timeline-error-text" title={error.message}>
        {error.file && (
          <code className="mut" title={error.file}>
            {baseName(error.file)}
            {error.line !== null && `:${error.line}`}
          </code>
        )}{" "}
        {withoutPlace(error)}
      </p>
      <Button small icon="stepBack" disabled={blocked ?? noWayBack} onClick={() => void stepBack()}>
        Step back
      </Button>
      {source && (
        <Button small icon="functions" onClick={() => openPlace({ file: source, line: error.line ?? 1 })}>
          Open function
        </Button>
      )}
    </div>
  );
}
