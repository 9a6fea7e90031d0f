import { useState } from "react";
import { download } from "../saving/download";
import { command } from "../state/commands";
import { notify } from "../state/notices";
import { useBlocked, useRun } from "../state/run";
import { IconButton } from "../ui/Button";

interface SharedFile {
  name: string;
  html: string;
  losses: string[];
}

/** Saves the recording that is shown, or the last one of the run, with this page as one file. */
export function ShareButton() {
  const recorded = useRun((run) => run.status?.recorded ?? null);
  const blocked = useBlocked();
  const [making, setMaking] = useState(false);
  if (recorded === null) return null;
  const save = async () => {
    setMaking(true);
    const file = await command<SharedFile>("share");
    setMaking(false);
    if (!file) return;
    download(file.name, new Blob([file.html], { type: "text/html" }));
    for (const loss of file.losses) notify(loss);
  };
  return (
    <IconButton
      icon="share"
      label={making ? "The file is being made" : "Save as one HTML file"}
      busy={making}
      disabled={blocked}
      onClick={() => void save()}
    />
  );
}
