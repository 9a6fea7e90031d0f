import { FirstVisit } from "../hints/FirstVisit";
import { halt } from "../state/commands";
import { useRun } from "../state/run";
import type { Status, TransferFunction } from "../state/types";
import { counted } from "../ui/counts";
import { Icon } from "../ui/Icon";

/** The bottom line: the link, what needs attention, and what a step costs. */
export function StatusBar() {
  const status = useRun((run) => run.status);
  return (
    <footer className="status">
      <LinkState />
      <Attention />
      <FirstVisit />
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

export function LinkState() {
  const link = useRun((run) => run.link);
  const source = useRun((run) => run.experiment?.source);
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
  "Messages that a page was too slow to take: newer images and poses replaced them, and plots show gaps where others are missing";

const percent = (share: number) => `${Math.round(share * 100)} %`;

function Costs({ status: { share, server_ms_per_step, dropped } }: { status: Status }) {
  return (
    <>
      {share && (
        <span className="num">
          brain {percent(share.brain)} · world {percent(share.world)} · functions {percent(share.functions)} ·
          loop {percent(share.loop)}
        </span>
      )}
      {server_ms_per_step !== null && (
        <span className="num wide">page {server_ms_per_step.toFixed(1)} ms a step</span>
      )}
      {dropped > 0 && (
        <span className="num" title={DROPPED}>
          {dropped} dropped
        </span>
      )}
    </>
  );
}
