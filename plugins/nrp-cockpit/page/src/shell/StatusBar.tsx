import { halt } from "../state/commands";
import { useRun } from "../state/run";
import type { Status, TransferFunction } from "../state/types";
import { counted } from "../ui/counts";
import { Icon } from "../ui/Icon";
import { Tooltip } from "../ui/Tooltip";

/** The bottom line: the link, what needs attention, and what a step costs. */
export function StatusBar() {
  const status = useRun((run) => run.status);
  return (
    <footer className="status">
      <LinkState loading={!status} />
      <Attention />
      <span className="grow cut">
        {status?.doing}
        {status?.state === "busy" && (
          <button type="button" className="btn btn-ghost btn-small" onClick={() => void halt()}>
            Stop here
          </button>
        )}
      </span>
      {status && <Costs status={status} />}
    </footer>
  );
}

/** Whether the server answers; `loading`: it does, but has not sent a status yet. */
export function LinkState({ loading = false }: { loading?: boolean }) {
  const link = useRun((run) => run.link);
  const source = useRun((run) => run.experiment?.source);
  if (link.state === "open" && loading) return <span role="status">Loading</span>;
  if (link.state === "open")
    return (
      <span role="status">
        <i className="status-dot" />
        {source === "recording" ? "Recording" : "Live on this machine"}
      </span>
    );
  const words = {
    connecting: "Connecting",
    lost: `The server does not answer. Reconnecting, ${"retry_s" in link ? link.retry_s : 0} s`,
    refused: "No access",
  }[link.state];
  return (
    <span role="status" className="warn-t">
      <i className="status-dot" data-lost />
      {words}
    </span>
  );
}

const hasFailed = ({ failure }: TransferFunction) => failure !== null;
const isOff = ({ active, failure }: TransferFunction) => !active && failure === null;

function Attention() {
  const failed = useRun((run) => run.functions?.functions.filter(hasFailed).length ?? 0);
  const stopped = useRun((run) => run.status?.state === "failed");
  const off = useRun((run) => run.functions?.functions.filter(isOff).length ?? 0);
  const notes = useRun((run) => run.findings.length);
  return (
    <>
      {failed > 0 && (
        <a className="bad-t" href="#/functions">
          <Icon name="error" small />
          {counted(failed, "function")} {stopped ? "failed" : "in quarantine"}
        </a>
      )}
      {off > 0 && (
        <a className="warn-t" href="#/functions">
          <Icon name="note" small />
          {counted(off, "function")} switched off
        </a>
      )}
      {notes > 0 && (
        <a className="mut" href="#/functions">
          <Icon name="note" small />
          {counted(notes, "finding")}
        </a>
      )}
    </>
  );
}

const DROPPED =
  "A page was too slow to receive them: newer images and poses replaced them, and plots show gaps where others are missing";

const percent = (share: number) => `${Math.round(share * 100)} %`;

/** What the parts of a step cost; what the page itself costs is in the tip. */
function Costs({ status: { share, server_ms_per_step, dropped } }: { status: Status }) {
  if (!share) return null;
  const page =
    server_ms_per_step === null ? "" : `This page costs ${server_ms_per_step.toFixed(1)} ms a step. `;
  return (
    <Tooltip text={dropped > 0 ? `${page}${dropped} messages were dropped. ${DROPPED}.` : page}>
      <span className="num">
        brain {percent(share.brain)} · world {percent(share.world)} · functions {percent(share.functions)} ·
        loop {percent(share.loop)}
      </span>
    </Tooltip>
  );
}
