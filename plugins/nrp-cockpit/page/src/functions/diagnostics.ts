import type { Action, Diagnostic } from "@codemirror/lint";
import type { Text } from "@codemirror/state";
import { sameFile } from "../state/paths";
import type { Finding } from "../state/types";
import { findingNote } from "./editor/findingNote";
import { editOf } from "./quickFix";

const severities = { error: "error", warning: "warning", note: "info" } as const;

/** The findings of a file: those of its draft if it has one, else those of the run. */
export function findingsOf(
  path: string,
  drafts: Readonly<Record<string, string>>,
  checked: readonly Finding[],
  ofRun: readonly Finding[],
): Finding[] {
  const from = path in drafts ? checked : ofRun;
  return from.filter(({ file }) => file !== null && sameFile(file, path));
}

/** Findings as marks under the text of their lines; one without a line, or beyond the end, stands at the nearest. */
export function diagnosticsOf(findings: readonly Finding[], doc: Text): Diagnostic[] {
  return findings.map((finding) => {
    const line = doc.line(Math.min(Math.max(finding.line ?? 1, 1), doc.lines));
    const indent = line.text.length - line.text.trimStart().length;
    return {
      from: line.from + indent,
      to: line.to,
      severity: severities[finding.weight],
      source: finding.code,
      message: finding.summary,
      renderMessage: () => findingNote(finding),
      actions: editOf(finding, doc) ? [actionOf(finding)] : [],
    };
  });
}

/** What a click on the fix of a finding does, in words. */
export const fixName = ({ instead }: Finding): string => `Replace with ${instead?.meant}`;

/** The fix of a finding, found again when it is asked for: the text may have moved since. */
const actionOf = (finding: Finding): Action => ({
  name: fixName(finding),
  apply: (view) => {
    const { state } = view;
    const edit = state.readOnly ? null : editOf(finding, state.doc);
    if (edit) view.dispatch(edit);
  },
});

const same = (a: Finding, b: Finding) =>
  a.code === b.code && a.summary === b.summary && a.file === b.file && a.line === b.line;

/** The findings of a check that the run does not have: a check looks at the whole experiment. */
export const newIn = (checked: readonly Finding[], ofRun: readonly Finding[]): Finding[] =>
  checked.filter((finding) => !ofRun.some((known) => same(known, finding)));
