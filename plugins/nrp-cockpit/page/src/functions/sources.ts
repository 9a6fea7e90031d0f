import type { SourceFile } from "../state/types";

/** The files that run, and the edited text of those that differ from it, by their paths. */
export interface Sources {
  files: readonly SourceFile[];
  drafts: Readonly<Record<string, string>>;
}

const runningOf = ({ files }: Sources, path: string) => files.find((file) => file.path === path)?.source;

/** The text that the editor shows: what was edited, else what runs. */
export const textOf = (sources: Sources, path: string): string =>
  sources.drafts[path] ?? runningOf(sources, path) ?? "";

/** Without the drafts that say what runs anyway, and without those of files that are gone. */
function settled(sources: Sources): Sources {
  const drafts = Object.entries(sources.drafts).filter(([path, text]) => {
    const source = runningOf(sources, path);
    return source !== undefined && source !== text;
  });
  return { ...sources, drafts: Object.fromEntries(drafts) };
}

export const edited = (sources: Sources, path: string, text: string): Sources =>
  settled({ ...sources, drafts: { ...sources.drafts, [path]: text } });

const same = (a: SourceFile, b: SourceFile | undefined) =>
  a.path === b?.path && a.source === b.source && a.language === b.language && a.editable === b.editable;

/** Takes over the files as the run has them now; the same object when nothing changed, as each message repeats them. */
export function following(sources: Sources, files: readonly SourceFile[]): Sources {
  const { files: old } = sources;
  if (old.length === files.length && old.every((file, at) => same(file, files[at]))) return sources;
  return settled({ ...sources, files });
}

/** After these texts were applied. What was edited since stays a draft. */
export const applied = (sources: Sources, texts: Readonly<Record<string, string>>): Sources =>
  following(
    sources,
    sources.files.map((file) => ({ ...file, source: texts[file.path] ?? file.source })),
  );
