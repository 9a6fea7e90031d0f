import { useState } from "react";
import { download } from "../saving/download";
import { command } from "../state/commands";
import { notify } from "../state/notices";
import { useBlocked, useRun } from "../state/run";
import { Button } from "../ui/Button";

interface SharedFile {
  name: string;
  html: string;
  losses: string[];
}

const WORDS = "Save as one HTML file";
const NOTHING_YET = "Record a part of the run first (R); then it can be saved as one HTML file.";

/** Saves the recording that is shown, or the last one of the run, with this page as one file. */
export function ShareButton() {
  const recorded = useRun((run) => run.status?.recorded ?? null);
  const live = useRun((run) => run.experiment?.source === "live");
  const blocked = useBlocked();
  const [making, setMaking] = useState(false);
  if (recorded === null && !live) return null;
  const save = async () => {
    setMaking(true);
    const file = await command<SharedFile>("share");
    setMaking(false);
    if (!file) return;
    download(file.name, new Blob([file.html], { type: "text/html" }));
    for (const loss of file.losses) notify(loss);
  };
  return (
    <Button
      icon="share"
      className="bar-share"
      aria-label={`Share: ${making ? "the file is being made" : WORDS}`}
      tip={making ? undefined : WORDS}
      busy={making}
      disabled={blocked ?? (recorded === null ? NOTHING_YET : undefined)}
      onClick={() => void save()}
    >
      <span className="wide">Share</span>
    </Button>
  );
}
