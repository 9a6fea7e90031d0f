import { useState } from "react";
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

/** For so long the browser may take the file. */
const KEPT_MS = 60_000;

function download(name: string, content: Blob): void {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(content);
  link.download = name;
  link.click();
  window.setTimeout(() => URL.revokeObjectURL(link.href), KEPT_MS);
}
