import type { SourceFile } from "../state/types";

/** The files that run, and the edited text of those that differ from it, by their paths. */
export interface Sources {
  files: readonly SourceFile[];
  drafts: Readonly<Record<string, string>>;
  /** What ran when the editing of each draft began. */
  bases: Readonly<Record<string, string>>;
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
  const bases = drafts.map(([path]) => [path, sources.bases[path] ?? runningOf(sources, path) ?? ""]);
  return { ...sources, drafts: Object.fromEntries(drafts), bases: Object.fromEntries(bases) };
}

export const edited = (sources: Sources, path: string, text: string): Sources =>
  settled({ ...sources, drafts: { ...sources.drafts, [path]: text } });

/** The files that somebody else changed since they were edited here: to apply these drafts would undo that. */
export const conflictsOf = (sources: Sources): string[] =>
  Object.entries(sources.bases).flatMap(([path, base]) => (runningOf(sources, path) === base ? [] : [path]));

/** With the drafts as changes of what runs now. */
export const rebased = (sources: Sources): Sources => settled({ ...sources, bases: {} });

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
    { ...sources, bases: { ...sources.bases, ...texts } },
    sources.files.map((file) => ({ ...file, source: texts[file.path] ?? file.source })),
  );
